"""`as_laid.svg`: a deployment as figures 3 and 7 to 10 of Ohki et al. (2012) show theirs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

import numpy as np

from handcart.evaluation.viewing.drawing.figure_file import save_figure
from handcart.evaluation.viewing.drawing.legend import add_legend
from handcart.evaluation.viewing.drawing.palette import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, VERMILION
from handcart.robotics.numerics.arrays import FloatArray

from .as_laid_report import REPORT_NAME, AsLaid
from .laid_placement import Place, Placement
from .total_station import TotalStation

if TYPE_CHECKING:
    from matplotlib.axes import Axes


FIX, CLOUD, ODOMETRY, ESTIMATE, TRUTH = ORANGE, GREEN, BLUE, VERMILION, BLACK
LAID, UNSEEN = PURPLE, GREY
PLOT_WIDTH_IN = 11.0  # [in]
PLOT_HEIGHTS_IN = (1.9, 5.5)  # [in] of a panel with the course
MAX_DRAWN_POINTS = 1500  # points of a kind: more aren't seen, and make the file large
CHI2_95_2D = 5.991  # squared distance in sigmas that 95 % keep, of two degrees of freedom

PAPER_MM = (("figure 9, straight", 58.0, 148.0, "--"), ("figure 10, zigzag", 283.0, 123.0, ":"))
"""Title, standard deviations in x and y in [mm], and line style, by figures of Ohki et al. (2012), section
VI.
"""


class Laying(Protocol):
    """Interface of the data that plots show of a run in which the robot lays out seismic sensors."""

    tracks: dict[str, list[Place]]
    station: TotalStation | None

    def placements(self) -> list[Placement]:
        """Return the wanted (target), estimated, measured and true position of each sensor that the robot
        released.
        """
        ...


def draw_as_laid(folder: Path, survey: Laying, sensors: list[AsLaid]) -> Path:
    """Draw plots of a run that laid sensors, into its folder, and return the path of the picture.

    They show the trajectory, the hand, and the errors of localization and placement.
    """
    from matplotlib.figure import Figure

    tall = _tall(survey)
    figure = Figure(figsize=(PLOT_WIDTH_IN, 2 * tall + 5.0), layout="constrained")
    axes = figure.subplot_mosaic(
        [["track", "track"], ["hand", "hand"], ["errors", "ellipses"]], height_ratios=[tall, tall, 5.0]
    )
    _track(axes["track"], survey)
    _hand(axes["hand"], survey)
    _errors(axes["errors"], survey)
    _ellipses(axes["ellipses"], survey, sensors)
    is_straight = tall <= PLOT_HEIGHTS_IN[0]
    for name in ("track", "hand"):
        _set_course_scale(axes[name], is_straight)
    for name in ("errors", "ellipses"):
        axes[name].set_ylabel("y [mm]")
        axes[name].set_aspect("equal", adjustable="box")
    for panel in axes.values():
        panel.grid(alpha=0.3)
    axes["hand"].sharex(axes["track"])
    axes["hand"].set_xlabel("x [m]")
    _same_scale(axes["errors"], axes["ellipses"])
    path = folder / f"{REPORT_NAME}.svg"
    save_figure(figure, path)
    return path


def _set_course_scale(axes: Axes, is_straight: bool) -> None:
    """Scale a panel with the course; the y axis of a straight course is stretched to show its errors."""
    axes.set_ylabel("y [m], stretched" if is_straight else "y [m]")
    if not is_straight:
        axes.set_aspect("equal", adjustable="datalim")


def _same_scale(*axes: Axes) -> None:
    """Give all axes the limits of the widest one, symmetric about zero."""
    most = max(abs(end) for axis in axes for end in (*axis.get_xlim(), *axis.get_ylim()))
    for axis in axes:
        axis.set(xlim=(-most, most), ylim=(-most, most))


def _tall(survey: Laying) -> float:
    """Return the height of a panel with the whole course, in [in]."""
    if len(survey.tracks["truth"]) < 2:
        return PLOT_HEIGHTS_IN[0]
    long, high = np.ptp(np.array(survey.tracks["truth"]), axis=0)
    return float(np.clip(PLOT_WIDTH_IN * (high + 2.0) / (long + 2.0), *PLOT_HEIGHTS_IN))


def _thinned(points: Sequence[Place] | Sequence[FloatArray]) -> FloatArray:
    """Return points as (2, n), x and y in [m], thinned to at most `MAX_DRAWN_POINTS`."""
    return np.array(points[:: 1 + len(points) // MAX_DRAWN_POINTS]).T


def _track(axes: Axes, survey: Laying) -> None:
    """Draw fixes, particles, odometry, estimate and truth, as in figure 3."""
    axes.set_title("where the robot was, and where it took itself to be", loc="left")
    if survey.tracks["fixes"]:
        axes.plot(*_thinned(survey.tracks["fixes"]), ".", color=FIX, ms=2.5, label="GPS", zorder=0)
    if survey.tracks["particles"]:
        label = "particles, each 10 m"
        axes.plot(*_thinned(survey.tracks["particles"]), ".", color=CLOUD, ms=2.0, label=label, zorder=1)
    lines = (("odometry", ODOMETRY, 1.0), ("truth", TRUTH, 2.2), ("estimate", ESTIMATE, 0.9))
    for name, colour, wide in lines:
        if survey.tracks[name]:
            axes.plot(*_thinned(survey.tracks[name]), color=colour, lw=wide, label=name)
    _key(axes)


def _hand(axes: Axes, survey: Laying) -> None:
    """Draw the hand's trajectory by the total station, and the released sensors, as in figures 7 and 8."""
    axes.set_title("hand and sensors by the total station", loc="left")
    sights = survey.station.sights if survey.station is not None else []
    if sights:
        places = _thinned([sight.place[:2] for sight in sights])
        axes.plot(*places, ".", color=ODOMETRY, ms=1.5, label="hand")
    every = survey.placements()
    seen = [placement.measured for placement in every if placement.measured is not None]
    unseen = [placement.lies for placement in every if placement.measured is None]
    if seen:
        axes.plot(*np.array(seen).T, "o", color=LAID, ms=5.0, label="sensor")
    if unseen:
        axes.plot(
            *np.array(unseen).T, "o", mfc="none", color=UNSEEN, ms=5.0, label="out of its sight (truth)"
        )
    axes.plot(
        *np.array([placement.target for placement in every]).reshape(-1, 2).T,
        "+",
        color=TRUTH,
        label="target",
    )
    _key(axes)


def _key(axes: Axes) -> None:
    """Put the legend into the title's line, where no points are."""
    add_legend(axes, loc="lower right", bbox_to_anchor=(1.0, 1.0), fontsize="small", ncols=4, frameon=False)


def _errors(axes: Axes, survey: Laying) -> None:
    """Draw errors about their mean, and the standard deviations of the paper's, as in figures 9 and 10."""
    errors = np.array(
        [placement.error_mm for placement in survey.placements() if placement.error_mm is not None]
    )
    axes.set_title("errors by the total station, about their mean")
    if len(errors) > 1:
        axes.plot(*(errors - errors.mean(axis=0)).T, "o", color=LAID, ms=5.0)
        turn = np.linspace(0.0, 2.0 * np.pi, 100)
        for label, along, across, style in PAPER_MM:
            axes.plot(along * np.cos(turn), across * np.sin(turn), style, color=TRUTH, lw=1.0, label=label)
        above = {"loc": "upper left", "title": "standard deviation of the paper's", "title_fontsize": "small"}
        add_legend(axes, fontsize="small", **above)
        x, y = errors.std(axis=0, ddof=1)
        axes.set_xlabel(f"x [mm]; {len(errors)} seen, standard deviation {x:.0f} in x, {y:.0f} in y")


def _ellipses(axes: Axes, survey: Laying, sensors: list[AsLaid]) -> None:
    """Plot the report's ellipses against the sensors' true places."""
    axes.set_title("as-laid report about the true places")
    lies = {placement.name: np.array(placement.lies) for placement in survey.placements()}
    known = [sensor for sensor in sensors if sensor.name in lies]
    held = 0
    for sensor in known:
        off = sensor.place - lies[sensor.name]
        inside = bool(off @ np.linalg.solve(sensor.covariance, off) < CHI2_95_2D)
        held += inside
        colour, wide = (UNSEEN, 0.4) if inside else (ESTIMATE, 0.9)
        axes.plot(*(1e3 * (sensor.outline - lies[sensor.name])).T, color=colour, lw=wide)
    if known:
        axes.plot(*np.array([1e3 * (laid.place - lies[laid.name]) for laid in known]).T, ".", color=LAID)
    axes.plot(0.0, 0.0, "+", color=TRUTH, ms=12.0, mew=1.5)
    axes.set_xlabel(f"x [mm]; {held} of {len(known)} ellipses of 95 % hold the true place (grey)")
