"""The calibrated arm as a table of Denavit-Hartenberg parameters, modified or standard, for a controller or for people."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from scalar.estimation.result import Calibration
from scalar.export.numbers_out import shortest
from scalar.export.rigid_part import RigidPart, random_joints
from scalar.geometry.robot import GEOMETRY, LENGTHS, Robot
from scalar.geometry.roll_pitch_yaw import rpy_from_rotation
from scalar.geometry.se3 import Array, log_so3
from scalar.geometry.standard_dh import standard_rows, standard_table, without_beta
from scalar.units import DEG, MM

CONVENTIONS = ("modified-dh", "standard-dh")
FORMULAS = (
    "T_{i-1,i} = Rx(alpha_i) Tx(a_i) Ry(beta_i) Rz(q_i + theta_i) Tz(d_i)",
    "T_{i-1,i} = Rz(q_i + theta_i) Tz(d_i) Tx(a_i) Rx(alpha_i) Ry(beta_i)",
)
_STATES = ("", "_nominal", "_std")
"""What a row has of each parameter, as the names of the CSV's columns say: calibrated value, nominal value, standard deviation."""


def dh_csv(calibration: Calibration, rigid: RigidPart, *, standard: bool = False) -> str:
    """Return a CSV with one row for each joint: calibrated value, nominal value and standard deviation of a, alpha, d, theta and beta.

    The name of each column ends in its unit. The standard deviation of a fixed parameter is left empty. If a joint is prismatic, a column
    ``type`` says which joints are; ``convention`` says which of ``FORMULAS`` turns the rows into the arm. The transforms of base, flange and
    sensor are in ``dh_markdown``.

    Args:
        calibration: The calibration to write.
        rigid: Its rigid part.
        standard: Whether the rows are those of standard DH.
    """
    tables = [_table(calibration, rigid, state, standard) for state in _STATES]
    units = ["m" if kind in LENGTHS else "rad" for kind in GEOMETRY]
    head = [f"{kind}{state}_{unit}" for state in _STATES for kind, unit in zip(GEOMETRY, units, strict=True)]
    slides = rigid.robot.slides
    types = [["prismatic" if slides[i] else "revolute"] if slides.any() else [] for i in range(len(slides))]
    lines = [",".join(["joint", *(["type"] if slides.any() else []), *head, "convention"])]
    for i in range(rigid.robot.n_joints):
        values = [value for table in tables for value in table[:, i]]
        cells = ["" if np.isnan(value) else shortest(value) for value in values]
        lines.append(",".join([str(i + 1), *types[i], *cells, CONVENTIONS[standard]]))
    return "\n".join([*lines, ""])


def dh_markdown(calibration: Calibration, rigid: RigidPart, *, standard: bool = False) -> str:
    """Return tables for people, in millimetres and degrees: the joints, their change from nominal, and the fixed transforms.

    With the fixed transforms that are printed here, the table of ``dh_csv`` describes the calibrated arm to 1e-9 m.

    Args:
        calibration: The calibration to write.
        rigid: Its rigid part.
        standard: Whether the rows are those of standard DH.
    """
    robot, nominal = rigid.robot, calibration.model.nominal
    found, stated, std = (_table(calibration, rigid, state, standard) for state in _STATES)
    T_base_0, T_n_flange = robot.T_base_0, robot.T_n_flange
    if standard:
        table = standard_table(robot)
        T_base_0, T_n_flange = table.T_base_0, table.T_n_flange
    change = found - stated
    lines = [
        f"# {nominal.name}, calibrated",
        "",
        f"{'Standard' if standard else 'Modified'} Denavit-Hartenberg parameters with Hayati's beta: `{FORMULAS[standard]}`.",
        *([beyond_standard_dh(robot)] if standard and beyond_standard_dh(robot) else []),
        *(
            f"Joint {i + 1} slides: q_{i + 1} is added to its d instead of its theta."
            for i in robot.prismatic
        ),
        "",
        *_joint_rows([_cells(found[:, i], "+.5f") for i in range(robot.n_joints)]),
        "",
        "Change from the nominal table (± one standard deviation where it was estimated):",
        "",
        *_joint_rows([_cells_of_change(change[:, i], std[:, i]) for i in range(robot.n_joints)]),
        "",
        "Fixed transforms (translation; rotation vector rx, ry, rz, and the same rotation as roll, pitch, yaw: Rz(yaw) Ry(pitch) Rx(roll)):",
        "",
        _row(
            *("from", "to", "x [mm]", "y [mm]", "z [mm]", "rx [deg]", "ry [deg]", "rz [deg]"),
            *("roll [deg]", "pitch [deg]", "yaw [deg]"),
        ),
        _rule(11),
    ]
    for start, end, T in (
        ("base", "frame 0", T_base_0),
        (f"frame {robot.n_joints}", "flange", T_n_flange),
        ("flange", "sensor", rigid.T_flange_sensor),
    ):
        R = T[:3, :3]
        numbers = [*(T[:3, 3] / MM), *(log_so3(R) / DEG), *(rpy_from_rotation(R) / DEG)]
        lines.append(_row(start, end, *map(_signed, numbers)))
    return "\n".join([*lines, ""])


def _signed(number: float) -> str:
    """Return a number with its sign and nine decimals; one that is zero to these is +0."""
    return f"{round(float(number), 9) + 0.0:+.9f}"


def _joint_rows(cells: Sequence[Sequence[str]]) -> list[str]:
    """Return the lines of a table with a row for each joint, from the five cells of each."""
    return [
        _row("joint", "a [mm]", "alpha [deg]", "d [mm]", "theta [deg]", "beta [deg]"),
        _rule(6),
        *(_row(str(i), *of_joint) for i, of_joint in enumerate(cells, start=1)),
    ]


def _cells_of_change(change: Array, std: Array) -> list[str]:
    """Return the changes of the five parameters of a joint, each with its standard deviation unless that is NaN."""
    return [
        value if np.isnan(s) else f"{value} ± {error}"
        for value, error, s in zip(_cells(change, "+.5f"), _cells(std, ".5f"), std, strict=True)
    ]


def beyond_standard_dh(robot: Robot) -> str:
    """Return a sentence that names the angles beta of an arm and the position error of plain standard DH without them; empty if all are zero."""
    betas = robot.geometry[GEOMETRY.index("beta"), 1:]
    if not betas.any():
        return ""
    q = random_joints(robot)
    distance = np.linalg.norm((robot.flange(q) - without_beta(robot).flange(q))[:, :3, 3], axis=1)
    *others, last = (str(i + 1) for i in np.flatnonzero(betas))
    rows = f"rows {', '.join(others)} and {last}" if others else f"row {last}"
    return (
        f"Standard DH alone has no beta: a controller that cannot take it in {rows} puts the flange "
        f"{np.sqrt(np.mean(distance**2)) / MM:.4f} mm RMS (at most {distance.max() / MM:.4f} mm) off at {len(q)} random poses."
    )


def standard_deviations(calibration: Calibration, rigid: RigidPart) -> Array:
    """Return the standard deviations ``(5, n)`` [m, rad] of the geometry of the rigid part, NaN where it is fixed.

    An entry is a parameter g of the model plus what the coefficients c of included effects add, ``g + B c`` (beta is estimated as the effect
    ``axis_nonparallel``), so its variance is that of this sum.

    Args:
        calibration: The calibration, with the covariance of its free parameters.
        rigid: Its rigid part.
    """
    names = rigid.robot.parameter_names
    index = {name: i for i, name in enumerate(names)}
    D = np.zeros((len(names), len(calibration.free)))
    for k, name in enumerate(calibration.free):
        if name in index:
            D[index[name], k] = 1.0
        elif name in rigid.added_by:
            D[:, k] = rigid.added_by[name].ravel()
    variance = np.einsum("ik,kl,il->i", D, calibration.covariance, D)
    return np.where(D.any(axis=1), np.sqrt(variance), np.nan).reshape(len(GEOMETRY), -1)


def _table(calibration: Calibration, rigid: RigidPart, state: str, standard: bool) -> Array:
    """Return the parameters ``(5, n)`` [m, rad] for one of ``_STATES``: the calibrated ones, the nominal ones, or their standard deviations."""
    if state == "_std":
        std = standard_deviations(calibration, rigid)
        return standard_rows(std, (np.nan, np.nan, np.nan)) if standard else std
    robot = calibration.model.nominal if state else rigid.robot
    return standard_table(robot).rows if standard else robot.geometry


def _cells(values: Array, form: str) -> list[str]:
    """Return the five parameters [m, rad] of a joint in millimetres and degrees, as text."""
    units = [MM if kind in LENGTHS else DEG for kind in GEOMETRY]
    return [f"{value / unit + 0.0:{form}}" for value, unit in zip(values, units, strict=True)]


def _row(*cells: str) -> str:
    return f"| {' | '.join(cells)} |"


def _rule(n: int) -> str:
    return "|" + " --- |" * n
