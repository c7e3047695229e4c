"""How Sphinx builds the documentation: `make docs`, or python -m sphinx -W docs results/docs."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Any

DOCS = Path(__file__).resolve().parent
sys.path[:0] = [str(DOCS.parent), str(DOCS.parent / "workflow")]
for _library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{_library}_NUM_THREADS", "1")

import scalar  # noqa: E402

project = "SCALAR"
author = "The SCALAR contributors"
version = release = scalar.__version__
project_copyright = author

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_gallery.gen_gallery",
    "docs.site.mathml",
]
exclude_patterns = [
    "examples",
    "generated/api.md",
    "generated/mapping_keys.md",
    "generated/commands.md",
    "generated/effects_table.md",
    "**/sg_execution_times.rst",
    "sg_execution_times.rst",
]
nitpicky = False

myst_enable_extensions = ["dollarmath", "deflist"]
myst_heading_anchors = 3

html_theme = "furo"
html_title = f"SCALAR {release}"
html_math_renderer = "mathml"
html_copy_source = False
html_show_sphinx = False

autodoc_member_order = "bysource"
autodoc_preserve_defaults = True  # DEFAULTS, and not all that they hold
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_default_options = {"members": True, "undoc-members": False, "show-inheritance": False}
napoleon_google_docstring = True
napoleon_numpy_docstring = False
napoleon_use_ivar = True

sphinx_gallery_conf = {
    "examples_dirs": "examples",
    "gallery_dirs": "generated/examples",
    "filename_pattern": r"/[a-z_]+\.py",
    "abort_on_example_error": True,
    "download_all_examples": False,
    "show_memory": False,
    "show_signature": False,
    "min_reported_time": 1e9,
    "write_computation_times": False,
    "remove_config_comments": True,
    "capture_repr": (),  # what is printed is shown, values of last lines are not
}


def _write_generated(_app: Any, _config: Any) -> None:
    """Write the pages that are made of the code, before Sphinx looks for pages."""
    from docs.site import api_pages, command_pages, effect_pages, mapping_table
    from docs.site.catalogue import CATALOGUE, simulated

    generated = DOCS / "generated"
    command_pages.write_page(generated / "commands.md")
    mapping_table.write_table(generated / "mapping_keys.md")
    api_pages.write_page(generated / "api.md")
    # With all that a scene can record, and with a stop: an effect is asked for where its columns are.
    every = ["time", "temperature", "approach", "payload", "torque"]
    dataset = simulated(CATALOGUE["joint_harmonic"], poses_per_plane=4, record=every, stops={"count": 1})
    effect_pages.write_pages(generated / "effects", dataset)
    effect_pages.write_table(generated / "effects_table.md")


def setup(app: Any) -> None:
    """Have the generated pages written."""
    app.connect("config-inited", _write_generated, priority=100)
