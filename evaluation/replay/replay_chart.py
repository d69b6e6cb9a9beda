"""A replay as a picture."""

from __future__ import annotations

import math
from io import BytesIO
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse

from handcart.files.whole_file import write_whole

from .replay import Replayed

TRACK, TRUTH, REFUSED, FIX = "#0072b2", "#000000", "#d55e00", "#999999"  # Okabe and Ito (2008)
ELLIPSES = 25  # along the track
SIGMAS = 3.0


def draw_replay(replayed: Replayed, path: Path, title: str) -> None:
    """The track with what is claimed of it, the fixes, and the reference; below, errors against claims.

    Args:
        replayed: what is drawn.
        path: an .svg, .png or .pdf file.
        title: stands above it.

    Raises:
        OSError: it can't be written.
    """
    figure = Figure(figsize=(8.0, 9.0), layout="constrained")
    above, below = figure.subplots(2, 1, height_ratios=[3.0, 1.0])
    above.set_title(title)
    _draw_fixes(above, replayed)
    above.plot(*replayed.poses[:, :2].T, color=TRACK, linewidth=1.5, label="estimated", zorder=3)
    if np.isfinite(replayed.truth[:, :2]).any():
        above.plot(*replayed.truth[:, :2].T, color=TRUTH, linewidth=1.0, linestyle="--", label="reference")
    _draw_claims(above, replayed)
    above.set_aspect("equal", adjustable="datalim")
    above.set_xlabel("x, east [m]")
    above.set_ylabel("y, north [m]")
    above.legend(loc="best")
    _draw_errors(below, replayed)
    packed = BytesIO()
    figure.savefig(packed, format=path.suffix.removeprefix(".") or "svg", dpi=120)
    write_whole(path, packed.getvalue())


def _draw_fixes(axes: Axes, replayed: Replayed) -> None:
    for believed, color, sign, words in ((True, FIX, ".", "fix"), (False, REFUSED, "x", "refused fix")):
        places = np.array([fix.position for fix in replayed.fixes if fix.believed == believed])
        if len(places):
            axes.plot(*places.T, sign, color=color, markersize=4, label=f"{words} ({len(places)})")


def _draw_claims(axes: Axes, replayed: Replayed) -> None:
    """Ellipses of three claimed sigma, where the heading is known."""
    for row in np.unique(np.linspace(0, len(replayed.times) - 1, ELLIPSES).astype(int)):
        if not replayed.known[row]:
            continue
        values, vectors = np.linalg.eigh(replayed.covariances[row, :2, :2])
        width, height = 2.0 * SIGMAS * np.sqrt(np.maximum(values, 0.0))
        angle = math.degrees(math.atan2(vectors[1, 0], vectors[0, 0]))
        ring = Ellipse(
            tuple(replayed.poses[row, :2]), width, height, angle=angle, fill=False, edgecolor=TRACK
        )
        ring.set_linewidth(0.7)
        axes.add_patch(ring)


def _draw_errors(axes: Axes, replayed: Replayed) -> None:
    claimed = SIGMAS * np.sqrt(np.trace(replayed.covariances[:, :2, :2], axis1=1, axis2=2))
    claimed = np.where(replayed.known, claimed, math.nan)
    axes.plot(replayed.times, claimed, color=TRACK, label="three claimed sigma")
    if np.isfinite(replayed.truth[:, :2]).any():
        off = np.hypot(*replayed.errors[:, :2].T)
        axes.plot(replayed.times, off, color=TRUTH, linewidth=1.0, label="off the reference")
    axes.set_xlabel("time [s]")
    axes.set_ylabel("[m]")
    axes.set_ylim(bottom=0.0)
    axes.legend(loc="best")
