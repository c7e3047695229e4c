"""An effect that is confounded with a finding is listed there, and not among the unobservable effects as well."""

from types import SimpleNamespace

import pytest

from scalar.diagnosis.naming.finding import Finding
from scalar.diagnosis.naming.observability import Unobservable
from scalar.diagnosis.result import Diagnosis
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.effects.joint_scale import JointScale
from scalar.effects.range_scale import RangeScale


@pytest.mark.parametrize(
    ("doubtful", "may_accompany", "listed"),
    [
        (False, False, ["range_scale"]),
        (True, False, ["joint_scale", "range_scale"]),
        (False, True, ["joint_scale", "range_scale"]),
    ],
)
def test_a_rival_of_a_named_finding_is_listed_with_it_alone(doubtful, may_accompany, listed):
    """With the finding in the model its rival leaves no residual; it stands with the finding if that has a name, and else among the unobservable.

    It stands among these as well if it may be present together with the finding.
    """
    finding = Finding(
        effect=JointHarmonic(4, (1,)),
        p_value=1e-9,
        before=None,
        after=None,
        confounded_with=(JointScale(4),),
        confidence=0.9,
        std=(None, None),
        grounds=None,
        doubtful=doubtful,
    )
    hidden = (
        Unobservable(JointScale(4), 0.0, 1e-4, "", may_accompany=may_accompany),
        Unobservable(RangeScale(), 0.0, 1e-4, ""),
    )
    alone = Diagnosis.unobservable_alone.fget(SimpleNamespace(findings=(finding,), unobservable=hidden))
    assert [entry.effect.name for entry in alone] == listed
