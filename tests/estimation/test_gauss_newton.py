"""Gauss-Newton steps near an optimum: they end where the general solver does, also where a full step goes too far."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
from scipy.optimize import least_squares

from scalar.estimation import gauss_newton
from scalar.estimation.gauss_newton import NormalEquations, optimum_near


@dataclass(frozen=True)
class Point:
    """A model that has coordinates and nothing else."""

    vector: np.ndarray

    def with_vector(self, vector: np.ndarray) -> Point:
        """Return the model with other coordinates."""
        return replace(self, vector=vector)


@dataclass(frozen=True)
class Problem:
    """A least-squares problem: functions that return the residual and its derivatives."""

    residual: Any
    jacobian: Any

    def linearise(self, model: Point) -> tuple[np.ndarray, np.ndarray]:
        """Return both at a model."""
        return self.residual(model.vector), self.jacobian(model.vector)


def optimum(problem: Problem, start: list[float]) -> np.ndarray:
    """Return the coordinates at which the steps from a start end, all of them free."""
    point: Any = Point(np.array(start, dtype=float))
    return optimum_near(problem, point, np.ones(len(start), dtype=bool)).vector  # type: ignore[arg-type]


@pytest.fixture
def alone(monkeypatch):
    """Let a test fail if the steps hand over to the slower solver."""

    def refused(*arguments: Any, **keywords: Any) -> None:
        raise AssertionError("the steps did not converge")

    monkeypatch.setattr(gauss_newton, "fit", refused)


def test_a_linear_problem_is_solved_at_once(alone):
    """One step reaches the solution by normal equations, whatever the lengths of the columns."""
    rng = np.random.default_rng(1)
    A, b = rng.normal(size=(30, 4)) * [1.0, 1e-3, 1e4, 1.0], rng.normal(size=30)
    found = optimum(Problem(lambda x: A @ x - b, lambda x: A), [0.0] * 4)
    np.testing.assert_allclose(found, np.linalg.lstsq(A, b, rcond=None)[0], rtol=1e-9)


@pytest.mark.parametrize("curvature", [10.0, 300.0])
def test_a_step_that_goes_too_far_is_taken_with_damping(curvature, alone):
    """In a curved valley (Rosenbrock's) a full step raises the cost; shorter ones lead to the optimum."""
    problem = Problem(
        lambda x: 1e4 * np.array([curvature * (x[1] - x[0] ** 2), 1.0 - x[0]]),
        lambda x: 1e4 * np.array([[-2.0 * curvature * x[0], curvature], [-1.0, 0.0]]),
    )
    start = [-1.2, 1.0]
    full = np.array(start) - np.linalg.solve(problem.jacobian(start), problem.residual(start))
    assert np.linalg.norm(problem.residual(full)) > np.linalg.norm(problem.residual(start))
    np.testing.assert_allclose(optimum(problem, start), [1.0, 1.0], atol=1e-6)


def test_a_nonlinear_fit_ends_where_the_general_solver_does(alone):
    """Amplitude, rate and offset of a decay with noise, from a start that is off by a half."""
    t = np.linspace(0.0, 4.0, 60)
    y = 2.0 * np.exp(-1.3 * t) + 0.3 + np.random.default_rng(2).normal(0.0, 0.02, 60)

    def residual(x: np.ndarray) -> np.ndarray:
        return (x[0] * np.exp(-x[1] * t) + x[2] - y) / 0.02

    def jacobian(x: np.ndarray) -> np.ndarray:
        decay = np.exp(-x[1] * t)
        return np.column_stack([decay, -x[0] * t * decay, np.ones_like(t)]) / 0.02

    expected = least_squares(residual, [3.0, 0.6, 0.0], jacobian, xtol=1e-14, ftol=1e-14, gtol=1e-14).x
    np.testing.assert_allclose(optimum(Problem(residual, jacobian), [3.0, 0.6, 0.0]), expected, rtol=1e-6)


def test_hardly_determined_parameters_are_left_to_the_slower_solver(monkeypatch):
    """Normal equations of two columns that are the same but for rounding are not solved."""
    handed_over: list[Any] = []
    monkeypatch.setattr(
        gauss_newton,
        "fit",
        lambda residuals, model, free, **keywords: handed_over.append(model) or _Fit(model),
    )
    A = np.column_stack([np.ones(5), np.ones(5) + 1e-8 * np.arange(5)])
    start = [0.5, 0.5]
    assert list(optimum(Problem(lambda x: A @ x - 1.0, lambda x: A), start)) == start
    assert len(handed_over) == 1


@dataclass(frozen=True)
class _Fit:
    model: Any


def test_damping_shortens_the_step_and_what_is_expected_of_it():
    """The damped step solves the equations with the damping on their diagonal, and its drop is that of the linear model."""
    rng = np.random.default_rng(4)
    J, r = rng.normal(size=(20, 3)), rng.normal(size=20)
    equations = NormalEquations.of(r, J)
    assert equations is not None
    scale = np.linalg.norm(J, axis=0)
    gram = (J / scale).T @ (J / scale)
    damping = 0.1
    damped = gram + damping * np.linalg.eigvalsh(gram)[-1] * np.eye(3)
    step = -np.linalg.solve(damped, (J / scale).T @ r) / scale
    np.testing.assert_allclose(equations.step(damping), step, rtol=1e-9)
    np.testing.assert_allclose(
        equations.expected_drop(damping), r @ r - np.sum((r + J @ step) ** 2), rtol=1e-9
    )
