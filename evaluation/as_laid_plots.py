"""`as_laid.svg`: a deployment as figures 3 and 7 to 10 of Ohki et al. (2012) show theirs."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from .as_laid_report import NAME, AsLaid
from .field_survey import FieldSurvey

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FIX, ODOMETRY, ESTIMATE, TRUTH = "#e0c000", "#3b6fd4", "#d62828", "#111111"
LAID = "#e05fa0"


def draw_as_laid(folder: Path, survey: FieldSurvey, sensors: list[AsLaid]) -> Path:
    """Draw a run's localization, its trajectory and errors into its folder; gives the picture's path."""
    import matplotlib
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.0, 11.0), layout="constrained")
    axes = figure.subplot_mosaic([["track", "track"], ["hand", "hand"], ["errors", "ellipses"]])
    _track(axes["track"], survey)
    _hand(axes["hand"], survey)
    _errors(axes["errors"], survey)
    _ellipses(axes["ellipses"], survey, sensors)
    for each in axes.values():
        each.set_aspect("equal", adjustable="datalim")
        each.grid(alpha=0.3)
    path = folder / f"{NAME}.svg"
    with matplotlib.rc_context({"svg.hashsalt": "handcart"}):
        figure.savefig(path, metadata={"Date": None})
    return path


def _track(axes: Axes, survey: FieldSurvey) -> None:
    """Figure 3: fixes, odometry and what becomes of them."""
    axes.set_title("localization [m]")
    for name, colour in (("odometry", ODOMETRY), ("truth", TRUTH), ("estimate", ESTIMATE)):
        if survey.tracks[name]:
            axes.plot(*np.array(survey.tracks[name]).T, color=colour, lw=1.0, label=name)
    if survey.tracks["fixes"]:
        axes.plot(*np.array(survey.tracks["fixes"]).T, ".", color=FIX, ms=3.0, label="GPS", zorder=0)
        axes.legend(loc="best", fontsize="small")


def _hand(axes: Axes, survey: FieldSurvey) -> None:
    """Figures 7 and 8: the hand's trajectory by the total station, and what it let go."""
    axes.set_title("hand by the total station, and sensors [m]")
    sights = survey.station.sights if survey.station is not None else []
    if sights:
        axes.plot(*np.array([sight.place[:2] for sight in sights]).T, ".", color=ODOMETRY, ms=1.5)
    seen = [each.measured for each in survey.placements() if each.measured is not None]
    if seen:
        axes.plot(*np.array(seen).T, "o", color=LAID, ms=5.0)
    targets = np.array([each.target for each in survey.placements()]).reshape(-1, 2)
    axes.plot(*targets.T, "+", color=TRUTH, ms=7.0)


def _errors(axes: Axes, survey: FieldSurvey) -> None:
    """Figures 9 and 10: errors about their mean."""
    axes.set_title("errors about their mean [mm]")
    errors = np.array([each.error_mm for each in survey.placements() if each.error_mm is not None])
    if len(errors):
        axes.plot(*(errors - errors.mean(axis=0)).T, "o", color=LAID, ms=5.0)


def _ellipses(axes: Axes, survey: FieldSurvey, sensors: list[AsLaid]) -> None:
    """What the report says against where the sensors lie."""
    axes.set_title("as laid: 95 % ellipses about the true place [mm]")
    lies = {each.name: np.array(each.lies) for each in survey.placements()}
    for sensor in sensors:
        if sensor.name in lies:
            axes.plot(*(1e3 * (sensor.outline - lies[sensor.name])).T, color=ESTIMATE, lw=0.6)
    axes.plot(0.0, 0.0, "+", color=TRUTH, ms=9.0)
