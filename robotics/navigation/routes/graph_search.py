"""Searches on the flat arrays of a Voronoi graph."""

from __future__ import annotations

import numpy as np

from handcart.robotics.navigation.maps.blocked_squares import BlockedSquares, is_clear, line_clearance
from handcart.robotics.numerics.arrays import BoolArray, FloatArray, IntArray
from handcart.robotics.numerics.compiled import compiled


@compiled
def way_in(
    free: BoolArray, squares: BlockedSquares, spot: FloatArray, reach: int, need: float
) -> tuple[int, int]:
    """Return the nearest free cell to which a straight line from a point keeps the clearance `need`.

    If there is no such cell, for example in a corner, return the cell whose line to the point has the largest
    clearance.

    Args:
        free: (h, w) cells whose centres have the room needed.
        squares: blocked squares of the map.
        spot: (2,) row and column of the point, in [cells], on the map and in no blocked cell.
        reach: largest distance of the cell, in [cells].
        need: clearance of the line to the cell, in [cells].

    Returns:
        Row and column; (-1, -1) if every line to a free cell leads through blocked cells.
    """
    height, width = free.shape
    row, column = int(spot[0] + 0.5), int(spot[1] + 0.5)
    near, clearest = float((reach + 1) ** 2), 0.0
    found, other = (-1, -1), (-1, -1)
    centre = np.empty(2)
    for ring in range(reach + 1):
        if (ring - 0.5) ** 2 > near and ring > 0:
            break
        for r in range(max(row - ring, 0), min(row + ring, height - 1) + 1):
            step = 1 if abs(r - row) == ring else max(2 * ring, 1)
            for c in range(column - ring, column + ring + 1, step):
                if not (0 <= c < width and free[r, c]):
                    continue
                away = (spot[0] - r) ** 2 + (spot[1] - c) ** 2
                centre[0], centre[1] = r, c
                if away < near and is_clear(squares, spot, centre, need):
                    near, found = away, (r, c)
                if found[0] < 0:
                    clear = line_clearance(squares, spot, centre, need, clearest)
                    if clear > clearest:
                        clearest, other = clear, (r, c)
    return found if found[0] >= 0 else other


@compiled
def _first_seen(
    squares: BlockedSquares,
    need: float,
    cells: IntArray,
    edge_of: IntArray,
    order: IntArray,
    row: int,
    column: int,
    most: int,
) -> IntArray:
    """Return indices (k,) into `cells` of the first cell in sight of each of the first `most` edges, in this
    order.
    """
    found = np.empty(most, dtype=np.int64)
    count = 0
    here, there = np.array([float(row), float(column)]), np.empty(2)
    for i in order:
        there[0], there[1] = cells[i, 0], cells[i, 1]
        known = False
        for k in range(count):
            known = known or edge_of[found[k]] == edge_of[i]
        if not known and is_clear(squares, here, there, need):
            found[count] = i
            count += 1
            if count == most:
                break
    return found[:count]


def in_sight(
    squares: BlockedSquares,
    need: float,
    cells: IntArray,
    edge_of: IntArray,
    cell: tuple[int, int],
    edges: int = 4,
    tried: int = 400,
) -> IntArray:
    """Return the cells of a Voronoi graph that can be reached from a given cell by a straight line.

    One cell is returned for each of the few edges nearest to the given cell.

    Args:
        squares: blocked squares of the map.
        need: clearance of the line to the graph, in [cells].
        cells: (c, 2) row and column of the cells of the graph.
        edge_of: (c,) number of the edge of each cell.
        cell: row and column of the given cell, which is free.
        edges: number of different edges to find.
        tried: number of nearest cells to examine before examining all.

    Returns:
        (k,) indices into `cells`, nearest first; empty if no cell can be reached.
    """
    away = (cells[:, 0] - cell[0]) ** 2 + (cells[:, 1] - cell[1]) ** 2
    if len(away) > tried:
        near = np.argpartition(away, tried)[:tried]
        near = near[np.argsort(away[near], kind="stable")]
        found = _first_seen(squares, need, cells, edge_of, near, cell[0], cell[1], edges)
        if len(found):
            return found
    order = np.argsort(away, kind="stable")
    return _first_seen(squares, need, cells, edge_of, order, cell[0], cell[1], edges)


def cheapest_nodes(
    slots: IntArray,
    slot_first: IntArray,
    ends: IntArray,
    length: FloatArray,
    start_cost: FloatArray,
    goal_cost: FloatArray,
    limit: float,
) -> tuple[int, float, IntArray]:
    """Return the cheapest path through a Voronoi graph from any of many starts to any of many goals
    (Dijkstra).

    The next node is searched linearly among all open ones: a Voronoi graph has a few hundred nodes, and a
    heap would take longer to compile than it saves. All costs are in the unit of the prices of `EdgeTable`.

    Args:
        slots: (2e,) edges at all nodes, one node after the other, each as 2 * edge + (0 or 1, its end there).
        slot_first: (n + 1,) node i has slots[slot_first[i]:slot_first[i + 1]].
        ends: (e, 2) numbers of the nodes at both ends of each edge.
        length: (e,) cost of each edge.
        start_cost: (n,) cost of beginning at each node, inf where that is impossible.
        goal_cost: (n,) cost of ending at each node, inf where that is impossible.
        limit: upper bound; a path with a higher total is ignored.

    Returns:
        The last node of the path (-1 if no path is below the limit), its total cost, and for each node (n,)
        the slot of the edge that leads back towards the start (-1 where the path begins).
    """
    back = np.full(len(start_cost), -1, dtype=np.int64)
    done = np.zeros(len(start_cost), dtype=np.bool_)
    last, total = _spread(slots, slot_first, ends, length, start_cost.copy(), back, done, goal_cost, limit)
    return last, total, back


@compiled
def _spread(
    slots: IntArray,
    slot_first: IntArray,
    ends: IntArray,
    length: FloatArray,
    cost: FloatArray,
    back: IntArray,
    done: BoolArray,
    goal_cost: FloatArray,
    limit: float,
) -> tuple[int, float]:
    """Bring `cost`, `back` and `done` of each node up to date, until the best last node is sure."""
    best, last = limit, -1
    while True:
        so_far, node = np.inf, -1
        for other in range(len(cost)):
            if cost[other] < so_far and not done[other]:
                so_far, node = cost[other], other
        if node < 0 or so_far >= best:
            break
        done[node] = True
        if so_far + goal_cost[node] < best:
            best, last = so_far + goal_cost[node], node
        for place in range(slot_first[node], slot_first[node + 1]):
            slot = slots[place]
            other = ends[slot // 2, 1 - slot % 2]
            new = so_far + length[slot // 2]
            if new < cost[other]:
                cost[other] = new
                back[other] = slot ^ 1
    return last, best
