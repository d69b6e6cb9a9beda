"""Voronoi graphs, routes, scan matching and docking, measured: `python -m benchmarks.driving.navigation`.

Seeded; times are medians of warm calls. `--maps` names a folder with `turtlebot3/map.pgm` and
`depot/depot.pgm`; without it only the generated office is measured. `--quick` leaves out the 4000 x 4000 map.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import cv2
import numpy as np
from scipy import ndimage
from skimage.graph import MCP_Geometric
from skimage.morphology import skeletonize

from benchmarks.driving.worlds.box_ranges import box_ranges
from benchmarks.driving.worlds.office_map import office_boxes, office_map
from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.navigation.maps.grid_map import GridMap, from_boxes, from_ros
from handcart.robotics.navigation.odometry.odometry import Odometry, OdometryErrors
from handcart.robotics.navigation.routes.route import plan_route
from handcart.robotics.navigation.routes.shortest_path import shortest_path
from handcart.robotics.navigation.routes.voronoi_graph import VoronoiGraph, voronoi_graph
from handcart.robotics.navigation.scans.front_line import fit_front
from handcart.robotics.navigation.scans.scan_matching import LikelihoodField, match_scan
from handcart.robotics.numerics.arrays import BoolArray, FloatArray, IntArray

BEAM_ANGLES = np.linspace(-np.pi, np.pi, 360, endpoint=False)
COLD_START_CODE = (
    "import time; t = time.perf_counter(); from benchmarks.driving.worlds.office_map import office_map; "
    "from handcart.robotics.navigation.routes.route import plan_route; "
    "from handcart.robotics.navigation.routes.voronoi_graph import voronoi_graph; "
    "m = office_map(0, 400, 300); t = time.perf_counter(); "
    "plan_route(voronoi_graph(m, 0.25), (1.0, 1.0), (18.0, 14.0)); "
    "print(time.perf_counter() - t)"
)


class Row(NamedTuple):
    """A line of the table."""

    what: str
    ours: str
    beside: str = ""
    wanted: str = ""


def median_ms(call: Callable[[], Any], times: int) -> float:
    """Median wall time of a call after one to warm up, in [ms]."""
    call()
    taken = []
    for _ in range(times):
        begin = time.perf_counter()
        call()
        taken.append(time.perf_counter() - begin)
    return 1e3 * float(np.median(taken))


def free_pairs(graph: VoronoiGraph, count: int, seed: int) -> IntArray:
    """Return starts and goals (count, 2, 2): random free cells at least 2 m apart."""
    rng, cells = np.random.default_rng(seed), np.argwhere(graph.free)
    pairs: list[IntArray] = []
    while len(pairs) < count:
        pair = cells[rng.integers(len(cells), size=2)]
        if np.hypot(*(pair[0] - pair[1])) * graph.map.resolution > 2.0:
            pairs.append(pair)
    return np.array(pairs)


def topology(free: BoolArray) -> tuple[int, int]:
    """Components and holes by scipy's labels, 8-connected free cells against 4-connected others."""
    padded = np.pad(free, 1)
    return ndimage.label(padded, np.ones((3, 3)))[1], ndimage.label(~padded)[1] - 1


def length_and_room(graph: VoronoiGraph, path: FloatArray) -> tuple[float, float]:
    """Length in [m] and mean clearance in [m] of a path (n, 2) in [cells]."""
    steps = np.hypot(*np.diff(path, axis=0).T)
    along = np.concatenate([[0.0], np.cumsum(steps)])
    at = np.linspace(0.0, along[-1], int(along[-1]) + 2)
    cells = np.column_stack([np.interp(at, along, path[:, i]) + 0.5 for i in (0, 1)]).astype(np.int64)
    return float(along[-1]) * graph.map.resolution, float(graph.clearance[cells[:, 0], cells[:, 1]].mean())


def ideal_path(graph: VoronoiGraph, pair: IntArray) -> FloatArray:
    """Return the path of least 1 / clearance on the grid, as found by a search that isn't bound to a
    graph.
    """
    price = np.where(graph.free, 1.0 / np.maximum(graph.clearance, 1e-3), -1.0)
    search = MCP_Geometric(price)
    search.find_costs([tuple(pair[0])], [tuple(pair[1])])
    path = np.array(search.traceback(tuple(pair[1])), dtype=np.float64)
    for _ in range(50):  # the staircase of an 8-connected path isn't length that one would drive
        path[1:-1] = 0.5 * path[1:-1] + 0.25 * (path[:-2] + path[2:])
    return path


def route_rows(name: str, grid: GridMap, radius: float) -> list[Row]:
    """Topology, route quality and times on one map."""
    graph = voronoi_graph(grid, radius)
    pairs = free_pairs(graph, 100, 1)
    ends = [[tuple(p) for p in grid.to_point(pair).tolist()] for pair in pairs]
    ours, ideal = [], []
    for pair, (start, goal) in zip(pairs, ends, strict=True):
        corners = shortest_path(graph.free, pair[0], pair[1])
        route = plan_route(graph, start, goal)
        assert corners is not None and route is not None
        shortest = np.array(length_and_room(graph, corners.astype(np.float64)))
        ours.append(np.array([route.length, route.mean_clearance]) / shortest)
        ideal.append(np.array(length_and_room(graph, ideal_path(graph, pair))) / shortest)
    expected = topology(graph.free)
    build = median_ms(lambda: voronoi_graph(grid, radius), 7)
    other = median_ms(lambda: skeletonize(graph.free), 3)  # type: ignore[no-untyped-call]
    query = [median_ms(partial(plan_route, graph, start, goal), 1) for start, goal in ends]
    theta = [median_ms(partial(shortest_path, graph.free, *p), 1) for p in pairs[:20]]
    shape = f"{name} {grid.occupied.shape[1]}x{grid.occupied.shape[0]}, r {radius} m"
    a, b = np.mean(ours, axis=0), np.mean(ideal, axis=0)
    return [
        Row(
            f"{shape}: components, cycles",
            f"{graph.components}, {graph.cycles}",
            f"labels {expected}",
            "equal",
        ),
        Row(
            "  length / any-angle shortest",
            f"{a[0]:.3f}",
            f"cheapest of all by 1/clearance {b[0]:.3f}",
            "<= 1.15",
        ),
        Row("  mean clearance / that of the shortest", f"{a[1]:.2f}", f"of that one {b[1]:.2f}", ">= 1.6"),
        Row(
            "  graph, ms",
            f"{build:.1f}",
            f"skimage thinning alone {other:.1f} (x {other / build:.1f})",
            "15, must 60",
        ),
        Row(
            "  query, ms, median / slowest",
            f"{np.median(query):.2f} / {max(query):.2f}",
            f"Theta* {np.median(theta):.1f} (x {np.median(theta) / np.median(query):.0f})",
            "2",
        ),
    ]


def large_rows() -> list[Row]:
    """Print times on 4000 x 4000 cells."""
    grid = office_map(0, 4000, 4000)
    graph = voronoi_graph(grid, 0.25)
    build = median_ms(lambda: voronoi_graph(grid, 0.25), 2) / 1e3
    ends = [[tuple(p) for p in grid.to_point(pair).tolist()] for pair in free_pairs(graph, 30, 1)]
    query = [median_ms(partial(plan_route, graph, start, goal), 1) for start, goal in ends]
    equal = (graph.components, graph.cycles) == topology(graph.free)
    return [
        Row(
            "office 4000x4000: components, cycles",
            f"{graph.components}, {graph.cycles}",
            f"labels {'equal' if equal else 'DIFFER'}",
        ),
        Row("  graph, s", f"{build:.2f}", "", "2, must 6"),
        Row("  query, ms, median / slowest", f"{np.median(query):.1f} / {max(query):.1f}", "", "10, must 50"),
    ]


def cold_row() -> Row:
    """First graph and route of a process that finds no compiled code on disk."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-c", COLD_START_CODE]
        environment = {**os.environ, "NUMBA_CACHE_DIR": folder}
        cold, kept = (
            float(subprocess.run(command, env=environment, check=True, capture_output=True, text=True).stdout)
            for _ in range(2)
        )
    return Row("first graph and route ever, s", f"{cold:.1f}", f"in the next process {kept:.2f}")


def scan_points(boxes: Any, pose: Pose2, rng: np.random.Generator) -> FloatArray:
    """Return a scan with 1 cm of noise, end points (n, 2) in the base frame."""
    seen = box_ranges(boxes, pose, BEAM_ANGLES)
    seen = seen + rng.normal(0.0, 0.01, len(seen))
    hit = seen < 12.0
    points: FloatArray = seen[hit, None] * np.column_stack(
        [np.cos(BEAM_ANGLES[hit]), np.sin(BEAM_ANGLES[hit])]
    )
    return points


def scan_rows(strangers: int, aligned: bool) -> list[Row]:
    """Scan matching on a 5 cm grid, 200 poses, with boxes that the map doesn't show.

    Aligned, all walls lie on the edges of cells, half a cell from where they are read: the worst case.
    """
    size = (20.03, 15.02)
    rng = np.random.default_rng(2)
    boxes = office_boxes(0, size)
    if not aligned:
        boxes = [
            (x + dx, y + dy, *rest)
            for (x, y, *rest), (dx, dy) in zip(
                boxes, rng.uniform(-0.025, 0.025, (len(boxes), 2)), strict=True
            )
        ]
    field = LikelihoodField(from_boxes(boxes, 0.05, (0.0, 0.0), size))
    graph = voronoi_graph(field.map, 0.34)
    cells = np.argwhere(graph.free)
    errors, squares, times = [], [], []
    for cell in cells[rng.integers(len(cells), size=200)]:
        x, y = field.map.to_point(cell[None])[0] + rng.uniform(-0.025, 0.025, 2)
        truth = Pose2(float(x), float(y), float(rng.uniform(-3.0, 3.0)))
        unknown = [
            (*rng.uniform((0, 0), size), rng.uniform(0, 3), *rng.uniform(0.2, 0.6, 2))
            for _ in range(strangers)
        ]
        unknown = [box for box in unknown if np.hypot(box[0] - truth.x, box[1] - truth.y) > 0.8]
        points = scan_points([*boxes, *unknown], truth, rng)
        spread = np.array([0.05, 0.05, 0.03])
        off = rng.normal(0.0, 1.0, 3) * spread
        start = Pose2(truth.x + off[0], truth.y + off[1], wrap(truth.theta + off[2]))
        begin = time.perf_counter()
        match = match_scan(field, points, start, np.diag(spread**2))
        times.append(time.perf_counter() - begin)
        error = np.array(
            [match.pose.x - truth.x, match.pose.y - truth.y, wrap(match.pose.theta - truth.theta)]
        )
        errors.append(error)
        squares.append(error @ np.linalg.solve(match.covariance, error))
    where = "on cell edges" if aligned else "anywhere"
    away, turned = np.hypot(*np.array(errors)[:, :2].T), np.degrees(np.abs(np.array(errors)[:, 2]))
    return [
        Row(
            f"scan to map, walls {where}, {strangers} unknown boxes: mm, mean / 95 %",
            f"{1e3 * away.mean():.1f} / {1e3 * np.quantile(away, 0.95):.1f}",
            "start 63 mm off",
            "15, must 30",
        ),
        Row("  degrees, mean", f"{turned.mean():.3f}", "start 1.4", "0.2, must 0.5"),
        Row("  squared error by its covariance", f"{np.mean(squares):.2f}", "honest: 3; less is cautious"),
        Row("  ms", f"{1e3 * np.median(times):.2f}", "", "1"),
    ]


def front_row(scans: int) -> Row:
    """Docking on a front of 1 m, 0.6 m away."""
    rng = np.random.default_rng(3)
    shelf = [(0.0, 0.15, 0.0, 1.0, 0.3)]
    ends = np.array([[-0.5, 0.0], [0.5, 0.0]])
    distance, angle = [], []
    for _ in range(100):
        truth = Pose2(float(rng.uniform(-0.1, 0.1)), -0.6, float(np.pi / 2 + rng.uniform(-0.1, 0.1)))
        points = np.vstack([scan_points(shelf, truth, rng) for _ in range(scans)])
        front = fit_front(points, truth.inverse().apply(ends))
        assert front is not None
        distance.append(abs(front.distance - 0.6))
        angle.append(abs(wrap(front.angle + truth.theta - np.pi / 2)))
    ours = f"{1e3 * np.mean(distance):.2f} mm, {np.degrees(np.mean(angle)):.3f} deg"
    return Row(f"shelf's front, {scans} scans stacked", ours, "", "2 mm, 0.2 deg")


def odometry_row() -> Row:
    """Wheels alone over 17 m, 100 drives."""
    rng = np.random.default_rng(4)
    exact, away = OdometryErrors(0.0, 0.0, 0.0), []
    turns = 0.03 * np.sin(np.linspace(0.0, 12.0, 680))
    for _ in range(100):
        scale, tread = 1.0 + rng.normal(0.0, 0.002, 2), 0.46 * (1.0 + rng.normal(0.0, 0.005))
        truth, ours = Odometry(Pose2(0, 0, 0), tread, exact), Odometry(Pose2(0, 0, 0), 0.46)
        for turn in turns:
            step = np.array([0.025 - turn * 0.23, 0.025 + turn * 0.23])
            truth.predict(*(step * scale * (1.0 + rng.normal(0.0, 0.01, 2))))
            ours.predict(*step)
        away.append(truth.pose.distance(ours.pose))
    return Row("wheels alone, 17 m: mm, mean / worst", f"{1e3 * np.mean(away):.0f} / {1e3 * max(away):.0f}")


def real_maps(folder: Path | None) -> list[tuple[str, GridMap, float]]:
    """Return the maps that are in a folder, with a robot's radius for each; none without a folder."""
    found = list[tuple[str, GridMap, float]]()
    if folder is None:
        return found
    for name, path, origin, thresh, radius in (
        ("turtlebot3", "turtlebot3/map.pgm", -10.0, 0.196, 0.105),
        ("turtlebot3", "turtlebot3/map.pgm", -10.0, 0.196, 0.22),
        ("depot", "depot/depot.pgm", 0.0, 0.25, 0.25),
    ):
        image = cv2.imread(str(folder / path), cv2.IMREAD_UNCHANGED)
        if image is not None:
            found.append(
                (name, from_ros(np.asarray(image, np.uint8), 0.05, (origin, origin), 0.65, thresh), radius)
            )
    return found


def main() -> None:
    """Measure and print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--maps", type=Path, help="folder with maps of real buildings (default: none)")
    parser.add_argument("--quick", action="store_true")
    options = parser.parse_args()
    if options.maps is None:
        print("maps of real buildings are skipped: no --maps FOLDER", file=sys.stderr, flush=True)
    maps = [("office", office_map(0, 400, 300), 0.25), *real_maps(options.maps)]
    parts: list[tuple[str, Callable[[], list[Row]]]] = [("cold start", lambda: [cold_row()])]
    parts += [(f"{name}, {radius} m", partial(route_rows, name, grid, radius)) for name, grid, radius in maps]
    parts += [] if options.quick else [("4000 x 4000", large_rows)]
    for strangers, aligned in ((0, False), (12, False), (12, True)):
        parts.append((f"scan matching, {strangers} boxes", partial(scan_rows, strangers, aligned)))
    parts += [
        ("docking", lambda: [front_row(k) for k in (1, 10, 30)]),
        ("odometry", lambda: [odometry_row()]),
    ]
    rows = [Row("what", "ours", "beside", "aim")]
    for i, (name, part) in enumerate(parts):
        print(f"[{i + 1}/{len(parts)}] {name}", file=sys.stderr, flush=True)
        rows += part()
    widths = [max(len(row[k]) for row in rows) for k in range(4)]
    for row in rows:
        print("  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)).rstrip())


if __name__ == "__main__":
    main()
