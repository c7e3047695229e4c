"""Faults are said in one printable line, and errors carry the exit status of their kind."""

import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scalar.errors import Fault, InvalidInput, NotConverged, ScalarError, Undetermined
from scalar.estimation.setup.suspicion import Suspicion, WrongSetup
from scalar.estimation.sufficiency import FitFailed


def test_a_fault_names_file_row_and_column() -> None:
    """The line reads: file, row, column, what is wrong, what to do."""
    fault = Fault("poses.csv", "not a number ('abc'); write radians as 0.123", 17, "q3")
    assert str(fault) == "poses.csv, row 17, column q3: not a number ('abc'); write radians as 0.123"


@pytest.mark.parametrize("file", ["dataset.yaml", "cell.YML", "calibration.json", "arm.urdf"])
def test_what_is_no_table_has_lines(file: str) -> None:
    assert str(Fault(file, "missing", 17, "planes")) == f"{file}, line 17, planes: missing"


@given(st.text(), st.text(), st.none() | st.text())
def test_a_fault_is_one_printable_line_whatever_it_quotes(
    file: str, message: str, column: str | None
) -> None:
    """No line end and no terminal escape code gets out of a user's file into the message."""
    assert str(Fault(file, message, 3, column)).isprintable()


@pytest.mark.parametrize(
    ("error", "status"),
    [
        (InvalidInput(Fault("a", "b")), 2),
        (Undetermined("too few poses"), 3),
        (NotConverged("stopped"), 3),
        (FitFailed(np.zeros((4, 6))), 3),
        (WrongSetup((Suspicion("joint_sign", "joint 4", "joint 4 counts the other way", 0.2, 1e-4),)), 2),
    ],
    ids=lambda given: type(given).__name__,
)
def test_exit_status_and_survival_of_pickling(error: ScalarError, status: int) -> None:
    """Each kind of error has its exit status, and passes between processes unchanged: the runs of an outer split answer with them."""
    copy = pickle.loads(pickle.dumps(error))
    assert error.exit_status == status
    assert type(copy) is type(error)
    assert str(copy) == str(error)
    assert repr(vars(copy)) == repr(vars(error))


def test_one_line_a_fault() -> None:
    """An error has as many lines as faults, in their order."""
    error = InvalidInput([Fault("a", "one\ntwo"), Fault("b", "three")])
    assert [line.split(":")[0] for line in str(error).splitlines()] == ["a", "b"]


def test_no_kind_of_error_has_a_way_of_its_own_to_another_process() -> None:
    """All kinds, whatever their arguments, are made anew without their ``__init__``."""
    kinds: list[type[ScalarError]] = [ScalarError]
    for kind in kinds:
        assert kind.__reduce__ is ScalarError.__reduce__
        kinds += kind.__subclasses__()
    assert {InvalidInput, WrongSetup, FitFailed} <= set(kinds)
