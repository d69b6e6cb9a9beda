"""The person who hands books over."""

from __future__ import annotations

from .books_there import BooksThere, Waiting

REACH_M = 0.5  # [m] from where the robot started, within a person's reach
STILL_MOTION = 1e-3  # [m], [rad]: motors that hold a robot still let it move less
WAITING_TIME_S = 1.0  # [s] that the robot is there with an empty tray and hand before the next book comes


class Person:
    """Simulated person who puts the books to be returned onto the robot's tray, one after the other.

    The person puts down a book when the robot has been at rest near its initial pose, with tray and hand
    empty, for 1 s.
    """

    def __init__(self, books: BooksThere) -> None:
        """Hand over the books in `books.to_come`; the progress is in `books.waits`."""
        self._books, self._start = books, books.scene.base

    def step(self) -> None:
        """Advance the person by one control period: put the next of the books to be returned onto the tray if
        the robot has been ready to receive it for 1 s.
        """
        books, scene, waits = self._books, self._books.scene, self._books.waits
        if not books.to_come or not scene.robot.has_tray:
            return
        idle = scene.held is None and books.tray_book() is None
        stands = (
            scene.base.distance(waits.stood) < STILL_MOTION and scene.base.turn(waits.stood) < STILL_MOTION
        )
        if not (idle and stands) or scene.base.distance(self._start) > REACH_M:
            books.waits = Waiting(waits.given, scene.base, scene.time)
        elif scene.time >= waits.since + WAITING_TIME_S:
            books.waits = waits._replace(given=waits.given + 1)
            books.set_on_tray(books.to_come.pop(0), books.waits.given)
