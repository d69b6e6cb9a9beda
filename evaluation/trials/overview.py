"""Overview picture of a run, `overview.svg`, drawn from the run's folder and the robot's knowledge."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from handcart.evaluation.viewing.drawing.figure_file import save_figure
from handcart.evaluation.viewing.drawing.legend import add_legend
from handcart.evaluation.viewing.drawing.palette import (
    BLACK,
    BLUE,
    GREEN,
    ORANGE,
    OUTCOME_COLOURS,
    PURPLE,
    SKY,
    VERMILION,
)
from handcart.evaluation.viewing.drawing.place_arrows import draw_places
from handcart.evaluation.viewing.drawing.plain_text import plain
from handcart.evaluation.viewing.drawing.track_lines import track_lines
from handcart.networks.journal.journal_record import read_journal
from handcart.networks.run_files.run_names import OVERVIEW_FILE
from handcart.networks.run_files.telemetry import RunTrack, load_track
from handcart.networks.runs.evidence_files import EVIDENCE_FOLDER, evidence_order
from handcart.networks.runs.flight_recorder import READINGS_SUFFIX
from handcart.primitives.knowledge.place import Place
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.navigation.routes.voronoi_graph import voronoi_graph
from handcart.robotics.numerics.arrays import ByteArray, FloatArray

PLANNED_COLOUR, DRIVEN_COLOUR, RESTORED_COLOUR, SENSED_COLOUR, GRAPH_COLOUR = (
    BLUE,
    BLACK,
    ORANGE,
    VERMILION,
    SKY,
)
BUMPED_COLOUR = PURPLE
SCAN_COLOUR = GREEN
TIME_LINE_LETTERS = 125.0  # letters of the widest kind that fit on the time line
MAP_MARGIN_M = 0.5  # around the known part of a map
# smallest height over width of the drawn map, so that a straight course shows its surroundings
MIN_MAP_ASPECT = 0.08
PICTURE_WIDTH_IN = 12.0
FOOTER_HEIGHT_IN = 1.6  # legend and time line
MAP_HEIGHTS_IN = (1.5, 5.6)  # lower and upper limit
MIN_HEIGHT_BESIDE_IN = 3.5  # of a map next to a picture
MAPS_SHARE = 0.57  # of the width, next to a picture


@dataclass(frozen=True)
class ActionStretch:
    """Action on the time line of a run's overview, with begin, end and outcome."""

    number: int
    do: str
    start: float
    """Start time of the action, in [s]."""
    end: float
    outcome: str


def draw_overview(
    run_dir: Path,
    grid: GridMap,
    places: Mapping[str, Place],
    radius: float,
    shown: Collection[str] = (),
) -> Path:
    """Draw the overview of a run that has ended: map with the driven path, last picture, and time line.

    Args:
        run_dir: the run's folder.
        grid: the robot's map.
        places: places on the map, by name.
        radius: radius of the robot's footprint, in [m].
        shown: primitives; the last picture of one of them is drawn, if any exists.

    Returns:
        The path of the picture.
    """
    from matplotlib.figure import Figure

    track, (title, stretches) = load_track(run_dir / "telemetry.npz"), _course(run_dir)
    picture = _last_picture(run_dir, shown)
    window = _window(grid, track, radius)
    tall = _tall(window, picture is not None)
    figure = Figure(figsize=(PICTURE_WIDTH_IN, tall + FOOTER_HEIGHT_IN), layout="constrained")
    axes = figure.subplot_mosaic(
        [["map", "picture"], ["key", "key"], ["time", "time"]]
        if picture is not None
        else [["map"], ["key"], ["time"]],
        height_ratios=[tall, 0.2 * FOOTER_HEIGHT_IN, 0.8 * FOOTER_HEIGHT_IN],
        width_ratios=[1.35, 1.0] if picture is not None else [1.0],
    )
    figure.suptitle(plain(title), fontsize=11)
    _draw_map(axes["map"], grid, radius)
    axes["map"].set_xlim(*window[0])
    axes["map"].set_ylim(*window[1])
    _draw_drive(axes["map"], run_dir, track)
    _draw_robot(axes["map"], track, radius)
    _draw_time(axes["time"], stretches)
    axes["key"].set_axis_off()
    handles, labels = axes["map"].get_legend_handles_labels()
    axes["key"].legend(handles, labels, loc="center", fontsize=8, ncols=8, frameon=False)
    if picture is not None:
        name, pixels = picture
        axes["picture"].imshow(pixels)
        axes["picture"].set_title(plain(f"what was seen: {' '.join(name.split('_'))}"), fontsize=9)
        axes["picture"].set_axis_off()
    figure.draw_without_rendering()  # fixes the layout, on which the free space for names depends
    _draw_places(axes["map"], places)
    path = run_dir / OVERVIEW_FILE
    save_figure(figure, path)
    for stretch in stretches:
        if stretch.outcome != "Success":
            _draw_fail(run_dir, stretch, grid, track, radius)
    return path


def _course(run_dir: Path) -> tuple[str, list[ActionStretch]]:
    """Return the title, with the end of the run, and the actions; both read from the journal."""
    title = f"{run_dir.name}: no end is known"
    started: dict[int, tuple[str, float]] = {}
    ended: dict[int, tuple[str, float]] = {}
    last = 0.0
    for record in read_journal(run_dir / "journal.jsonl").records:
        last = float(record["t"])
        if record["kind"] == "START":
            started[record["n"]] = (record["action"]["do"], last)
        elif record["kind"] == "RESULT":
            ended[record["n"]] = (record["outcome"], last)
        elif record["kind"] == "END":
            title = f"{run_dir.name}: {record['outcome']} after {last:.1f} s"
    return title, [
        ActionStretch(number, do, start, ended.get(number, ("", last))[1], ended.get(number, ("", last))[0])
        for number, (do, start) in started.items()
    ]


def _draw_map(axis: Any, grid: GridMap, radius: float) -> None:
    height, width = grid.occupied.shape
    x0, y0, cell = grid.origin_x, grid.origin_y, grid.resolution
    shade = np.where(grid.occupied, 60, np.where(grid.unknown, 215, 255)).astype(np.uint8)
    extent = (x0, x0 + width * cell, y0, y0 + height * cell)
    axis.imshow(shade, cmap="gray", vmin=0, vmax=255, origin="lower", extent=extent, interpolation="nearest")
    try:
        graph = voronoi_graph(grid, radius).graph
    except ValueError:
        graph = None
    for number, (_, _, line) in enumerate(graph.edges(data="points") if graph is not None else ()):
        axis.plot(
            line[:, 0], line[:, 1], color=GRAPH_COLOUR, lw=1.0, label=None if number else "Voronoi graph"
        )
    axis.set_aspect("equal")
    axis.set_xlabel("x [m]")
    axis.set_ylabel("y [m]")


def _window(grid: GridMap, track: RunTrack, radius: float) -> FloatArray:
    """Return the limits of the drawn area, [[x_min, x_max], [y_min, y_max]] in [m].

    The area is the known part of the map; on a map without a known part, the driven path.
    """
    known = np.argwhere(~grid.unknown)
    if len(known):
        size = grid.resolution * np.array(grid.occupied.shape[::-1])
        start = np.array([grid.origin_x, grid.origin_y])
        low = np.maximum(start, grid.to_point(known.min(axis=0)[None])[0] - MAP_MARGIN_M)
        high = np.minimum(start + size, grid.to_point(known.max(axis=0)[None])[0] + MAP_MARGIN_M)
    else:
        ways = track.pose[np.isfinite(track.pose[:, 0]), :2]
        ways = ways if len(ways) else np.zeros((1, 2))
        low, high = ways.min(axis=0) - radius - MAP_MARGIN_M, ways.max(axis=0) + radius + MAP_MARGIN_M
    more = np.array([0.0, max(0.0, MIN_MAP_ASPECT * (high[0] - low[0]) - (high[1] - low[1])) / 2])
    return np.column_stack([low - more, high + more])


def _tall(window: FloatArray, beside: bool) -> float:
    """Return the height of the map in [in], by the shape of the drawn area.

    Args:
        window: limits of the area, [[x_min, x_max], [y_min, y_max]] in [m].
        beside: True if a picture is drawn next to it.
    """
    across, along = window[:, 1] - window[:, 0]
    needed = PICTURE_WIDTH_IN * (MAPS_SHARE if beside else 1.0) * along / across
    return float(np.clip(needed, MIN_HEIGHT_BESIDE_IN if beside else MAP_HEIGHTS_IN[0], MAP_HEIGHTS_IN[1]))


def _draw_places(axis: Any, places: Mapping[str, Place]) -> None:
    """Draw the places inside the drawn area."""
    (left, right), (low, high) = axis.get_xlim(), axis.get_ylim()
    poses = {
        name: (place.x_m, place.y_m, place.pose.theta)
        for name, place in places.items()
        if left <= place.x_m <= right and low <= place.y_m <= high
    }
    draw_places(axis, poses)


def _draw_robot(axis: Any, track: RunTrack, radius: float) -> None:
    """Draw the robot's footprint and heading at the start and at the end of the run."""
    if len(track.pose):
        _draw_footprint(axis, track.pose[0], radius, ":", "robot at the start")
        _draw_footprint(axis, track.pose[-1], radius, "-", "robot at the end")


def _draw_footprint(axis: Any, pose: FloatArray | None, radius: float, style: str, label: str) -> None:
    from matplotlib.patches import Circle

    if pose is None or not np.isfinite(pose).all():  # not recorded, or the robot did not know
        return
    x, y, heading = pose
    axis.add_patch(Circle((x, y), radius, fill=False, color=DRIVEN_COLOUR, ls=style, lw=1.2, label=label))
    nose = x + radius * np.cos(heading), y + radius * np.sin(heading)
    axis.plot([x, nose[0]], [y, nose[1]], color=DRIVEN_COLOUR, ls=style, lw=1.2)


def _pose_at_the_end(track: RunTrack, stretch: ActionStretch) -> FloatArray | None:
    """Return the robot's pose (3,) at the end of an action's own motion, before restoring; None if not
    recorded.
    """
    rows = np.flatnonzero(track.action == stretch.number)
    restored = np.flatnonzero(track.restoring[rows])
    own = rows[: restored[0]] if len(restored) else rows
    return track.pose[own[-1]] if len(own) else None


def _draw_drive(axis: Any, run_dir: Path, track: RunTrack) -> None:
    for number, line in enumerate(_named(run_dir, "planned")):
        label = None if number else "planned"
        axis.plot(line[:, 0], line[:, 1], color=PLANNED_COLOUR, lw=1.0, ls="--", label=label, zorder=3)
    if len(track.pose):
        axis.plot(track.pose[:, 0], track.pose[:, 1], color=DRIVEN_COLOUR, lw=1.5, label="driven")
        back = np.where(track.restoring[:, None], track.pose[:, :2], np.nan)
        if track.restoring.any():
            axis.plot(back[:, 0], back[:, 1], color=RESTORED_COLOUR, lw=1.5, label="restored")
    scans, sensed = _named(run_dir, "scan"), _named(run_dir, "sensed")
    if scans:
        axis.plot(
            *np.vstack(scans).T, ".", color=SCAN_COLOUR, ms=1.5, label="scan on arrival", rasterized=True
        )
    if sensed:
        axis.plot(*np.vstack(sensed).T, ".", color=SENSED_COLOUR, ms=2.5, label="sensed, not on the map")
    people = [rows for rows in _named(run_dir, "people") if len(rows)]
    for number, line in enumerate(track_lines(np.vstack(people)) if people else ()):
        label = None if number else "people in the way, and their next second"
        axis.plot(*line.T, color=BUMPED_COLOUR, lw=1.2, label=label, zorder=4)
    for number, front in enumerate(_named(run_dir, "bumped")):
        axis.plot(
            *front.T, color=BUMPED_COLOUR, lw=3.0, label=None if number else "ran into something", zorder=4
        )


def _draw_time(axis: Any, stretches: list[ActionStretch]) -> None:
    span = max((stretch.end for stretch in stretches), default=0.0)
    for stretch in stretches:
        lasted = stretch.end - stretch.start
        axis.barh(0, lasted, left=stretch.start, color=OUTCOME_COLOURS[stretch.outcome], edgecolor="white")
        label = _fitting(stretch, TIME_LINE_LETTERS * lasted / span if span else 0.0)
        middle = 0.5 * (stretch.start + stretch.end)
        axis.text(middle, 0.0, label, ha="center", va="center", fontsize=7, color="white")
    axis.set_yticks([])
    axis.set_ylim(-0.5, 0.5)
    axis.set_xlim(0.0, span or 1.0)
    axis.set_xlabel("time [s]; blue: Success, orange: Fail and restored, black: GiveUp, grey: no end")
    for side in ("top", "left", "right"):
        axis.spines[side].set_visible(False)


def _fitting(each: ActionStretch, letters: float) -> str:
    """Return the longest label with at most `letters` characters: number and name, number, or empty."""
    labels = (f"{each.number} {each.do}", str(each.number))
    return next((label for label in labels if len(label) + 1 <= letters), "")


def _draw_fail(run_dir: Path, stretch: ActionStretch, grid: GridMap, track: RunTrack, radius: float) -> None:
    """Draw the scan that decided a Fail of driving, around the obstacle, with the robot at that instant."""
    name = f"{stretch.number:03d}_{stretch.do}_{stretch.outcome}"
    points = _points(run_dir).get(name, {})
    if "in the way" not in points:
        return
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5.0, 5.0), layout="constrained")
    axis = figure.subplots()
    _draw_map(axis, grid, 1e3)
    axis.plot(*points["sensed"].T, ".", color=SENSED_COLOUR, label="sensed, not on the map")
    axis.plot(*points["ahead"].T, color=PLANNED_COLOUR, ls="--", label="the way ahead")
    x, y = points["in the way"][0]
    _draw_footprint(axis, _pose_at_the_end(track, stretch), radius, "-", "robot when it decided")
    axis.plot(x, y, "x", color="black", ms=12, mew=2, label="in the way")
    axis.set_xlim(x - 2.0, x + 2.0)
    axis.set_ylim(y - 2.0, y + 2.0)
    add_legend(axis, fontsize=8)
    save_figure(figure, run_dir / EVIDENCE_FOLDER / f"{name}.svg")


def _named(run_dir: Path, name: str) -> list[FloatArray]:
    """Return the points (n, 2) on the map, in [m], with this name from the evidence of each action, in order
    of the actions.
    """
    return [points[name] for points in _points(run_dir).values() if name in points]


def _points(run_dir: Path) -> dict[str, dict[str, FloatArray]]:
    found = {}
    for path in sorted((run_dir / EVIDENCE_FOLDER).glob("*.npz"), key=lambda path: evidence_order(path.name)):
        if path.name.endswith(READINGS_SUFFIX):
            continue
        with np.load(path) as arrays:
            found[path.stem] = dict(arrays)
    return found


def _last_picture(run_dir: Path, shown: Collection[str]) -> tuple[str, ByteArray] | None:
    """Return name and pixels (RGB, reduced) of the last picture, preferably by one of the primitives
    `shown`.
    """
    every = sorted((run_dir / EVIDENCE_FOLDER).glob("*.png"), key=lambda path: evidence_order(path.name))
    paths = [path for path in every if any(f"_{name}" in path.name for name in shown)] or every
    if not paths:
        return None
    pixels = cv2.imread(str(paths[-1]))
    if pixels is None:
        return None
    half = cv2.resize(pixels, None, fx=0.6, fy=0.6, interpolation=cv2.INTER_AREA)
    return paths[-1].stem, cv2.cvtColor(half, cv2.COLOR_BGR2RGB).astype(np.uint8)
