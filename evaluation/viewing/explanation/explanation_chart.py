"""Chart of an explanation: readings and commands of the last seconds, next to what was seen."""

from __future__ import annotations

import math
import zipfile
from collections.abc import Callable, Sequence
from pathlib import Path
from textwrap import wrap
from typing import Any, NamedTuple

import numpy as np

from handcart.evaluation.viewing.drawing.figure_file import save_figure
from handcart.evaluation.viewing.drawing.legend import add_legend
from handcart.evaluation.viewing.drawing.palette import BLUE, GREY, PURPLE, SERIES_COLOURS, VERMILION
from handcart.evaluation.viewing.drawing.plain_text import plain
from handcart.files.errors import HandcartError
from handcart.networks.runs.flight_recorder import Readings, load_arrays, load_readings
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import ByteArray, FloatArray

from .explanation import Explanation
from .explanation_words import cause_words, measured_words

BUMPED_COLOUR = PURPLE
COMMAND_COLOUR, READING_COLOUR, RESTORED_COLOUR, LIMIT_COLOUR, SENSED_COLOUR = (
    "#999999",
    BLUE,
    "#fbe8cf",
    VERMILION,
    VERMILION,
)
LINE_LENGTH = 90  # characters
VIEW_RADIUS_M = 2.0  # around the robot
MIN_WAY_M = 0.02  # extent from which a driven way is seen in the picture
AHEAD_ANGLE_RAD = np.radians(20.0)  # to both sides of the heading, for the nearest range ahead


MOST_PIXELS = 50_000_000


class UnreadableEvidence(HandcartError):
    """Error for a damaged file of readings, points or a picture in a run's folder."""

    def __init__(self, path: Path, error: Exception) -> None:
        super().__init__(f"{path} can't be read: {error}")


class _Panel(NamedTuple):
    """One of the charts over time."""

    title: str
    sensor: str
    """Name of the capability that the chart shows."""
    unit: str
    needs: str
    """Name of the column that is required to draw the chart."""
    draw: Callable[[Any, Readings], None]


def draw_chart(explanation: Explanation, path: Path) -> None:
    """Draw a chart of the evidence about an action: picture, decisive measurement, causes and readings.

    Raises:
        UnreadableEvidence: readings, points or the picture are damaged.
        OSError: the file cannot be written.
    """
    try:
        _draw(explanation, path)
    except (LookupError, TypeError, ValueError, ArithmeticError, AttributeError) as error:
        kept = explanation.readings or explanation.points or explanation.picture or explanation.run.folder
        raise UnreadableEvidence(kept, error) from None


def _draw(explanation: Explanation, path: Path) -> None:
    from matplotlib.figure import Figure

    readings = _read(explanation.readings, load_readings) if explanation.readings else {}
    panels = [panel_ for panel_ in _PANELS if panel_.needs in readings]
    decided: dict[str, Any] = (explanation.causes[0].get("measured") or {}) if explanation.causes else {}
    figure = Figure(figsize=(12.0, max(5.5, 1.0 + 1.1 * len(panels))), layout="constrained")
    halves: Any = figure.subfigures(1, 2, width_ratios=[1.0, 1.1])
    left, right = halves
    seen, gauge, words = left.subplots(3, 1, height_ratios=[3.0, 0.2, 1.0])
    _draw_seen(seen, explanation, readings)
    _draw_decided(gauge, decided)
    words.set_axis_off()
    words.text(
        0.0, 1.0, plain(_chain(explanation)), va="top", fontsize=8, wrap=True, transform=words.transAxes
    )
    if panels:
        axes = right.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
        for axis, panel in zip(axes, panels, strict=True):
            _draw_panel(axis, panel, readings, explanation, decided)
        axes[-1].set_xlabel("time [s]; grey: commanded, shaded: restoring, orange: broken off, or a limit")
    figure.suptitle(plain(_title(explanation)), fontsize=10)
    save_figure(figure, path)


def _read(path: Path, read: Callable[[Path], Any]) -> Any:
    try:
        return read(path)
    except (OSError, ValueError, zipfile.BadZipFile) as error:
        raise UnreadableEvidence(path, error) from None


def _chain(explanation: Explanation) -> str:
    """Return the causes as text, one line for each link."""
    if explanation.action is None:
        return ""
    links = [line for cause in explanation.causes for line in cause_words(explanation.action, cause)]
    return "\n".join("\n    ".join(wrap(link, LINE_LENGTH)) for link in links)


def _title(explanation: Explanation) -> str:
    action = explanation.action
    if action is None:
        return f"{explanation.run.folder.name}: the end of the run"
    reason = f": {action.reason}" if action.reason else ""
    return f"{explanation.run.folder.name}, action {action.number}: {action.do} {action.outcome}{reason}"


# Observations


def _draw_seen(axis: Any, explanation: Explanation, readings: Readings) -> None:
    axis.set_anchor("N")
    if explanation.picture is not None:
        axis.imshow(_read(explanation.picture, _pixels))
        axis.set_title(plain(f"what was seen: {explanation.picture.stem}"), fontsize=8)
        axis.set_axis_off()
    elif "ranges_m" in readings or explanation.points is not None:
        _draw_plan(axis, explanation, readings)
    else:
        axis.set_axis_off()


def _pixels(path: Path) -> ByteArray:
    import cv2
    from PIL import Image

    with Image.open(path) as picture:
        if math.prod(picture.size) > MOST_PIXELS:
            raise ValueError(f"it has {picture.size[0]} x {picture.size[1]} pixels")
    pixels = cv2.imread(str(path))
    if pixels is None:
        raise ValueError("it is no picture")
    return cv2.cvtColor(pixels, cv2.COLOR_BGR2RGB).astype(np.uint8)


def _draw_plan(axis: Any, explanation: Explanation, readings: Readings) -> None:
    """Draw the robot from above at the instant of the decision, with its scan and the primitive's points."""
    points = _read(explanation.points, load_arrays) if explanation.points else {}
    middle = next(iter(points.values()))[0] if points else np.zeros(2)
    if len(readings.get("time_s", ())):
        now = _deciding(explanation, readings)
        middle = np.array([readings["x_m"][now], readings["y_m"][now]])
        pose = Pose2(float(middle[0]), float(middle[1]), float(readings["heading_rad"][now]))
        is_located = bool(readings["is_located"][now]) if "is_located" in readings else True
        if not is_located and len(points.get("hypotheses", ())):
            pose = _likeliest(points["hypotheses"], pose)
            middle = np.array(pose[:2])
        _draw_robot(axis, readings, pose)
        if "ranges_m" in readings:
            axis.plot(*_scan(readings, now, pose).T, ".", color=GREY, ms=2.0, label="scan")
        way = _with_gaps(readings)
        if is_located and _extent(way) >= MIN_WAY_M:
            axis.plot(way["x_m"], way["y_m"], color=READING_COLOUR, lw=1.0, label="driven")
    for name, style in (("planned", ":"), ("ahead", "--")):
        if name in points:
            axis.plot(*points[name].T, style, color=COMMAND_COLOUR, lw=1.2, label=name)
    if "sensed" in points:
        axis.plot(*points["sensed"].T, ".", color=SENSED_COLOUR, ms=4.0, label="sensed, not on the map")
    if "bumped" in points:
        axis.plot(*points["bumped"].T, color=BUMPED_COLOUR, lw=3.0, label="ran into something here")
    if "in the way" in points:
        axis.plot(*points["in the way"].T, "x", color="black", ms=10, mew=2, label="in the way")
    shown = middle[None]
    if "hypotheses" in points:
        places = points["hypotheses"][:, :2]
        shown = np.vstack([shown, places])
        axis.plot(*places.T, "*", color=COMMAND_COLOUR, ms=9.0, label="may be here")
    low, high = shown.min(axis=0) - VIEW_RADIUS_M, shown.max(axis=0) + VIEW_RADIUS_M
    axis.set_xlim(low[0], high[0])
    axis.set_ylim(low[1], high[1])
    axis.set_aspect("equal")
    axis.set_xlabel("x [m] on the map")
    axis.set_ylabel("y [m]")
    axis.set_title("from above, when it decided", fontsize=8)
    add_legend(axis, fontsize=7, loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)


def _extent(way: Readings) -> float:
    """Return the larger extent of a way along x or y, in [m]; 0 for none."""
    known = np.array([way["x_m"], way["y_m"]])
    known = known[:, np.isfinite(known).all(axis=0)]
    return float(np.ptp(known, axis=1).max()) if known.size else 0.0


def _likeliest(hypotheses: FloatArray, pose: Pose2) -> Pose2:
    """Return the first, best one of the poses (n, 3) or places (n, 2) at which the robot may be, in [m] and
    [rad].

    Files of old runs have places only; then the heading is that of `pose`.
    """
    x, y, heading = (*hypotheses[0].tolist(), pose.theta)[:3]
    return Pose2(float(x), float(y), float(heading))


def _deciding(explanation: Explanation, readings: Readings) -> int:
    """Return the row in which the motion was stopped, otherwise the last row."""
    end = np.inf if explanation.action is None else explanation.action.broken_off or np.inf
    return max(0, int(np.searchsorted(readings["time_s"], end + 1e-6)) - 1)


def _draw_robot(axis: Any, readings: Readings, pose: Pose2) -> None:
    from matplotlib.patches import Circle

    radius = float(readings.get("footprint_m", np.array(0.0)))
    axis.add_patch(Circle((pose.x, pose.y), radius, fill=False, color=READING_COLOUR, lw=1.5))
    nose = pose.apply(np.array([[radius, 0.0]]))[0]
    axis.plot([pose.x, nose[0]], [pose.y, nose[1]], color=READING_COLOUR, lw=1.5)


def _scan(readings: Readings, row: int, pose: Pose2) -> FloatArray:
    reach, angle = readings["ranges_m"][row].astype(np.float64), readings["angles_rad"]
    hit = np.isfinite(reach)
    points = reach[hit, None] * np.column_stack([np.cos(angle[hit]), np.sin(angle[hit])])
    return pose.compose(Pose2(*readings["base_T_sensor"])).apply(points)


def _draw_decided(axis: Any, decided: dict[str, Any]) -> None:
    """Draw the measured value and the limit that decided."""
    value, limit = decided.get("value"), decided.get("limit")
    if value is None or limit is None or not math.isfinite(value):
        axis.set_axis_off()
        return
    axis.barh(0.0, value, height=0.6, color=READING_COLOUR)
    axis.axvline(limit, color=LIMIT_COLOUR, lw=2.0)
    axis.margins(x=0.1)
    axis.set_yticks([])
    axis.tick_params(labelsize=7)
    axis.set_title(plain(f"{measured_words(decided)} (the line)"), fontsize=8, loc="left", fontweight="bold")
    for side in ("top", "left", "right"):
        axis.spines[side].set_visible(False)


# Readings and commands over time


def _draw_panel(
    axis: Any, panel: _Panel, readings: Readings, explanation: Explanation, decided: dict[str, Any]
) -> None:
    panel.draw(axis, _with_gaps(readings))
    decides = panel.sensor == decided.get("sensor")
    axis.set_title(panel.title, fontsize=8, loc="left", fontweight="bold" if decides else "normal", pad=2)
    axis.tick_params(labelsize=7)
    axis.margins(x=0.0)
    times, restoring = readings["time_s"], readings["restoring"]
    axis.fill_between(
        times,
        0,
        1,
        where=restoring,
        transform=axis.get_xaxis_transform(),
        color=RESTORED_COLOUR,
        lw=0,
        zorder=0,
    )
    if explanation.action is not None and explanation.action.broken_off is not None:
        axis.axvline(explanation.action.broken_off, color=LIMIT_COLOUR, lw=1.0)
    if decides and decided.get("unit") == panel.unit and decided.get("limit") is not None:
        axis.axhline(decided["limit"], color=LIMIT_COLOUR, lw=0.8, ls=":")


def _with_gaps(readings: Readings) -> Readings:
    """Return readings with a row of NaN at each gap in time, so that no line is drawn across the gap."""
    times = readings["time_s"]
    period = float(np.median(np.diff(times))) if len(times) > 1 else 1.0
    gaps = np.flatnonzero(np.diff(times) > 1.5 * period) + 1
    columns = {}
    for name, column in readings.items():
        if (
            column.ndim
            and len(column) == len(times)
            and name not in ("angles_rad", "base_T_sensor", "joint_slides")
        ):
            columns[name] = np.insert(column.astype(np.float64), gaps, np.nan, axis=0)
    columns["time_s"][np.isnan(columns["time_s"])] = times[gaps]
    return {**readings, **columns}


def _key(axis: Any) -> None:
    """Add the legend in the line of the title, where it covers no curve."""
    above = {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0), "borderaxespad": 0.0}
    add_legend(axis, fontsize=6, ncols=12, frameon=False, handlelength=1.2, **above)


def _speed(axis: Any, readings: Readings) -> None:
    times = readings["time_s"]
    travel = (readings["wheel_left_m"] + readings["wheel_right_m"]) / 2
    axis.step(times, readings["speed_command_m_s"], color=COMMAND_COLOUR, lw=2.5, where="pre")
    if len(times) > 1:
        passed = np.where(np.diff(times) > 0.0, np.diff(times), np.nan)
        axis.plot(times[1:], np.diff(travel) / passed, color=READING_COLOUR, lw=1.0)


def _turn(axis: Any, readings: Readings) -> None:
    times = readings["time_s"]
    axis.step(times, np.degrees(readings["turn_command_rad_s"]), color=COMMAND_COLOUR, lw=2.5, where="pre")
    if len(times) > 1:
        passed = np.where(np.diff(times) > 0.0, np.diff(times), np.nan)
        turned = (np.diff(readings["heading_rad"]) + np.pi) % (2 * np.pi) - np.pi
        axis.plot(times[1:], np.degrees(turned / passed), color=READING_COLOUR, lw=1.0)


def _nearest(axis: Any, readings: Readings) -> None:
    ranges = readings["ranges_m"]
    angles = readings["angles_rad"] + readings["base_T_sensor"][2]
    ahead = np.abs((angles + np.pi) % (2 * np.pi) - np.pi) <= AHEAD_ANGLE_RAD
    least = np.min(ranges, axis=1, where=np.isfinite(ranges), initial=np.inf)
    front = np.min(ranges[:, ahead], axis=1, where=np.isfinite(ranges[:, ahead]), initial=np.inf)
    for line, style, label in ((least, "-", "nearest"), (front, "--", "nearest ahead")):
        shown = np.where(np.isfinite(line), line, np.nan)
        axis.plot(readings["time_s"], shown, style, color=READING_COLOUR, lw=1.0, label=label)
    _key(axis)


def _explained(axis: Any, readings: Readings) -> None:
    axis.plot(readings["time_s"], readings["scan_explained"], color=READING_COLOUR, lw=1.0)
    axis.set_ylim(0.0, 1.05)


def _joints(axis: Any, readings: Readings) -> None:
    angles = readings["joints_rad"]
    slides = readings.get("joint_slides", np.zeros(angles.shape[1], dtype=bool))
    scale = np.where(slides, 1e3, np.degrees(1.0))
    axis.plot(readings["time_s"], scale * readings["joints_command_rad"], color=COMMAND_COLOUR, lw=2.5)
    for number, joint in enumerate((scale * angles).T):
        turn, place = divmod(number, len(SERIES_COLOURS))
        style = ("-", "--", ":")[turn % 3]
        name = f"{number + 1}{' [mm]' if slides[number] else ''}"
        axis.plot(readings["time_s"], joint, style, color=SERIES_COLOURS[place], lw=1.0, label=name)
    _key(axis)


def _force(axis: Any, readings: Readings) -> None:
    for name, colour, column in zip("xyz", SERIES_COLOURS, readings["hand_force_n"].T, strict=False):
        axis.plot(readings["time_s"], column, color=colour, lw=1.0, label=name)
    _key(axis)


def _grip(axis: Any, readings: Readings) -> None:
    axis.step(readings["time_s"], 1e3 * readings["grip_command_m"], color=COMMAND_COLOUR, lw=2.5, where="pre")
    axis.plot(readings["time_s"], 1e3 * readings["grip_width_m"], color=READING_COLOUR, lw=1.0)


_PANELS: Sequence[_Panel] = (
    _Panel("Base: speed [m/s]", "Base", "m/s", "speed_command_m_s", _speed),
    _Panel("Base: turn rate [deg/s]", "Base", "deg/s", "turn_command_rad_s", _turn),
    _Panel("RangeSensor: nearest [m]", "RangeSensor", "", "ranges_m", _nearest),
    _Panel("RangeSensor: share of the scan that the map explains", "RangeSensor", "", "ranges_m", _explained),
    _Panel("Arm: joints [deg]", "Arm", "deg", "joints_rad", _joints),
    _Panel("Arm: force on the hand, in its frame [N]", "Arm", "N", "hand_force_n", _force),
    _Panel("Gripper: opening [mm]", "Gripper", "mm", "grip_width_m", _grip),
)
