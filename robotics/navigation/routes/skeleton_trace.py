"""Trace the cells of a skeleton into nodes and edges, without losing or inventing a cycle.

Two skeleton cells are linked when they share a side, or a corner that no third skeleton cell bridges. Each
full 2 x 2 block loses its upper link, because its four links would be a cycle around nothing. The graph of
these links has the components of the 8-connected skeleton, and one independent cycle for each 4-connected
hole in it (Euler's formula for the cell complex whose faces are the full blocks).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handcart.robotics.navigation.routes.thinning import neighbour_steps
from handcart.robotics.numerics.arrays import BoolArray, ByteArray, IntArray
from handcart.robotics.numerics.compiled import compiled

LINK_COUNTS = np.array([code.bit_count() for code in range(256)], dtype=np.uint8)


class SkeletonTrace(NamedTuple):
    """Graph traced along the skeleton (centre lines) of a grid's area, with nodes, and edges as sequences of
    cells.

    A cell is given by its index, row * width + column.
    """

    nodes: IntArray
    """(n,) cells that are a node: ends, junctions, lone cells, and one cell of each plain loop."""
    cells: IntArray
    """(c,) cells of all edges one after the other, end nodes included."""
    first: IntArray
    """(e + 1,): edge i is cells[first[i]:first[i + 1]]."""


@compiled
def _link(skeleton: ByteArray, cells: IntArray, links: ByteArray, steps: IntArray) -> None:
    up = steps[2]
    for cell in cells:
        code = 0
        for k in range(8):
            if not skeleton[cell + steps[k]]:
                continue
            if k % 2 == 1:
                linked = not (skeleton[cell + steps[k - 1]] or skeleton[cell + steps[(k + 1) % 8]])
            elif k == 0 or k == 4:
                linked = not (skeleton[cell + up] and skeleton[cell + up + steps[k]])
            else:
                linked = True
            if linked:
                code |= 1 << k
        links[cell] = code


@compiled
def _walk(
    links: ByteArray,
    is_node: ByteArray,
    start: int,
    steps: IntArray,
    out: IntArray,
    filled: int,
) -> int:
    """Follow one link out of `start` to the next node, using links up; how much of `out` is filled then."""
    cell = start
    out[filled] = cell
    filled += 1
    while True:
        k = 0
        while not (links[cell] >> k) & 1:
            k += 1
        links[cell] &= 255 - (1 << k)
        cell = cell + steps[k]
        links[cell] &= 255 - (1 << ((k + 4) % 8))
        out[filled] = cell
        filled += 1
        if is_node[cell]:
            return filled


@compiled
def _walk_all(
    links: ByteArray,
    cells: IntArray,
    is_node: ByteArray,
    steps: IntArray,
    out: IntArray,
    first: IntArray,
) -> int:
    """Walk from every node, then around what is left: plain loops, each given a node of its own."""
    edges = 0
    for loops in range(2):
        for cell in cells:
            if loops and links[cell]:
                is_node[cell] = 1
            while is_node[cell] and links[cell]:
                first[edges + 1] = _walk(links, is_node, cell, steps, out, first[edges])
                edges += 1
    return edges


def link(skeleton: BoolArray) -> tuple[IntArray, ByteArray]:
    """Return the cells of a skeleton (lines one cell wide), and the links between neighbouring cells.

    Args:
        skeleton: (h, w) mask, False all along the border.

    Returns:
        The cells (n,) as flat indices, and links (h * w,): bit k is set if a cell is linked to the
        neighbour at step k of `neighbour_steps`.
    """
    cells = np.flatnonzero(skeleton).astype(np.int64)
    links = np.zeros(skeleton.size, dtype=np.uint8)
    _link(skeleton.ravel().view(np.uint8), cells, links, neighbour_steps(skeleton.shape[1]))
    return cells, links


def trace(cells: IntArray, links: ByteArray, width: int) -> SkeletonTrace:
    """Return the nodes and edges of a skeleton; `links` is not changed.

    Args:
        cells: (n,) flat indices of the skeleton's cells.
        links: (h * w,) bits of the neighbours that each cell is linked to.
        width: width of the map, in [cells].
    """
    degree = LINK_COUNTS[links[cells]]
    is_node = np.zeros(links.size, dtype=np.uint8)
    is_node[cells[degree != 2]] = 1
    most = int(degree.sum()) // 2
    out = np.empty(2 * most + 1, dtype=np.int64)
    first = np.zeros(most + 1, dtype=np.int64)
    edges = _walk_all(links.copy(), cells, is_node, neighbour_steps(width), out, first)
    return SkeletonTrace(cells[is_node[cells] == 1], out[: first[edges]], first[: edges + 1])


def prune_leaves(cells: IntArray, links: ByteArray, width: int, touching: BoolArray) -> IntArray:
    """Remove the edges of a skeleton that end at an obstacle, and return the remaining cells.

    Each removed edge leads from a junction to an end of the skeleton (a leaf) that touches an obstacle. There
    is only one pass: an edge that becomes a leaf by this removal leads into a dead-end room, and stays.

    Args:
        cells: (n,) flat indices of the skeleton's cells.
        links: (h * w,) bits of the linked neighbours, changed in place.
        width: width of the map, in [cells].
        touching: (h * w,) True where a leaf counts as touching an obstacle.

    Returns:
        (m,) flat indices of the remaining cells.
    """
    before = trace(cells, links, width)
    gone = np.zeros(links.size, dtype=np.uint8)
    _prune(before.cells, before.first, links.copy(), links, touching, gone, neighbour_steps(width))
    return np.asarray(cells[gone[cells] == 0])


@compiled
def _prune(
    cells: IntArray,
    first: IntArray,
    before: ByteArray,
    links: ByteArray,
    touching: BoolArray,
    gone: ByteArray,
    steps: IntArray,
) -> None:
    """Unlink the edges that end at an obstacle, and mark their cells in `gone`; `before`: a copy of links."""
    for i in range(first.size - 1):
        low, high = first[i], first[i + 1] - 1
        if LINK_COUNTS[before[cells[high]]] != 1:
            low, high = high, low
        is_leaf = LINK_COUNTS[before[cells[high]]] == 1 and LINK_COUNTS[before[cells[low]]] >= 3
        if not is_leaf or not touching[cells[high]]:
            continue
        step = 1 if high > low else -1
        for k in range(8):
            if steps[k] == cells[low + step] - cells[low]:
                links[cells[low]] &= 255 - (1 << k)
        for at in range(low + step, high + step, step):
            links[cells[at]] = 0
            gone[cells[at]] = 1
