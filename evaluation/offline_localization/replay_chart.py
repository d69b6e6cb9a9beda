"""Chart of a replay."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse

from handcart.evaluation.viewing.drawing.figure_file import save_figure
from handcart.evaluation.viewing.drawing.palette import BLACK, BLUE, GREEN, GREY, VERMILION
from handcart.evaluation.viewing.drawing.plain_text import plain

from .replay import Replayed

PARTICLE_COLOUR = GREEN
TRACK_COLOUR, TRUTH_COLOUR, REFUSED_COLOUR, FIX_COLOUR = BLUE, BLACK, VERMILION, GREY
CHART_WIDTH_IN = 9.0
CLOUD_RADIUS_M = 1.0  # on each side of a cloud's centre
ELLIPSE_COUNT = 25  # along the track
CLAIM_SIGMAS = 3.0


def draw_replay(replayed: Replayed, path: Path, title: str) -> None:
    """Draw a replay: track, claimed uncertainty, fixes, reference and particles, and errors over time.

    Args:
        replayed: result of running a localizer on a log of recorded readings.
        path: an .svg, .png or .pdf file.
        title: title of the chart.

    Raises:
        OSError: the file cannot be written.
    """
    tall, rows = _tallness(replayed), ["track"] * max(1, len(replayed.clouds))
    panels = [rows, ["errors"] * len(rows)]
    heights = [CHART_WIDTH_IN * tall, 2.2]
    if replayed.clouds:
        panels.insert(1, [f"cloud {number}" for number in range(len(rows))])
        heights.insert(1, 1.8)
    figure = Figure(figsize=(CHART_WIDTH_IN, sum(heights) + 1.0), layout="constrained")
    axes = figure.subplot_mosaic(panels, height_ratios=heights)  # type: ignore[arg-type]
    above, below = axes["track"], axes["errors"]
    above.set_title(plain(title))
    _draw_fixes(above, replayed)
    above.plot(*replayed.poses[:, :2].T, color=TRACK_COLOUR, linewidth=1.5, label="estimated", zorder=3)
    if np.isfinite(replayed.truth[:, :2]).any():
        above.plot(
            *replayed.truth[:, :2].T, color=TRUTH_COLOUR, linewidth=1.0, linestyle="--", label="reference"
        )
    _draw_claims(above, replayed)
    above.set_aspect("equal", adjustable="datalim")
    above.set_xlabel("x, east [m]")
    above.set_ylabel("y, north [m]")
    above.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
    for number in range(len(replayed.clouds)):
        _draw_cloud(axes[f"cloud {number}"], replayed, number)
    _draw_errors(below, replayed)
    save_figure(figure, path, dpi=120)


def _draw_fixes(axes: Axes, replayed: Replayed) -> None:
    for believed, color, sign, words in (
        (True, FIX_COLOUR, ".", "fix"),
        (False, REFUSED_COLOUR, "x", "refused fix"),
    ):
        places = np.array([fix.position for fix in replayed.fixes if fix.believed == believed])
        if len(places):
            axes.plot(*places.T, sign, color=color, markersize=4, label=f"{words} ({len(places)})")


def _draw_claims(axes: Axes, replayed: Replayed) -> None:
    """Draw ellipses of three claimed standard deviations where the heading is known."""
    for row in np.unique(np.linspace(0, len(replayed.times) - 1, ELLIPSE_COUNT).astype(int)):
        if not replayed.known[row]:
            continue
        values, vectors = np.linalg.eigh(replayed.covariances[row, :2, :2])
        width, height = 2.0 * CLAIM_SIGMAS * np.sqrt(np.maximum(values, 0.0))
        angle = math.degrees(math.atan2(vectors[1, 0], vectors[0, 0]))
        ring = Ellipse(
            tuple(replayed.poses[row, :2]), width, height, angle=angle, fill=False, edgecolor=TRACK_COLOUR
        )
        ring.set_linewidth(0.7)
        axes.add_patch(ring)


def _tallness(replayed: Replayed) -> float:
    """Return the height of the track's panel, in widths of the picture."""
    places = np.array([fix.position for fix in replayed.fixes] or replayed.poses[:, :2])
    width, height = (float(np.quantile(axis, 0.99) - np.quantile(axis, 0.01)) + 1.0 for axis in places.T)
    return min(0.9, max(0.25, 0.8 * height / width))


def _draw_cloud(axes: Axes, replayed: Replayed, number: int) -> None:
    """Draw the particles at an instant around their mean, as in figure 3 of Ohki et al. (2012)."""
    time, (x, y, _) = replayed.clouds[number]
    axes.plot(x - x.mean(), y - y.mean(), ".", color=PARTICLE_COLOUR, markersize=1)
    row = int(np.argmin(np.abs(replayed.times - time)))
    if np.isfinite(replayed.truth[row, :2]).all():
        axes.plot(*(replayed.truth[row, :2] - (x.mean(), y.mean())), "+", color=TRUTH_COLOUR, markersize=10)
    axes.set_title(f"{time - replayed.times[0]:.0f} s", fontsize="medium")
    axes.set_xlim(-CLOUD_RADIUS_M, CLOUD_RADIUS_M)
    axes.set_ylim(-CLOUD_RADIUS_M, CLOUD_RADIUS_M)
    axes.set_aspect("equal")
    axes.set_xlabel("[m]")
    if number:
        axes.set_yticklabels([])
    else:
        axes.set_ylabel("particles; + reference")


def _draw_errors(axes: Axes, replayed: Replayed) -> None:
    claimed = CLAIM_SIGMAS * np.sqrt(np.trace(replayed.covariances[:, :2, :2], axis1=1, axis2=2))
    claimed = np.where(replayed.known, claimed, math.nan)
    times = replayed.times - replayed.times[0]
    axes.plot(times, claimed, color=TRACK_COLOUR, label="three claimed sigma")
    if np.isfinite(replayed.truth[:, :2]).any():
        off = np.hypot(*replayed.errors[:, :2].T)
        axes.plot(times, off, color=TRUTH_COLOUR, linewidth=1.0, label="off the reference")
    axes.set_xlabel("time [s]")
    axes.set_ylabel("[m]")
    axes.set_ylim(bottom=0.0)
    axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
