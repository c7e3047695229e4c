"""Lengths of the arm that grow with temperature or time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from scalar.data.poses import Poses
from scalar.effects.acquisition import missing_column, order_and_time
from scalar.effects.effect import Effect
from scalar.effects.flexible.rivals_of_changes import rivals_of_change
from scalar.effects.flexible.sensor_warm_up import sensor_warm_ups
from scalar.effects.growth import growing_lengths, growth_picture, time_constant_steps
from scalar.effects.picture import Map, Profile, View
from scalar.effects.places import LinkEffect
from scalar.effects.stretches import stretches_of_work
from scalar.effects.wording import columns_in_words, listed, number
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array
from scalar.sensors import kind_of

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

DRIVERS = ("temperature", "time", "order")
WARM_UP_SHARES = (0.1, 0.3, 1.0)  # time constants of a warm-up that are tried, as shares of the whole time
_CLOCK = {"time": "s", "order": "poses"}
_LARGEST_STEP = np.log(2.0)  # largest change of the logarithm of a time constant between two fits
_LEAST_STEP = 1e-3  # least such change: after a smaller one the linearisation is accurate to about its square, and no further fit is made


@dataclass(frozen=True, eq=False)
class ThermalDrift(LinkEffect):
    """All lengths of the arm grow in proportion, ``a, d -> (1 + g x) (a, d)``, with x the temperature or a function of time.

    Attributes:
        by: ``temperature``, ``time`` or ``order``: the column that drives the growth.
        reference: Value of the column at which the lengths are those of the model.
        time_constant: Time constant of a warm-up, ``x = 1 - exp(-(t - reference) / time_constant)``; zero for growth in proportion to the column.
        last: Last order of acquisition, at which predictions without ``order`` are made. None if another column drives the growth.
        about: Growth g at which a warm-up is linearised to estimate its time constant tau as well: the second coefficient is
            ``ln(tau) - ln(time_constant)``, and its column the derivative by it at this growth. Zero if the time constant is not estimated.
    """

    by: str
    reference: float
    time_constant: float = 0.0
    last: float | None = None
    about: float = 0.0

    name: ClassVar[str] = "thermal_drift"
    imitators_are_as_likely: ClassVar[bool] = True
    kind: ClassVar[str] = "thermal drift"
    growth_of_arm: ClassVar[bool] = True
    sentence: ClassVar[str] = "the arm's lengths grow with time or temperature"
    natural: ClassVar[Mapping[str, float]] = {"1/K": 2.3e-5, "m/m": 2.3e-4, "1/s": 6.4e-8, "1/pose": 2.3e-7}
    natural_source: ClassVar[str] = (
        "aluminium alloys grow by 23e-6 a kelvin (EN 573-3 alloy 6082, data sheets); ten kelvin in an hour, or in a thousand poses, are assumed"
    )
    acts_by_joint_angles: ClassVar[bool] = False

    @property
    def follows(self) -> tuple[str, ...]:
        """The column that drives the growth, but not the order of acquisition."""
        return () if self.by == "order" else (self.by,)

    @property
    def follows_order(self) -> bool:
        """Return whether the order of acquisition drives the growth."""
        return self.by == "order"

    @property
    def target(self) -> dict[str, Any]:
        """Empty: it acts on the whole arm."""
        return {}

    @property
    def coefficient_names(self) -> list[str]:
        """Growth a kelvin, a second, a pose; or the whole growth of a warm-up."""
        if self.time_constant:
            return ["growth_m_per_m", "log_time_constant_1"] if self.about else ["growth_m_per_m"]
        return [{"temperature": "growth_per_K", "time": "growth_per_s", "order": "growth_per_pose"}[self.by]]

    @property
    def coefficient_units(self) -> list[str]:
        """As the names say."""
        if self.time_constant:
            return ["m/m", "1"] if self.about else ["m/m"]
        return [{"temperature": "1/K", "time": "1/s", "order": "1/pose"}[self.by]]

    def variations(self, scale: float) -> list[Self]:
        """Return a warm-up that is a little faster or slower."""
        if not self.time_constant:
            return [self]
        return [replace(self, time_constant=self.time_constant * step) for step in time_constant_steps(scale)]

    def geometry_basis(self, robot: Robot, poses: Poses) -> Array:
        """Return the nominal lengths times the profile of the growth."""
        x = self.growth(self._order(poses) if self.by == "order" else poses.column(self.by))
        return growing_lengths(robot, poses, x)

    def growth(self, driver: Array) -> Array:
        """Return the growth per unit of every coefficient ``(N, k)`` at values of the column that drives it."""
        x = np.asarray(driver, dtype=float) - self.reference
        if not self.time_constant:
            return x[:, None]
        s = np.maximum(x, 0.0) / self.time_constant
        columns = [1.0 - np.exp(-s)]
        if self.about:
            columns.append(-self.about * s * np.exp(-s))
        return np.stack(columns, axis=1)

    def relinearised(self) -> Self:
        """Return a warm-up linearised at the estimated time constant; at the first call, one whose time constant is to be estimated."""
        if not self.time_constant or not self.coefficients[0]:
            return self
        growth = float(self.coefficients[0])
        if not self.about:
            return replace(self, about=growth, coefficients=np.array([growth, 0.0]))
        step = float(np.clip(self._log_change, -_LARGEST_STEP, _LARGEST_STEP))
        if abs(step) < _LEAST_STEP:
            return self
        constant = self.time_constant * float(np.exp(step))
        return replace(self, time_constant=constant, about=growth, coefficients=np.array([growth, 0.0]))

    @property
    def _log_change(self) -> float:
        """Return the logarithm of the ratio of the estimated time constant to ``time_constant``, for which the columns are computed."""
        return float(self.coefficients[1] * self.about / self.coefficients[0]) if self.about else 0.0

    def stated(self, std: Sequence[float | None]) -> dict[str, tuple[float, float | None]]:
        """Return the growth, and the time constant of a warm-up in the unit of what drives it."""
        names = self.coefficient_names[:1]
        found = {names[0]: (float(self.coefficients[0]), std[0])}
        if not self.time_constant:
            return found
        constant = self.time_constant * float(np.exp(self._log_change))
        relative = std[1] if self.about else None
        if relative is not None:
            relative *= abs(self.about / float(self.coefficients[0]))
        name = f"time_constant_{_CLOCK.get(self.by, 'K')}"
        return {**found, name: (constant, None if relative is None else relative * constant)}

    def _order(self, poses: Poses) -> Array:
        """Return the order of acquisition ``(N,)``, the end of it where none is stated."""
        if np.all(np.isfinite(poses.order)):
            return poses.order
        return np.where(
            np.isfinite(poses.order), poses.order, poses.column("order") if self.last is None else self.last
        )

    def to_mapping(self) -> dict[str, Any]:
        """Return what drives the growth."""
        mapping: dict[str, Any] = {
            "by": self.by,
            "reference": self.reference,
            "time_constant": self.time_constant,
        }
        if self.about:
            mapping["about"] = self.about
        return mapping if self.last is None else {**mapping, "last": self.last}

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the effect of ``to_mapping``."""
        last = mapping.get("last")
        return cls(
            str(mapping["by"]),
            float(mapping["reference"]),
            float(mapping["time_constant"]),
            None if last is None else float(last),
            float(mapping.get("about", 0.0)),
        )

    @classmethod
    def candidates(cls, dataset: Dataset) -> list[Effect]:
        """Return growth in proportion to each variable that may drive it, and warm-ups of a few time constants.

        A room thermometer does not show that the motors warm the arm. Growth over the time, or over the order of the poses, is therefore proposed
        even if a temperature is recorded. Where the time has gaps in which the arm stood still, growth over the order is proposed beside growth
        over the time: the order counts the poses that the arm worked.
        """
        drivers = {drift_driver(dataset), "time" if "time" in dataset.poses else "order"}
        if stretches_of_work(dataset)[1]:
            drivers.add("order")
        found: list[Effect] = []
        for driver in sorted(drivers):
            x = _values(dataset, driver)
            start, span = float(np.min(x)), float(np.ptp(x))
            if span <= 0:
                continue
            last = start + span if driver == "order" else None
            found.append(cls(driver, start, last=last))
            if driver != "temperature":
                found += [cls(driver, start, share * span, last) for share in WARM_UP_SHARES]
        return found

    @classmethod
    def parsed(cls, dataset: Dataset, words: Sequence[str]) -> list[Effect]:
        """Return growth with the column that is named, or with what may drive it."""
        by = words[0] if words else drift_driver(dataset)
        if by not in DRIVERS:
            raise ValueError(f"'{by}' drives no drift; there are {', '.join(DRIVERS)}")
        if by != "order" and (missing := missing_column(dataset, by)):
            raise ValueError(missing)
        x = _values(dataset, by)
        return [cls(by, float(x.min()), last=float(x.max()) if by == "order" else None)]

    def imitators(self, dataset: Dataset) -> list[Effect]:
        """Return changes of a link, of the whole arm, or of its load, at several moments of the campaign, and a scanner that warms up likewise."""
        changes = rivals_of_change(dataset)
        if kind_of(dataset).scans:
            changes += sensor_warm_ups(self.by, _values(dataset, self.by), self.time_constant)
        return changes

    @property
    def is_change_in_time(self) -> bool:
        """Return whether the clock or the order drives the growth, and not the temperature."""
        return self.by != "temperature"

    def not_transferable(self, dataset: Dataset) -> str | None:
        """Return that a growth by the clock is that of one campaign, or that the temperature is missing."""
        if self.by != "temperature":
            return f"its dependence on {self.by} is that of one campaign"
        return missing_column(dataset, self.by)

    @property
    def title(self) -> str:
        """Return what drives the growth, and how fast a warm-up is."""
        constant = f"{number(self.time_constant)} {_CLOCK.get(self.by, 'K')}"
        what = f"warm-up (constant {constant})" if self.time_constant else self.kind
        return f"{what} {'in the course of acquisition' if self.by == 'order' else 'with ' + self.by}"

    @property
    def clause(self) -> str:
        """Return that the arm grows, and with what."""
        along = columns_in_words([self.by])
        if not self.time_constant:
            return f"the arm's lengths grow with {along}"
        return f"the arm's lengths grow as it warms up, with a time constant of {number(self.time_constant)} {_CLOCK.get(self.by, 'K')}"

    @property
    def advice(self) -> list[str]:
        """Return how to avoid it."""
        return [
            "Let the arm warm up before it is measured and before it is used, and keep the temperature around it even."
        ]

    @property
    def how_to_measure(self) -> str:
        """Return how to see it directly."""
        return "To see it directly, measure one pose far from the base every few minutes, from a cold start until it no longer changes."

    @property
    def in_controller(self) -> str:
        """Return what changes in the controller."""
        return (
            f"No fixed parameter holds a drift: correct programs with 'scalar correct', which needs the {self.by} of each pose (column {self.by})."
            if self.by == "temperature"
            else "The drift is that of this campaign: nothing in the controller corrects it, and programs are best run with a warm arm."
        )

    @classmethod
    def advice_on_data(cls, dataset: Dataset) -> list[str]:
        """Return that time and temperature should be recorded, where they are not."""
        poses = dataset.poses
        missing = [name for name in ("time", "temperature") if name not in poses]
        if not missing:
            return []
        known = "order" in poses or "time" in poses
        order = "" if known else "; without them the order of the rows has to stand for the time"
        them = "it" if len(missing) == 1 else "them"
        return [
            f"Record {listed(missing)} with each pose: a drift could not be looked for along {them}{order}."
        ]

    def pictures(self, view: View) -> list[Profile | Map]:
        """Return the growth of all lengths over what drives it."""
        driver = view.poses.order if self.by == "order" else view.poses.column(self.by)
        return [growth_picture(view, self, self.by, driver, self.growth)]


def drift_driver(dataset: Dataset) -> str:
    """Return what may drive a thermal drift: the temperature where it is recorded and varies, else the time, else the order."""
    for name in ("temperature", "time"):
        if name in dataset.poses and float(np.ptp(dataset.poses[name].to_numpy(dtype=float))) > 0:
            return name
    return "order"


def _values(dataset: Dataset, driver: str) -> Array:
    return order_and_time(dataset)[0] if driver == "order" else dataset.poses[driver].to_numpy(dtype=float)
