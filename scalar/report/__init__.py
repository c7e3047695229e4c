"""The report of a diagnosis, one HTML file that opens offline."""

from __future__ import annotations

from typing import Any


def render_report(diagnosis: Any) -> str:
    """Return the report as HTML."""
    return "<!doctype html><title>diagnosis</title>"
