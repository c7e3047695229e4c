"""A session whose measurements do not determine where the tracker stood."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from scalar.data.dataset import Dataset

_OF_SESSION = re.compile(r"tracker@(\d+)_")


def undetermined_session(dataset: Dataset, names: Sequence[str]) -> str:
    """Return a sentence on the session whose frame of the tracker alone the data do not determine; empty if it is anything else.

    Args:
        dataset: What was measured.
        names: Of the parameters that the data distinguish least.
    """
    found = {match[1] if (match := _OF_SESSION.match(name)) else "" for name in names}
    if dataset.session is None or len(found) != 1 or found == {""}:
        return ""
    poses = np.flatnonzero(dataset.session == int(found.pop()) - 1)
    name = dataset.poses["session"].iloc[poses[0]]
    many = f"{len(poses)} poses do" if len(poses) > 1 else "one pose does"
    return (
        f"poses.csv, column session: in session '{name}' {many} not determine where the tracker stands: measure more poses in it, at places that "
        "are not on one line; leave its poses out; or give them the session of others, if neither tracker nor base was moved in between"
    )
