"""Measure routes independently: python -m benchmarks.driving.routes [--samples N] [--pairs N] [--maps DIR]

First, whether any point of a route is nearer to a blocked cell's square than the route states: on random
grids (speckle, rooms behind walls one cell thick, diagonal walls, boxes at any angle) with cells from an
eighth of the robot's radius to much larger than the robot, starts and goals at cell centres and anywhere
in cells. Distances are computed anew, by scipy's k-d tree. Where no route is found, there must be none, by
labels of an image that has pixels between the cells as well.

Second, the length of routes on an office, on real maps (skipped if missing), on these reduced to cells of
0.2 m, and on generated streets and rooms with cells of 1 m. Their length is divided by that of the
shortest 8-connected path (skimage's MCP_Geometric) on the cells that are free for the robot's radius; and
by that of an any-angle path (Theta*, pulled tight) that keeps the radius everywhere. The first is up to 8
% longer than necessary, but may cut corners.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy import ndimage
from skimage.graph import MCP_Geometric

from benchmarks.driving.navigation import length_and_room, real_maps
from benchmarks.driving.worlds.office_map import office_map
from benchmarks.driving.worlds.random_grids import distance_to_squares, random_grid, rooms, streets
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.navigation.routes.route import Route, plan_route
from handcart.robotics.navigation.routes.shortest_path import shortest_clear_path
from handcart.robotics.navigation.routes.voronoi_graph import VoronoiGraph, voronoi_graph
from handcart.robotics.numerics.arrays import FloatArray, IntArray

ROUNDING_M = 1e-9  # [m]
PER_ROUTE = 200  # samples
PAIR_COUNT = 6  # starts and goals on a random grid
MIN_PAIR_CELLS = 20  # [cells] between start and goal where lengths are compared


class Found(NamedTuple):
    """Counts on the random grids."""

    samples: int
    nearer: int
    worst: float
    """[m] nearer than said, of all samples."""
    routes: int
    tight: int
    """Routes with less room than the radius somewhere, although start and goal have it."""
    missing: int
    """Number of routes that were missed, or found where none exists."""


def in_cells(grid: GridMap, points: FloatArray) -> FloatArray:
    """Rows and columns (n, 2) of points (n, 2) in [m]."""
    cells: FloatArray = (points - (grid.origin_x, grid.origin_y))[:, ::-1] / grid.resolution - 0.5
    return cells


def shortfalls(grid: GridMap, route: Route, rng: np.random.Generator, samples: int = PER_ROUTE) -> FloatArray:
    """Return (samples,) by how much random spots of the route are nearer to what is blocked than it says, in
    [m].
    """
    i, share = rng.integers(len(route.points) - 1, size=samples), rng.random(samples)
    spots = route.points[i] + share[:, None] * (route.points[i + 1] - route.points[i])
    said = route.clearance[i] + share * (route.clearance[i + 1] - route.clearance[i])
    return said - distance_to_squares(grid.blocked, in_cells(grid, spots)) * grid.resolution


def components(grid: GridMap, radius: float) -> IntArray:
    """Return (h, w) number of the part of the map that the robot's centre may be in, 0 where it may not."""
    height, width = grid.blocked.shape
    spots = np.argwhere(np.ones((2 * height + 1, 2 * width + 1), dtype=np.bool_)) / 2.0 - 0.5
    corners = np.clip(spots, -0.5, np.array([height, width]) - 0.5)
    room = distance_to_squares(grid.blocked, corners).reshape(2 * height + 1, 2 * width + 1)
    free = (room > 1e-6) & (room >= radius / grid.resolution - 1e-5)
    free[1::2, ::2] &= np.pad(free[1::2, 1::2], ((0, 0), (1, 0))) & np.pad(free[1::2, 1::2], ((0, 0), (0, 1)))
    free[::2, 1::2] &= np.pad(free[1::2, 1::2], ((1, 0), (0, 0))) & np.pad(free[1::2, 1::2], ((0, 1), (0, 0)))
    labels: IntArray = ndimage.label(free, np.ones((3, 3)))[0][1::2, 1::2]
    return labels


def try_grid(seed: int) -> Found:
    """Routes on one random grid; the pairs take turns between centres of cells and anywhere in them."""
    grid, radius = random_grid(seed)
    try:
        graph = voronoi_graph(grid, radius)
    except ValueError:
        return Found(0, 0, 0.0, 0, 0, 0)
    rng, cells, part = np.random.default_rng(seed), np.argwhere(graph.free), components(grid, radius)
    off, tight, missing = [], 0, 0
    for turn in range(PAIR_COUNT):
        pair = cells[rng.integers(len(cells), size=2)]
        spread = 0.49 * (turn % 2)
        ends = grid.to_point(pair + rng.uniform(-spread, spread, (2, 2)))
        route = plan_route(graph, tuple(ends[0]), tuple(ends[1]))
        if turn % 2 == 0:
            joined = part[tuple(pair[0])] == part[tuple(pair[1])]
            missing += joined != (route is not None)
            tight += route is not None and route.clearance.min() < radius * (1.0 - 1e-5)
        if route is not None:
            off.append(shortfalls(grid, route, rng))
    found = np.concatenate(off) if off else np.empty(0)
    return Found(
        len(found), int((found > ROUNDING_M).sum()), found.max(initial=0.0), len(off), tight, missing
    )


def exactness(samples: int, seed: int) -> None:
    """Routes on random grids until there are so many samples."""
    begin, total, grids = time.perf_counter(), Found(0, 0, 0.0, 0, 0, 0), 0
    while total.samples < samples:
        one = try_grid(seed + grids)
        total = Found(
            total.samples + one.samples,
            total.nearer + one.nearer,
            max(total.worst, one.worst),
            total.routes + one.routes,
            total.tight + one.tight,
            total.missing + one.missing,
        )
        grids += 1
        if grids % 250 == 0:
            print(f"{total.samples:,} of {samples:,} samples", file=sys.stderr, flush=True)
    print(f"{total.samples:,} samples of {total.routes:,} routes on {grids:,} random grids, seed {seed}:")
    print(f"  nearer than the route says: {total.nearer} (worst by {max(total.worst, 0.0):.1e} m)")
    print(f"  routes with less room than the radius from roomy start to roomy goal: {total.tight}")
    print(f"  no route where there is a way, or the other way round: {total.missing}")
    print(f"  {time.perf_counter() - begin:.0f} s")


def reduced(grid: GridMap, times: int) -> GridMap:
    """Cells `times` as large, blocked if any of theirs was."""
    height, width = np.array(grid.blocked.shape) // times * times
    parts = grid.blocked[:height, :width].reshape(height // times, times, width // times, times)
    occupied = np.asarray(parts.any(axis=(1, 3)))
    return GridMap(occupied, np.zeros_like(occupied), grid.resolution * times, grid.origin_x, grid.origin_y)


def maps(folder: Path | None) -> list[tuple[str, GridMap, float]]:
    """Name, map and radius of all that lengths are compared on."""
    real = real_maps(folder)
    if not real:
        where = "no --maps FOLDER" if folder is None else f"none in {folder}"
        print(f"real maps are skipped: {where} (turtlebot3/map.pgm, depot/depot.pgm)", file=sys.stderr)
    office = ("office", office_map(0, 400, 300), 0.25)
    coarse = {name: grid for name, grid, _ in (office, *real)}
    found = [office, *real, *((f"{name} / 4", reduced(grid, 4), 0.3) for name, grid in coarse.items())]
    for radius in (0.0, 0.5):
        made = [(f"streets {k}", streets(np.random.default_rng(k), (256, 256))) for k in range(2)]
        made += [(f"rooms {k}", rooms(np.random.default_rng(k), (256, 256), k)) for k in (8, 16, 32)]
        found += [(name, GridMap(cells, np.zeros_like(cells), 1.0, 0.0, 0.0), radius) for name, cells in made]
    return found


def far_pairs(graph: VoronoiGraph, count: int, seed: int) -> list[IntArray]:
    """Return a start and a goal (2, 2): random free cells that are `MIN_PAIR_CELLS` apart."""
    rng, cells = np.random.default_rng(seed), np.argwhere(graph.free)
    pairs: list[IntArray] = []
    while len(pairs) < count:
        pair = cells[rng.integers(len(cells), size=2)]
        if np.hypot(*(pair[0] - pair[1])) >= MIN_PAIR_CELLS:
            pairs.append(pair)
    return pairs


def compare(name: str, grid: GridMap, radius: float, count: int) -> FloatArray:
    """Print the row of a map, and return (n,) lengths divided by that of the shortest 8-connected path."""
    graph = voronoi_graph(grid, radius)
    price = np.where(graph.free, 1.0, -1.0)
    by_grid, by_any, room, taken, nearer, missing = [], [], [], [], 0, 0
    for pair in far_pairs(graph, count, 1):
        start, goal = (tuple(point) for point in grid.to_point(pair).tolist())
        begin = time.process_time()
        route = plan_route(graph, start, goal)
        taken.append(1e3 * (time.process_time() - begin))
        corners = shortest_clear_path(graph.free, graph.squares, graph.need, pair[0], pair[1])
        missing += (route is None) != (corners is None)
        if route is None or corners is None:
            continue
        costs, _ = MCP_Geometric(price).find_costs([tuple(pair[0])], [tuple(pair[1])])
        by_grid.append(route.length / (costs[tuple(pair[1])] * grid.resolution))
        shortest, its_room = length_and_room(graph, corners.astype(np.float64))
        by_any.append(route.length / shortest)
        room.append(route.mean_clearance / its_room)
        nearer += int((shortfalls(grid, route, np.random.default_rng(0), 50) > ROUNDING_M).sum())
    middle, high, most = np.quantile(by_grid, [0.5, 0.95, 1.0])
    print(
        f"{name:<15} {radius:<6g} {middle:.3f}  {high:.3f}  {most:.3f}   {np.median(by_any):.3f}     "
        f"{np.mean(room):.2f}   {np.median(taken):5.2f}   {missing:>4} {nearer:>6}",
        flush=True,
    )
    return np.array(by_grid)


def main() -> None:
    """Measure and print both tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--samples", type=int, default=1_000_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--pairs", type=int, default=100, help="on each map")
    parser.add_argument("--maps", type=Path, help="folder with maps of real buildings (default: none)")
    options = parser.parse_args()
    exactness(options.samples, options.seed)
    print("\nroute / shortest 8-connected; / any-angle shortest; mean clearance / that one's; CPU ms a query")
    print("map             radius median 95 %   most    any-angle room    ms  missing nearer")
    rows = [compare(*map_, options.pairs) for map_ in maps(options.maps)]
    middle, high, most = np.quantile(np.concatenate(rows), [0.5, 0.95, 1.0])
    worst = max(float(np.median(row)) for row in rows)
    print(f"{'all':<22} {middle:.3f}  {high:.3f}  {most:.3f}   largest median of a map {worst:.3f}")


if __name__ == "__main__":
    main()
