"""Small pictures as SVG that is part of the page: letters stay letters, a phone scales them, and the same
numbers give the same bytes.

A picture of 3,000 poses is one path of dots, a few kilobytes; colours and line widths stand in the page's
style sheet. Everything that comes from a dataset is escaped here.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from markupsafe import Markup, escape

from scalar.geometry.se3 import Array

WIDTH, HEIGHT = 400, 284
_LEFT, _RIGHT, _TOP, _BOTTOM = 46, 12, 40, 40
_STEPS = (1.0, 2.0, 2.5, 5.0, 10.0)
_ANGLES = (1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 45.0, 60.0, 90.0, 180.0)


def nice_ticks(low: float, high: float, count: int, angle: bool = False) -> Array:
    """Return round numbers within a range, about ``count`` of them; degrees in parts of a turn where they
    are large."""
    span = max(high - low, 1e-300)
    if angle and span > 4.0:
        step = min(_ANGLES, key=lambda s: abs(span / s - count))
    else:
        power = 10.0 ** np.floor(np.log10(span / count))
        step = min((s * power for s in _STEPS), key=lambda s: abs(span / s - count))
    first, last = np.ceil(low / step - 1e-9), np.floor(high / step + 1e-9)
    return np.arange(first, last + 1) * step


def tick_labels(ticks: Array) -> list[str]:
    """Return ticks as text, all with as many decimals as their step needs, and with a true minus."""
    step = float(ticks[1] - ticks[0]) if len(ticks) > 1 else abs(float(ticks[0])) if len(ticks) else 1.0
    decimals = next((d for d in range(9) if abs(step * 10**d - round(step * 10**d)) < 1e-6 * step * 10**d), 8)
    texts = [f"{0.0 if abs(t) < step * 1e-6 else t:.{decimals}f}" for t in ticks]
    return [text.replace("-", "−") for text in texts]


class Panel:
    """Axes with things drawn on them, in the order of the calls."""

    def __init__(
        self,
        x_range: tuple[float, float],
        y_range: tuple[float, float],
        *,
        title: str,
        x_label: str,
        y_label: str,
        x_is_angle: bool = False,
        y_is_angle: bool = False,
        height: int = HEIGHT,
        width: int = WIDTH,
    ) -> None:
        self.x_range, self.y_range, self.height, self.width = x_range, y_range, height, width
        self._parts: list[str] = []
        self._legend: list[str] = []
        right, bottom = width - _RIGHT, height - _BOTTOM
        x_ticks, y_ticks = nice_ticks(*x_range, 5, x_is_angle), nice_ticks(*y_range, 5, y_is_angle)
        for tick, text in zip(x_ticks, tick_labels(x_ticks), strict=True):
            x = self.x(tick)
            self._parts.append(f'<path class="grid" d="M{x:.1f} {_TOP}V{bottom}"/>')
            self._parts.append(
                f'<text class="tick" x="{x:.1f}" y="{bottom + 14}" text-anchor="middle">{text}</text>'
            )
        for tick, text in zip(y_ticks, tick_labels(y_ticks), strict=True):
            y = self.y(tick)
            self._parts.append(f'<path class="grid" d="M{_LEFT} {y:.1f}H{right}"/>')
            self._parts.append(
                f'<text class="tick" x="{_LEFT - 5}" y="{y + 3.5:.1f}" text-anchor="end">{text}</text>'
            )
        if y_range[0] < 0 < y_range[1]:
            self._parts.append(f'<path class="zero" d="M{_LEFT} {self.y(0):.1f}H{right}"/>')
        middle = (_LEFT + right) / 2
        self._labels = [
            f'<text class="axis" x="{middle:.0f}" y="{height - 8}" text-anchor="middle">'
            f"{escape(x_label)}</text>",
            f'<text class="name" x="2" y="13">{escape(title)}</text>',
            # Level, not turned: it is read on a phone as well, and has the whole width.
            f'<text class="axis" x="2" y="29">{escape(y_label)}</text>',
        ]

    def x(self, value: float) -> float:
        """Return where a value of x stands."""
        low, high = self.x_range
        return _LEFT + (float(value) - low) / (high - low) * (self.width - _LEFT - _RIGHT)

    def y(self, value: float) -> float:
        """Return where a value of y stands."""
        low, high = self.y_range
        return self.height - _BOTTOM - (float(value) - low) / (high - low) * (self.height - _TOP - _BOTTOM)

    def _inside(self, x: Array, y: Array) -> Array:
        inside = np.isfinite(x) & np.isfinite(y)
        return (
            inside
            & (y >= self.y_range[0])
            & (y <= self.y_range[1])
            & (x >= self.x_range[0])
            & (x <= self.x_range[1])
        )

    def dots(self, x: Array, y: Array, css: str) -> int:
        """Draw a dot at each point that lies within the axes; return how many do not."""
        inside = self._inside(x, y)
        path = "".join(
            f"M{self.x(a):.1f} {self.y(b):.1f}h0" for a, b in zip(x[inside], y[inside], strict=True)
        )
        self._parts.append(f'<path class="{css}" d="{path}"/>')
        return int(np.count_nonzero(~inside))

    def marks(self, x: Array, y: Array, size: Array, shape: str, css: str) -> None:
        """Draw triangles (``up``, ``down``), crosses (``cross``) or squares, ``size`` across, at points
        within the axes."""
        inside = self._inside(x, y)
        path = []
        for a, b, s in zip(x[inside], y[inside], np.broadcast_to(size, x.shape)[inside], strict=True):
            px, py, h = self.x(a), self.y(b), s / 2
            if shape == "cross":
                path.append(f"M{px - h:.1f} {py - h:.1f}l{s:.1f} {s:.1f}m0 {-s:.1f}l{-s:.1f} {s:.1f}")
            elif shape == "square":
                path.append(f"M{px - h:.1f} {py - h:.1f}h{s:.1f}v{s:.1f}h{-s:.1f}z")
            else:
                sign = -1 if shape == "up" else 1
                path.append(
                    f"M{px - h:.1f} {py - sign * h * 0.7:.1f}h{s:.1f}l{-h:.1f} {sign * s * 0.85:.1f}z"
                )
        self._parts.append(f'<path class="{css}" d="{"".join(path)}"/>')

    def line(self, x: Array, y: Array, css: str) -> None:
        """Draw a line through points, cut at the axes."""
        good = np.isfinite(x) & np.isfinite(y)
        y = np.clip(y[good], *self.y_range)
        points = " ".join(f"{self.x(a):.1f},{self.y(b):.1f}" for a, b in zip(x[good], y, strict=True))
        self._parts.append(f'<polyline class="{css}" points="{points}"/>')

    def band(self, x: Array, low: Array, high: Array, css: str) -> None:
        """Fill between two lines."""
        low, high = np.clip(low, *self.y_range), np.clip(high, *self.y_range)
        points = [*zip(x, high, strict=True), *zip(x[::-1], low[::-1], strict=True)]
        text = " ".join(f"{self.x(a):.1f},{self.y(b):.1f}" for a, b in points)
        self._parts.append(f'<polygon class="{css}" points="{text}"/>')

    def bars(self, x: Array, y: Array, error: Array, css: str) -> None:
        """Draw error bars of one standard error, with a dot in the middle."""
        good = self._inside(x, y)
        path = []
        for a, b, e in zip(x[good], y[good], error[good], strict=True):
            low, high = np.clip([b - e, b + e], *self.y_range)
            path.append(f"M{self.x(a):.1f} {self.y(low):.1f}V{self.y(high):.1f}")
        self._parts.append(f'<path class="{css}-bar" d="{"".join(path)}"/>')
        self.dots(x, y, css)

    def moment(self, x: float, text: str) -> None:
        """Mark a value of x by a line with a word."""
        at = self.x(x)
        end = at > self.width * 0.6
        self._parts.append(f'<path class="moment" d="M{at:.1f} {_TOP}V{self.height - _BOTTOM}"/>')
        anchor = 'text-anchor="end" ' if end else ""
        place = f'{anchor}x="{at + (-4 if end else 4):.1f}" y="{_TOP + 10}"'
        self._parts.append(f'<text class="tick" {place}>{escape(text)}</text>')

    def steps(self, edges: Array, heights: Array, css: str) -> None:
        """Draw a histogram."""
        base = self.y(max(self.y_range[0], 0.0))
        path = [
            f"M{self.x(a):.1f} {base:.1f}V{self.y(h):.1f}H{self.x(b):.1f}V{base:.1f}z"
            for a, b, h in zip(edges[:-1], edges[1:], np.minimum(heights, self.y_range[1]), strict=True)
            if h > 0
        ]
        self._parts.append(f'<path class="{css}" d="{"".join(path)}"/>')

    def markup(self, alt: str) -> Markup:
        """Return the picture, with what it shows in words for those who do not see it."""
        body = "".join([*self._parts, *self._labels])
        return Markup(
            f'<svg viewBox="0 0 {self.width} {self.height}" role="img" aria-label="{escape(alt)}">'
            f"<title>{escape(alt)}</title>{body}</svg>"
        )


def range_of(values: Sequence[Array], share: float = 1.0, around_zero: bool = False) -> tuple[float, float]:
    """Return a range that holds a share of all finite values, with a margin; about zero where asked."""
    pool = np.concatenate([np.asarray(v, dtype=float).ravel() for v in values])
    pool = pool[np.isfinite(pool)]
    if not len(pool):
        return -1.0, 1.0
    tail = (1.0 - share) / 2
    low, high = (float(v) for v in np.quantile(pool, [tail, 1.0 - tail]))
    if around_zero:
        low, high = min(low, 0.0), max(high, 0.0)
    margin = 0.06 * (high - low) or max(abs(high), 1e-12) * 0.1
    return low - margin, high + margin
