"""Searches on the flat arrays of a Voronoi graph."""

from __future__ import annotations

import heapq

import numpy as np
from numpy.typing import NDArray

from robotics.navigation.compiled import compiled
from robotics.navigation.line_of_sight import sees


@compiled
def nearest_free(free: NDArray[np.bool_], row: int, column: int, reach: int) -> tuple[int, int]:
    """The free cell nearest to a cell, at most `reach` cells away; (-1, -1) if there is none."""
    height, width = free.shape
    best = float(reach * reach) + 0.5
    found = (-1, -1)
    for ring in range(reach + 1):
        if ring * ring > best:
            break
        for r in range(max(row - ring, 0), min(row + ring, height - 1) + 1):
            step = 1 if abs(r - row) == ring else max(2 * ring, 1)
            for c in range(column - ring, column + ring + 1, step):
                away = float((r - row) ** 2 + (c - column) ** 2)
                if 0 <= c < width and free[r, c] and away < best:
                    best, found = away, (r, c)
    return found


@compiled
def _first_seen(
    free: NDArray[np.bool_],
    cells: NDArray[np.int64],
    edge_of: NDArray[np.int64],
    order: NDArray[np.int64],
    row: int,
    column: int,
    most: int,
) -> NDArray[np.int64]:
    """Indices into `cells` of the first cell in sight of each of the first `most` edges, in this order."""
    found = np.empty(most, dtype=np.int64)
    count = 0
    for i in order:
        known = False
        for k in range(count):
            known = known or edge_of[found[k]] == edge_of[i]
        if not known and sees(free, row, column, cells[i, 0], cells[i, 1]):
            found[count] = i
            count += 1
            if count == most:
                break
    return found[:count]


def in_sight(
    free: NDArray[np.bool_],
    cells: NDArray[np.int64],
    edge_of: NDArray[np.int64],
    cell: tuple[int, int],
    edges: int = 4,
    tried: int = 400,
) -> NDArray[np.int64]:
    """Where a cell can join the graph: on the nearest few edges in line of sight.

    Args:
        free: (h, w) free cells.
        cells: (c, 2) cells of the graph.
        edge_of: (c,) their edges.
        cell: row and column, free.
        edges: how many different edges to find.
        tried: how many of the nearest cells to look at before looking at all.

    Returns:
        (k,) indices into `cells`, nearest first; empty if none is in sight.
    """
    away = (cells[:, 0] - cell[0]) ** 2 + (cells[:, 1] - cell[1]) ** 2
    if len(away) > tried:
        near = np.argpartition(away, tried)[:tried]
        near = near[np.argsort(away[near], kind="stable")]
        found = _first_seen(free, cells, edge_of, near, cell[0], cell[1], edges)
        if len(found):
            return found
    order = np.argsort(away, kind="stable")
    return _first_seen(free, cells, edge_of, order, cell[0], cell[1], edges)


@compiled
def cheapest_nodes(
    slots: NDArray[np.int64],
    slot_first: NDArray[np.int64],
    ends: NDArray[np.int64],
    length: NDArray[np.float64],
    start_cost: NDArray[np.float64],
    goal_cost: NDArray[np.float64],
    limit: float,
) -> tuple[int, float, NDArray[np.int64]]:
    """Dijkstra from many starts to many goals.

    Args:
        slots: incidence as in `EdgeTable`.
        slot_first: (n + 1,) as in `EdgeTable`.
        ends: (e, 2) nodes.
        length: (e,).
        start_cost: (n,) cost of beginning at each node, inf where one can't.
        goal_cost: (n,) cost of ending at each node, inf where one can't.
        limit: only a total below this is of use.

    Returns:
        The last node (-1 if there is no way below the limit), the total, and for each node the slot of the
        edge that leads back from it (-1 where the way begins).
    """
    cost = start_cost.copy()
    back = np.full(len(cost), -1, dtype=np.int64)
    queue = [(cost[node], node) for node in range(len(cost)) if cost[node] < np.inf]
    heapq.heapify(queue)
    best, last = limit, -1
    while queue:
        so_far, node = heapq.heappop(queue)
        if so_far >= best:
            break
        if so_far > cost[node]:
            continue
        if so_far + goal_cost[node] < best:
            best, last = so_far + goal_cost[node], node
        for slot in slots[slot_first[node] : slot_first[node + 1]]:
            other = ends[slot // 2, 1 - slot % 2]
            new = so_far + length[slot // 2]
            if new < cost[other]:
                cost[other] = new
                back[other] = slot ^ 1
                heapq.heappush(queue, (new, other))
    return last, best, back
