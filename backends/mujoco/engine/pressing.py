"""Pairs of bodies that press on each other, from MuJoCo's contacts."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from handcart.backends.physics.engine.engine import ContactPoint, Touching

Owner = tuple[int, int]
"""A body of the engine's and its link; a thing's is -1."""
_NOTHING = frozenset[Touching]()


class Pressing:
    """Reader of MuJoCo's contacts that finds, for each body, the bodies that press against it.

    The last result is cached, because after most steps the same geometries touch as before.
    """

    def __init__(self, owners: Sequence[Owner]) -> None:
        """Prepare the index; `owners` has the body and link of each geometry."""
        self._owners = owners
        self._seen = b""
        self._found: dict[int, frozenset[Touching]] = {}

    def touching(self, data: Any, body: int) -> frozenset[Touching]:
        """Return the pairs of touching links, one of the body and one of another body, between which a force
        acts.

        If the touching pairs are those of the last call, the same object is returned.
        """
        if data.nefc == 0:
            return _NOTHING
        contact = data.contact
        rows, pairs = contact.efc_address, contact.geom
        pressed = (data.efc_force.take(rows, mode="clip") > 0.0) & (rows >= 0)
        seen = pairs.tobytes() + pressed.tobytes()
        if seen != self._seen:
            self._seen, self._found = seen, self._of(pairs[pressed].tolist())
        return self._found.get(body, _NOTHING)

    def _of(self, pairs: Sequence[tuple[int, int]]) -> dict[int, frozenset[Touching]]:
        """Return the bodies that touch each body, from pairs of pressing geometries."""
        found: dict[int, set[Touching]] = {}
        for first, second in pairs:
            one, other = self._owners[first], self._owners[second]
            found.setdefault(one[0], set()).add(Touching(one[1], *other))
            found.setdefault(other[0], set()).add(Touching(other[1], *one))
        return {body: frozenset(group) for body, group in found.items()}

    def contacts(self, data: Any, body: int) -> list[ContactPoint]:
        """Return the contact points of one body, with normals and forces in the world frame, in [N]."""
        contact, forces = data.contact, data.efc_force
        found = []
        for touching, index, row, sign in self._points(data, body):
            # A contact's frame has its normal first, which points from the first to the second geometry.
            frame = sign * contact.frame[index].reshape(3, 3)
            force = forces[row : row + 3] @ frame
            found.append(ContactPoint(*touching, tuple(frame[0].tolist()), tuple(force.tolist())))
        return found

    def _points(self, data: Any, body: int) -> Iterator[tuple[Touching, int, int, float]]:
        """Yield the contacts of a body.

        Each is the touching pair, the number of MuJoCo's contact, the first row of its forces, and the sign
        with which the contact frame's normal points towards the body.
        """
        contact, forces, owners = data.contact, data.efc_force, self._owners
        rows = contact.efc_address.tolist()
        for index, (row, (first, second)) in enumerate(zip(rows, contact.geom.tolist(), strict=True)):
            one, other = owners[first], owners[second]
            if row < 0 or body not in (one[0], other[0]) or forces[row] <= 0.0:
                continue
            if one[0] == body:
                yield Touching(one[1], *other), index, row, -1.0
            if other[0] == body:
                yield Touching(other[1], *one), index, row, 1.0
