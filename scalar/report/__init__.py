"""The report of a diagnosis, and the page of a calibration: each is one HTML file that opens offline."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from jinja2 import Environment

    from scalar.data.dataset import Dataset
    from scalar.diagnosis.result import Diagnosis
    from scalar.estimation.result import Calibration

DIAGNOSIS, CALIBRATION = "report.html.jinja", "calibration.html.jinja"


def render_report(diagnosis: Diagnosis, run: str | None = None) -> str:
    """Return the report as HTML.

    The file contains its style, and its pictures as SVG. Nothing is fetched and no script runs; names from the
    dataset are escaped. The same diagnosis gives the same bytes. The page stays under 3 MB: if there are too many
    values for that, pictures draw some of them and say so.

    Args:
        diagnosis: The diagnosis to report.
        run: Identifier of the run, which the other files of the result state too; None if there are no others.
    """
    from scalar.report.page import page
    from scalar.report.pose_numbers import with_pose_numbers

    return with_pose_numbers(_rendered(DIAGNOSIS, page(diagnosis), run), diagnosis.dataset)


def render_calibration(calibration: Calibration, dataset: Dataset, run: str | None = None) -> str:
    """Return the page of a calibration as HTML, of the same kind as ``render_report``: the error over the workspace, and every parameter.

    Args:
        calibration: The calibration to report.
        dataset: The dataset from which it was estimated.
        run: As for ``render_report``.
    """
    from scalar.report.calibration_page import calibration_page
    from scalar.report.pose_numbers import with_pose_numbers

    return with_pose_numbers(_rendered(CALIBRATION, calibration_page(calibration, dataset), run), dataset)


def _rendered(template: str, content: Mapping[str, Any], run: str | None) -> str:
    """Return a template filled with its content."""
    from scalar import __version__
    from scalar.report.inline_svg import COLOURS
    from scalar.report.visible import visible

    filled = (
        _environment().get_template(template).render(content, version=__version__, run=run, colours=COLOURS)
    )
    return visible(filled)


def prepare() -> None:
    """Import and compile what every report of a diagnosis needs, so that processes that are forked later need not."""
    from scalar.report import page, pose_numbers, visible  # noqa: F401
    from scalar.report.panel import Panel

    Panel((0.0, 1.0), (0.0, 1.0), title="", x_label="", y_label="").markup(
        ""
    )  # Matplotlib's styles and fonts
    environment = _environment()
    for name in environment.list_templates():
        environment.get_template(name)


@lru_cache(maxsize=1)
def _environment() -> Environment:
    """Return what loads and compiles the templates; it keeps those that are compiled."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    from scalar.report.lead_in import is_warning, lead_in

    environment = Environment(
        loader=PackageLoader("scalar.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.globals["lead_in"] = lead_in
    environment.globals["is_warning"] = is_warning
    return environment
