"""What is seen of killed commands is said at once, whatever becomes of the commands after them."""

import sys
from pathlib import Path

import pytest

from tests.endurance import kills


def test_faults_of_a_command_are_said_before_another_fails(monkeypatch, capsys):
    """The faults of one command are printed before the next begins, and a command that fails undisturbed is a fault of its own."""

    def seen(name, *_):
        if name == "plan":
            raise KeyboardInterrupt
        return kills.Outcome(kills=1, faults=[f"{name}: a file is gone"])

    monkeypatch.setattr(kills, "write_datasets", lambda root: (root, root))
    monkeypatch.setattr(kills, "endure", seen)
    monkeypatch.setattr(sys, "argv", ["kills", "--kills", "2", "--only", "simulate", "plan"])
    with pytest.raises(KeyboardInterrupt):
        kills.main()
    assert "simulate: a file is gone" in capsys.readouterr().out


def test_a_command_that_fails_undisturbed_is_a_fault(monkeypatch, tmp_path):
    """Its exit status and its output are kept, and nothing is killed."""
    monkeypatch.setattr(kills, "run", lambda arguments: (2, "scalar: too few poses"))
    found = kills.endure("plan", (Path("a"), Path("b")), 3, kills.random.Random(0), tmp_path)
    assert found.kills == 0
    assert found.faults == ["plan: undisturbed, it ended with 2: scalar: too few poses"]
