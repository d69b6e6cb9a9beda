"""The reduced generalized Voronoi graph of a map (Choset and Burdick, 2000), on a grid."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass
from functools import cached_property

import cv2
import networkx as nx
import numpy as np

from handcart.robotics.navigation.maps.blocked_squares import (
    TOUCHING_CELLS,
    BlockedSquares,
    blocked_squares,
    is_clear,
)
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.navigation.routes.skeleton_trace import SkeletonTrace, link, prune_leaves, trace
from handcart.robotics.navigation.routes.thinning import thin
from handcart.robotics.numerics.arrays import BoolArray, FloatArray, IntArray, SingleArray
from handcart.robotics.numerics.stepwise import finish

# of room in the price of a way: buys the clearance that 1.15 of the shortest length can
CLEARANCE_EXPONENT = 0.75
DISTANCE_TOLERANCE = 1e-6  # of the radius, by which 32-bit distances may be off
BLOCKED_PRICE = 1e9  # price of what can't be passed: more than any way on a map costs
# a leaf this near to the grown obstacles, in [cells], touches them: rounding of two distances
TOUCH_DISTANCE_CELLS = 2.0
STEP_CELLS = 20_000  # of a map, above which each part of a plan is a computing step of its own


class EdgeTable:
    """Edges of a Voronoi graph as flat arrays, because objects would slow down searches.

    Attributes:
        nodes: (n, 2) cells, row and column.
        cells: (c, 2) cells of all edges one after the other, end nodes included.
        first: (e + 1,), edge i is cells[first[i]:first[i + 1]].
        ends: (e, 2) node numbers of the two ends.
        along: (c,) length along the edge up to each cell, in [cells].
        edge_of: (c,) number of the edge that a cell belongs to.
        length: (e,) length of each edge, in [cells].
        price_along: (c,) like `along`, with each step multiplied by the price of its cell; a step over a
            corner that is too narrow adds `BLOCKED_PRICE`.
        price: (e,) price of each complete edge.
        slots: (2e,) edges at all nodes, one node after the other, each as 2 * edge + (0 or 1, its end there).
        slot_first: (n + 1,) node i has slots[slot_first[i]:slot_first[i + 1]].
    """

    def __init__(
        self,
        found: SkeletonTrace,
        width: int,
        price: SingleArray,
        squares: BlockedSquares,
        need: float,
    ) -> None:
        self.nodes = _unflatten(found.nodes, width)
        self.cells = _unflatten(found.cells, width)
        self.first = found.first
        tips = np.column_stack([found.cells[found.first[:-1]], found.cells[found.first[1:] - 1]])
        self.ends: IntArray = np.searchsorted(found.nodes, tips).reshape(-1, 2)
        step = np.hypot(*np.diff(self.cells, axis=0, prepend=self.cells[:1]).T)
        step[self.first[:-1]] = 0.0
        total = np.cumsum(step)
        sizes = np.diff(self.first)
        self.along: FloatArray = total - np.repeat(total[self.first[:-1]], sizes)
        self.edge_of: IntArray = np.repeat(np.arange(len(sizes)), sizes)
        self.length: FloatArray = self.along[self.first[1:] - 1]
        priced = np.cumsum(
            step * price[self.cells[:, 0], self.cells[:, 1]]
            + BLOCKED_PRICE * _too_narrow(squares, need, self.cells, step)
        )
        self.price_along: FloatArray = priced - np.repeat(priced[self.first[:-1]], sizes)
        self.price: FloatArray = self.price_along[self.first[1:] - 1]
        self.slots, self.slot_first = _incidence(self.ends, len(self.nodes))


@dataclass(frozen=True, eq=False)
class VoronoiGraph:
    """Graph of the ways through the middle of a map's free space, on which routes are searched.

    The graph covers one connected area of free cells. It is connected, and has one independent cycle around
    each obstacle inside the area. Free cells are connected also over corners, blocked cells only
    over sides. Two free cells that share only a corner may leave too little room for the robot between the
    blocked cells there. The graph's edge then has a `BLOCKED_PRICE`, so that no route uses it.
    """

    map: GridMap
    radius: float
    """Radius by which obstacles were grown, in [m]."""
    squares: BlockedSquares
    """Blocked squares of the map, used for exact distances."""
    need: float
    """Clearance of every way, in [cells]: the radius less rounding, and always more than touching."""
    clearance: SingleArray
    """(h, w) distance from each cell's centre to the nearest blocked cell's square, in [m]."""
    price: SingleArray
    """(h, w) price of a path for each unit of its length, by `room_price`; lower where there is more room."""
    free: BoolArray
    """(h, w) the component: cells that the robot's centre may be in."""
    edges: EdgeTable

    @cached_property
    def graph(self) -> nx.MultiGraph:
        """The graph as an object of the library networkx, with positions on the map in [m].

        Nodes have a `point` (x, y). Edges have `points` (k, 2), a `length` and the least `clearance`.
        """
        return _network(self.map, self.edges, self.clearance)

    @property
    def dearest(self) -> float:
        """Highest cost of a path per unit of its length; the cost is highest where the robot just fits."""
        return float(max(self.radius, self.map.resolution) ** -CLEARANCE_EXPONENT)

    @property
    def components(self) -> int:
        """Number of connected components of the graph."""
        return int(nx.number_connected_components(self.graph))

    @property
    def cycles(self) -> int:
        """Number of independent cycles of the graph."""
        return int(self.graph.number_of_edges() - self.graph.number_of_nodes() + self.components)


def voronoi_graph(
    grid: GridMap,
    radius: float,
    seed_point: tuple[float, float] | None = None,
    squares: BlockedSquares | None = None,
) -> VoronoiGraph:
    """Return the Voronoi graph of a map for a disc-shaped robot: the ways through the middle of the free
    space.

    Args:
        grid: map; unknown cells and everything beyond the map count as obstacles.
        radius: robot's radius, in [m]; obstacles are grown by it.
        seed_point: (x, y) in [m]; the graph is built in the connected free area at or nearest to this point;
            None: in the largest area.
        squares: blocked squares of the map, if they are known already.

    Raises:
        ValueError: no cell is left free for a robot of this radius.
    """
    return finish(graphing(grid, radius, seed_point, squares))


def graphing(
    grid: GridMap,
    radius: float,
    seed_point: tuple[float, float] | None = None,
    squares: BlockedSquares | None = None,
) -> Generator[None, None, VoronoiGraph]:
    """Return the Voronoi graph of a map like `voronoi_graph`; a generator that yields once on a map of more
    than `STEP_CELLS`, between thinning the free space and tracing its lines.

    Args:
        grid: map, as for `voronoi_graph`.
        radius: robot's radius, in [m].
        seed_point: (x, y) in [m] in or near the connected free area; None: the largest area.
        squares: blocked squares of the map, if they are known already.

    Raises:
        ValueError: no cell is left free for a robot of this radius.
    """
    squares = blocked_squares(grid.blocked) if squares is None else squares
    distance = squares.distance
    need = max(radius / grid.resolution * (1.0 - 2.0 * DISTANCE_TOLERANCE), TOUCHING_CELLS)
    free = _component(
        (distance >= radius / grid.resolution * (1.0 - DISTANCE_TOLERANCE)) & (distance > 0.0),
        grid,
        seed_point,
    )
    lines = thin(free, distance)
    if grid.occupied.size > STEP_CELLS:
        yield
    cells, links = link(lines)
    width = free.shape[1]
    cells = prune_leaves(cells, links, width, distance.ravel() <= need + TOUCH_DISTANCE_CELLS)
    clearance = np.ascontiguousarray(distance[1:-1, 1:-1]) * np.float32(grid.resolution)
    price = room_price(clearance, grid.resolution)
    table = EdgeTable(trace(cells, links, width), width, price, squares, need)
    inner = np.ascontiguousarray(free[1:-1, 1:-1])
    return VoronoiGraph(grid, radius, squares, need, clearance, price, inner, table)


def room_price(clearance: SingleArray, resolution: float) -> SingleArray:
    """Return the price (h, w), for each cell, of a path per unit of its length, without unit.

    The price is lower where there is more room, so that the cheapest route keeps away from obstacles.

    Args:
        clearance: (h, w) distance of cells from obstacles, in [m].
        resolution: side of a cell, in [m]; smaller clearances count as this.
    """
    price: SingleArray = np.maximum(clearance, np.float32(resolution)) ** np.float32(-CLEARANCE_EXPONENT)
    return price


def _too_narrow(squares: BlockedSquares, need: float, cells: IntArray, step: FloatArray) -> BoolArray:
    """Return (c,) whether a step to a cell (c, 2) leads over a corner too narrowly, and no free cell lies
    beside.
    """
    rows, columns = cells.T + 1
    before_row, before_column = np.roll(rows, 1), np.roll(columns, 1)
    beside = np.maximum(squares.distance[before_row, columns], squares.distance[rows, before_column])
    narrow: BoolArray = (step > 1.0) & (beside < need)
    for i in np.flatnonzero(narrow):
        ends = cells[i - 1 : i + 1].astype(np.float64)
        narrow[i] = not is_clear(squares, ends[0], ends[1], need)
    return narrow


def _component(free: BoolArray, grid: GridMap, seed_point: tuple[float, float] | None) -> BoolArray:
    """Return a mask of the largest component of the padded free cells, or that nearest to a seed point."""
    if not free.any():
        raise ValueError("no free cell is left after growing the obstacles by the robot's radius")
    if seed_point is None:
        _, labels, stats, _ = cv2.connectedComponentsWithStats(free.view(np.uint8), connectivity=8)
        return np.asarray(labels == 1 + int(np.argmax(stats[1:, cv2.CC_STAT_AREA])))
    row, column = (grid.to_cell(np.array([seed_point]))[0] + 1).tolist()
    is_inside = 0 <= row < free.shape[0] and 0 <= column < free.shape[1]
    if not is_inside or not free[row, column]:
        rows, columns = np.nonzero(free)
        nearest = int(np.argmin((rows - row) ** 2 + (columns - column) ** 2))
        row, column = rows[nearest], columns[nearest]
    filled = free.astype(np.uint8)
    cv2.floodFill(filled, None, (int(column), int(row)), 2, flags=8)  # 8-connected
    return np.asarray(filled == 2)


def _network(grid: GridMap, table: EdgeTable, clearance: SingleArray) -> nx.MultiGraph:
    graph = nx.MultiGraph()
    graph.add_nodes_from(
        (i, {"point": (x, y)}) for i, (x, y) in enumerate(grid.to_point(table.nodes).tolist())
    )
    if len(table.length) == 0:
        return graph
    points = grid.to_point(table.cells)
    least = np.minimum.reduceat(clearance[table.cells[:, 0], table.cells[:, 1]], table.first[:-1])
    bounds, lengths = table.first.tolist(), (table.length * grid.resolution).tolist()
    graph.add_edges_from(
        (
            a,
            b,
            i,
            {"points": points[bounds[i] : bounds[i + 1]], "length": lengths[i], "clearance": float(least[i])},
        )
        for i, (a, b) in enumerate(table.ends.tolist())
    )
    return graph


def _unflatten(cells: IntArray, padded_width: int) -> IntArray:
    """Rows and columns (n, 2) on the map of flat indices on the padded map."""
    return np.column_stack(np.divmod(cells, padded_width)) - 1


def _incidence(ends: IntArray, nodes: int) -> tuple[IntArray, IntArray]:
    """Return slots (2e,) and first (n + 1,) of the edges at each node.

    Node i has slots[first[i]:first[i + 1]], each 2 * edge + (0 or 1, its end there).
    """
    flat = ends.ravel()
    slots = np.argsort(flat, kind="stable")
    first = np.zeros(nodes + 1, dtype=np.int64)
    np.cumsum(np.bincount(flat, minlength=nodes), out=first[1:])
    return slots, first
