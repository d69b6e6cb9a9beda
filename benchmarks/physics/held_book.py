"""Measure how well a hand holds a book while its robot drives.

    python -m benchmarks.physics.held_book [BACKEND] [SECONDS]

The librarian takes a book from its tray, and drives, turns, stops and drives back, with a swing of its arm
in between. Prints every ten seconds the largest motion and rotation of the book in the hand since the
lift. The tray's book of `tasks/return_book`.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.base import Base
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.physics.physics_backend import PhysicsBackend
from handcart.backends.registry import backend_class
from handcart.backends.simulation.books.book_props import BookProps
from handcart.backends.simulation.world_files.load_world import load_world
from handcart.robotics.geometry.transform import Transform, inverse, transform
from handcart.robotics.numerics.arrays import FloatArray

WORLD_FILE = Path(__file__).resolve().parents[2] / "tasks" / "return_book" / "world.yaml"
ROUND_S = 12.0  # of driving, after which the drive starts again
TURNS, DRIVES = 0.5, 0.2  # [rad/s], [m/s]
SWING_RAD = 0.3  # of the arm's first joint, to and fro [rad]


class Slid(NamedTuple):
    """Largest motion of the held object in the hand."""

    mm: float
    mrad: float


class HeldBook:
    """A robot with a book in its hand."""

    def __init__(self, kind: type[PhysicsBackend]) -> None:
        spec = load_robot("librarian")
        self.backend = kind(spec, load_world(WORLD_FILE), 0)
        self._base: Any = self._part(Base)
        self._arm: Any = self._part(Arm)
        self._gripper: Any = self._part(Gripper)
        model = self.backend.scene.arm
        assert model is not None
        self._model = model
        book = self.backend.scene.of(BookProps).tray_book()
        assert book is not None
        self.book = book

    def _part(self, kind: type[Any]) -> Any:
        return next(capability for capability in self.backend.capabilities() if isinstance(capability, kind))

    def take(self) -> None:
        """Grip the book on the tray by its spine, lift it, and let it come to rest."""
        spine = self.book.base_T_thing[:3, 3]
        for x, z in ((-0.10, 0.80), (-0.10, 0.70), (spine[0] - 0.12, 0.70)):
            self._line(np.array([x, spine[1], z]))
        self._gripper.move(0.0)
        self._wait(2.0)
        self._line(np.array([spine[0] - 0.12, spine[1], 0.80]))
        self._wait(1.0)
        self.stood = self.backend.scene.base
        """world_T_base when the driving began."""
        self._began, self._posture, self._driven = self._hand_T_book(), self._arm.command(), 0

    def drive(self, seconds: float) -> Slid:
        """Drive to and fro, and swing the arm; a second call continues at the end of the first."""
        worst = Slid(0.0, 0.0)
        for _ in range(round(seconds / self.backend.period)):
            self._driven += 1
            time = self._driven * self.backend.period
            turning = np.sin(2 * np.pi * time / ROUND_S)
            self._base.drive(DRIVES * np.sin(4 * np.pi * time / ROUND_S), TURNS * turning)
            swung = self._posture.copy()
            swung[0] += SWING_RAD * np.sin(2 * np.pi * time / ROUND_S)
            self._arm.move(swung)
            self.backend.step()
            now = self.slid()
            worst = Slid(max(worst.mm, now.mm), max(worst.mrad, now.mrad))
        return worst

    def slid(self) -> Slid:
        """Since the book was lifted."""
        off = inverse(self._began) @ self._hand_T_book()
        angle = np.arccos(np.clip((np.trace(off[:3, :3]) - 1) / 2, -1.0, 1.0))
        return Slid(1e3 * float(np.linalg.norm(off[:3, 3])), 1e3 * float(angle))

    def _hand_T_book(self) -> Transform:
        return np.asarray(inverse(self.backend.link_pose("hand")) @ self.book.pose)

    def _wait(self, seconds: float) -> None:
        for _ in range(round(seconds / self.backend.period)):
            self.backend.step()

    def _line(self, goal: FloatArray) -> None:
        """Move the hand straight, upright and pointing forward."""
        start = self._model.forward(self._arm.command())[:3, 3]
        for share in np.linspace(0.0, 1.0, max(2, int(np.linalg.norm(goal - start) / 0.004)) + 1)[1:]:
            joints = self._arm.command()
            near = self._model.inverse(transform(tuple(start + share * (goal - start))), joints, restarts=0)
            assert near is not None
            while not np.allclose(joints, near):
                joints = joints + np.clip(near - joints, -0.07, 0.07)
                self._arm.move(joints)
                self.backend.step()


def main() -> None:
    """Print a line every ten seconds."""
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("backend", nargs="?", default="mujoco")
    words.add_argument("seconds", nargs="?", type=int, default=60)
    wanted = words.parse_args()
    kind = backend_class(wanted.backend)
    assert issubclass(kind, PhysicsBackend)
    held = HeldBook(kind)
    held.take()
    print("after s   off mm   mrad, at most so far")
    worst = Slid(0.0, 0.0)
    for done in range(10, wanted.seconds + 1, 10):
        slid = held.drive(10.0)
        worst = Slid(max(worst.mm, slid.mm), max(worst.mrad, slid.mrad))
        print(f"{done:7d}  {worst.mm:7.4f}  {worst.mrad:5.3f}", flush=True)
    held.backend.close()


if __name__ == "__main__":
    main()
