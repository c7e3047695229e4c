"""The columns of effects at a fitted model: derivatives of its whitened rows by the coefficients of effects, in the model or not.

A column is a product: the derivative of the rows by a motion of the place where the effect acts, times the motion that the effect makes there at
each pose, its *basis*. The derivative does not depend on the effect and is computed once for a model. For effects on points, the profile rows that
were compressed with the functions of the points that these effects need are kept instead.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate
from typing import TYPE_CHECKING

import numpy as np

from scalar.diagnosis.fit.column_products import ColumnBlock, ColumnProducts, one_joint_each
from scalar.diagnosis.fit.measured_rows import MeasuredRows, profile_measurement
from scalar.effects import BaseEffect, Effect, JointEffect, LinkEffect, PointEffect
from scalar.effects.checked_basis import checked_basis
from scalar.estimation.effect_bases import JointBasis
from scalar.estimation.model import Model
from scalar.estimation.residuals import BoundPointEffect, Residuals, extra_basis_of
from scalar.geometry.robot import GEOMETRY
from scalar.geometry.screws import change_frame
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    from scalar.sensors import Measurement

Basis = JointBasis | Array  # an array ``(N, 6, k)`` of screws for base and sensor, ``(N, 5, n, k)`` for links

_MOST_KEPT = 1_000_000  # bytes: a larger basis (of links at thousands of poses) is computed anew each time
_MOST_KEPT_OF_SET = 4_000_000  # bytes, the same for the bases of a set of candidates, sorted by joint
_MOST_KEPT_OF_JOINTS = 400_000  # bytes, the same for one on joints: thousands of flexible terms at 12,000 poses would take most of the memory


@dataclass(frozen=True, eq=False)
class PartOfSet:
    """Those of a set's effects that act on one joint alone, or all its other effects.

    Attributes:
        joint: The joint, from 0; -1 for the others.
        at: ``(k,)``, where their columns are among those of the set.
        effects: The effects.
        basis: ``(k, N)``, their bases on the joint; None for the others.
    """

    joint: int
    at: Array
    effects: Sequence[Effect]
    basis: Array | None


class Bases(dict[Effect, Basis]):
    """The bases of effects at the poses of a dataset, which do not depend on the model: they are computed once for all states.

    Attributes:
        of_products: The effects of the set that owns these bases, sorted by joint (``EffectColumns.products``); None until they are, or if their
            bases are large.
        on_points: Effects on points, bound to the poses.
    """

    of_products: list[PartOfSet] | None = None

    def __init__(self) -> None:
        """Begin without any."""
        super().__init__()
        self.on_points: dict[Effect, BoundPointEffect] = {}

    def forget(self) -> None:
        """Keep no basis any longer; those that are asked for again are computed anew, with the same result."""
        self.clear()
        self.of_products = None


class EffectColumns:
    """The columns of any effects at one model, under one whitening.

    Columns are derivatives at coefficients of zero, whatever coefficients the effects have.
    """

    def __init__(
        self, residuals: Residuals, model: Model, rows: MeasuredRows, whitening: Array | None
    ) -> None:
        """Keep what the columns are computed from.

        Args:
            residuals: The residuals of the dataset.
            model: The model at its optimum.
            rows: The dataset reduced to rows.
            whitening: ``(N, m, m)``, applied to the rows of every pose, or None.
        """
        self._residuals, self._model, self._rows, self._whitening = residuals, model, rows, whitening
        self._profiles: dict[tuple[str, ...], Measurement] = {}

    def of(self, effects: Sequence[Effect], bases: Bases | None = None) -> Array:
        """Return the columns ``(N m, e)`` of effects with e coefficients in all.

        Args:
            effects: Any effects.
            bases: Bases that were computed before; those that are computed here are added.
        """
        bases = Bases() if bases is None else bases
        N, m = self._by_geometry.shape[:2]
        ends = [0, *accumulate(len(effect.coefficients) for effect in effects)]
        found = np.empty(
            (ends[-1], N, m)
        )  # the rows of a column are adjacent in memory, because sums run over rows
        columns = found.transpose(1, 2, 0)
        on_points: list[tuple[PointEffect, slice]] = []
        whole: dict[str, Array] = {}
        for effect, start, stop in zip(effects, ends[:-1], ends[1:], strict=True):
            if isinstance(effect, PointEffect):
                on_points.append((effect, slice(start, stop)))
                continue
            if (
                isinstance(effect, LinkEffect)
                and (product := effect.constant_and_shares(self._residuals.poses)) is not None
            ):
                constant, share = product
                if constant.key not in whole:
                    whole[constant.key] = np.empty((stop - start, N, m))
                    basis = np.asarray(self._basis(constant, Bases()))
                    self._fill(whole[constant.key].transpose(1, 2, 0), constant, basis)
                np.multiply(whole[constant.key], share[:, None], out=found[start:stop])
                continue
            basis = self._basis(effect, bases)
            if isinstance(basis, JointBasis):
                self._fill_by_joints(found[start:stop], basis)
            else:
                self._fill(columns[:, :, start:stop], effect, basis)
        if on_points:
            at = np.concatenate([np.arange(place.start, place.stop) for _, place in on_points])
            columns[:, :, at] = self._of_points([effect for effect, _ in on_points], bases)
        return found.reshape(-1, N * m).T

    def products(self, effects: Sequence[Effect], groups: Iterable[Array], bases: Bases) -> ColumnProducts:
        """Return the columns of effects for products within groups of them.

        Args:
            effects: Any effects, with e coefficients in all.
            groups: Arrays ``(T, w)`` of the indices of the columns of T groups.
            bases: As in ``of``. They belong to these effects and groups.
        """
        if bases.of_products is None:
            parts = self._parts(effects, groups, bases)
            if sum(0 if part.basis is None else part.basis.nbytes for part in parts) <= _MOST_KEPT_OF_SET:
                bases.of_products = parts
        else:
            parts = bases.of_products
        blocks = []
        for part in parts:
            if part.basis is None:
                blocks.append(ColumnBlock(part.at, self.of(part.effects, bases).T, None))
                continue
            lengths, directions = self._by_joint_split[part.joint]
            # A basis that is not kept is no longer needed.
            rows = np.multiply(part.basis, lengths, out=None if bases.of_products else part.basis)
            blocks.append(ColumnBlock(part.at, rows, directions))
        return ColumnProducts(blocks)

    def _parts(self, effects: Sequence[Effect], groups: Iterable[Array], bases: Bases) -> list[PartOfSet]:
        """Return the effects sorted by the joint on which they act alone; the arguments are those of ``products``."""
        owner = np.repeat(np.arange(len(effects)), [len(effect.coefficients) for effect in effects])
        found = [self._on_one_joint(effect, bases) for effect in effects]
        joints = one_joint_each(
            np.array([-1 if each is None else each[0] for each in found], dtype=int)[owner], groups
        )
        parts = []
        for j in np.unique(joints).tolist():
            at = np.flatnonzero(joints == j)
            own = np.unique(owner[at])
            basis = None
            if j >= 0:
                basis = np.concatenate([each[1].T for i in own if (each := found[i]) is not None])
                for i in own:  # thousands of flexible terms at 12,000 poses take a tenth of the memory
                    found[i] = None
            parts.append(PartOfSet(j, at, [effects[i] for i in own], basis))
        return parts

    def _on_one_joint(self, effect: Effect, bases: Bases) -> tuple[int, Array] | None:
        """Return the only joint, from 0, on which an effect acts, and its basis ``(N, k)`` there; None if it does not act on one joint alone."""
        basis = self._basis(effect, bases) if isinstance(effect, JointEffect) else None
        return basis.parts[0] if isinstance(basis, JointBasis) and len(basis.parts) == 1 else None

    def _basis(self, effect: Effect, bases: Bases) -> Basis:
        """Return the basis of an effect at the poses, which is added to ``bases`` unless it is large."""
        found = bases.get(effect)
        if found is not None:
            return found
        nominal, poses = self._model.nominal, self._residuals.poses
        basis = checked_basis(effect, nominal, poses)
        if basis is None:
            return np.zeros((len(poses), 6, len(effect.coefficients)))
        found = JointBasis.of_effect(effect, basis) if isinstance(effect, JointEffect) else basis
        if basis.nbytes <= (_MOST_KEPT_OF_JOINTS if isinstance(found, JointBasis) else _MOST_KEPT):
            bases[effect] = found
        return found

    def _fill_by_joints(self, columns: Array, basis: JointBasis) -> None:
        """Fill in the columns ``(k, N, m)`` of an effect on joints."""
        if not basis.parts:
            columns[:] = 0.0
        for i, (j, part) in enumerate(basis.parts):
            if i == 0:
                np.multiply(self._by_joint[j], part.T[:, :, None], out=columns)
            else:
                columns += self._by_joint[j] * part.T[:, :, None]

    def _fill(self, columns: Array, effect: Effect, basis: Array) -> None:
        """Fill in the columns ``(N, m, k)`` of an effect that acts neither on joints nor on points."""
        if isinstance(effect, LinkEffect):
            np.matmul(self._by_geometry, basis.reshape(len(basis), -1, basis.shape[-1]), out=columns)
        else:
            np.matmul(
                self._by_base if isinstance(effect, BaseEffect) else self._by_sensor, basis, out=columns
            )

    def _of_points(self, effects: Sequence[PointEffect], bases: Bases) -> Array:
        """Return the columns ``(N, m, k)`` of effects on points, which are bound to the poses once for all states."""
        names = tuple(dict.fromkeys(extra_basis_of(effects)))
        if names not in self._profiles:
            rows = self._rows.with_functions(names)
            self._profiles[names] = profile_measurement(rows, self._model, self._residuals)
        T = self._residuals.kinematics(self._model).T_base_sensor
        known, poses = bases.on_points, self._residuals.poses
        bound = [
            known.get(effect) or known.setdefault(effect, BoundPointEffect(effect, poses))
            for effect in effects
        ]
        return self._whitened(self._profiles[names].extra_columns(T, self._model.target, bound))

    def _whitened(self, rows: Array) -> Array:
        """Return rows ``(N, m, k)`` whitened."""
        return rows if self._whitening is None else self._whitening @ rows

    @cached_property
    def _by_geometry(self) -> Array:
        """Return the derivatives ``(N, m, 5 n)`` of the whitened rows by the geometric parameters."""
        m = self._residuals.measurement.rows_per_pose
        jacobian = self._residuals.linearise_measured(self._model)[1][:, self._model.blocks["geometry"]]
        assert jacobian.shape[1] == len(GEOMETRY) * self._model.robot.n_joints
        return self._whitened(jacobian.reshape(len(self._residuals.poses), m, -1))

    @cached_property
    def _by_joint(self) -> Array:
        """Return the derivatives ``(n, N, m)`` of the whitened rows by the joints' angles and travels."""
        return np.moveaxis(self._by_geometry[:, :, self._model.robot.joint_columns], 2, 0).copy()

    @cached_property
    def _by_joint_split(self) -> list[tuple[Array, Array]]:
        """Return for each joint the lengths ``(N,)`` of ``_by_joint`` at the poses, and its directions ``(N, m)``, zero where it has no length."""
        lengths = np.linalg.norm(self._by_joint, axis=2)
        return list(
            zip(lengths, self._by_joint / np.where(lengths > 0, lengths, 1.0)[:, :, None], strict=True)
        )

    @cached_property
    def _by_base(self) -> Array:
        """Return the derivatives ``(N, m, 6)`` of the whitened rows by a screw of the arm in the frame of its base.

        This frame includes the motion of the base by the effects of the model.
        """
        wrench = self._whitened(self._residuals.wrench(self._model))
        T = self._residuals.kinematics(self._model).T_base_tilted
        return wrench if T is None else wrench @ _adjoint(T)

    @cached_property
    def _by_sensor(self) -> Array:
        """Return the derivatives ``(N, m, 6)`` of the whitened rows by a screw of the sensor in its own frame."""
        T = self._residuals.kinematics(self._model).T_base_sensor
        return self._whitened(self._residuals.wrench(self._model)) @ _adjoint(T)


def _adjoint(T: Array) -> Array:
    """Return the matrices ``(N, 6, 6)`` that transform screws by T ``(N, 4, 4)``, from frame b to frame a for ``T_a_b``."""
    return change_frame(T, np.broadcast_to(np.eye(6), (len(T), 6, 6)))
