"""Effects that a dataset measures directly: the motion between base and tracker, by reference points that are fixed to the base."""

# pyright: reportMissingTypeStubs=false, reportUnknownMemberType=false
# pandas is not annotated throughout.

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from scalar.data.dataset import Dataset
from scalar.data.formats import TARGET_MOTION
from scalar.effects import registry
from scalar.effects.effect import Effect
from scalar.sensors import kind_of


def with_target_motion(dataset: Dataset) -> Dataset:
    """Return the dataset with the motion that its reference points show, as columns of its poses.

    The same object is returned if there are no reference points, or if it has these columns already.
    """
    if dataset.references is None or TARGET_MOTION[0] in dataset.poses:
        return dataset
    motion = kind_of(dataset).target_motion(dataset)
    if motion is None:
        return dataset
    columns = dict(zip(TARGET_MOTION, motion.T, strict=True))
    return replace(dataset, poses=dataset.poses.assign(**columns))


def measured_effects(dataset: Dataset, others: Sequence[Effect]) -> list[Effect]:
    """Return the effects that the dataset measures directly, with their coefficients.

    Args:
        dataset: As ``with_target_motion`` returns it.
        others: Effects that are fitted or fixed as well; an effect of the same kind and place as one of these is left out.
    """
    shown = [kind.measured(dataset) for kind in registry.known().values()]
    return [e for e in shown if e is not None and not any(e.same_place(other) for other in others)]
