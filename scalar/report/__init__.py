"""The report of a diagnosis, one HTML file that opens offline: tables in, pictures out."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from scalar.diagnosis.result import Diagnosis

TEMPLATE = "report.html.jinja"


def render_report(diagnosis: Diagnosis) -> str:
    """Return the report as HTML.

    Everything stands in the one file: the style, the pictures as SVG. Nothing is fetched, no script runs;
    names from the dataset are escaped, whatever they hold. The same diagnosis gives the same bytes. The page
    stays under 3 MB: where there are more values than it can hold, pictures draw some of them and say so.
    """
    from jinja2 import Environment, PackageLoader, StrictUndefined

    from scalar import __version__
    from scalar.report.inline_svg import COLOURS
    from scalar.report.page import page
    from scalar.report.visible import visible

    environment = Environment(
        loader=PackageLoader("scalar.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    template = environment.get_template(TEMPLATE)
    return visible(template.render(page(diagnosis), version=__version__, colours=COLOURS))
