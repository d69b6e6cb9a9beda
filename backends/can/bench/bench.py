"""A test bench: simulated drives, alone or in front of a simulated robot."""

from __future__ import annotations

from collections.abc import Callable

import can

from handcart.backends.backend import Backend
from handcart.backends.can.bus.can_line import CanLine
from handcart.backends.can.drives.axes import Axes
from handcart.backends.can.simulated.drive_node import DriveNode
from handcart.backends.can.simulated.simulated_drives import SimulatedDrives
from handcart.backends.description.can_spec import CanSpec
from handcart.backends.description.robot_file import RobotFile

from .backend_plant import BackendPlant
from .bench_bus import BenchBus

Act = Callable[["Bench", DriveNode], None]
"""Function that causes a fault of a drive or of the bus, given the bench and the drive."""


class Bench:
    """Simulated CAN drives of all axes of a robot, for work without hardware.

    Each SYNC advances the drives by one control period, and with them the simulated robot that they move, if
    there is one.
    """

    def __init__(
        self, robot: RobotFile, spec: CanSpec, inner: Backend | None, bus: can.BusABC | None = None
    ) -> None:
        """Set up the bench.

        Args:
            robot: the robot's file.
            spec: the section `can` of that file.
            inner: the simulated robot, owned by the bench from now on; None: motors without a load.
            bus: owned by the bench from now on; None: a virtual bus in this process, see `open`.
        """
        self.inner = inner
        """The simulated robot."""
        self.spec = spec
        axes = Axes(robot, spec)
        self._plant = plant = None if inner is None else BackendPlant(robot, spec, axes, inner)
        nodes = [axis.node for _, axis in spec.axes()]
        dictionaries = {axis.spec.node: axis.object_dictionary for axis in axes.values()}
        self._drives = SimulatedDrives(nodes, robot.period_s, plant, bus, dictionaries)
        if plant is not None:
            plant.place(self.drives)
        else:
            _place(axes, self.drives)
        self._drives.onlookers.append(self._inject_what_is_due)
        self._planned: list[tuple[float, Callable[[], None]]] = []
        self.master: BenchBus | None = None
        """The program's end of the bus, where it is in this process: it can fail, too."""

    @property
    def drives(self) -> dict[int, DriveNode]:
        """Simulated drives by node ID."""
        return self._drives.nodes

    @property
    def time(self) -> float:
        """Simulated time, in [s]."""
        return self._drives.time

    @property
    def line(self) -> CanLine:
        """The drives' end of the simulated CAN bus; a frame sent here reaches the program as if a drive had
        sent it.
        """
        return self._drives.line

    def open(self) -> BenchBus:
        """Return the connection to the simulated bus for the program that commands the drives."""
        self.master = BenchBus(self._drives.open())
        return self.master

    def serve(self) -> None:
        """Let the simulated drives process all frames that were sent to them, and send their answers."""
        self._drives.serve()

    def tick(self, seconds: float) -> None:
        """Advance the simulated drives by `seconds` [s] without a SYNC."""
        self._drives.tick(seconds)

    def stand_as_left(self, time: float) -> None:
        """Set the bench's time, in [s], and the drives' positions to those of the simulated robot.

        Called after the simulated world was restored from a checkpoint.
        """
        self._drives.time = time
        if self._plant is not None:
            self._plant.place(self.drives)

    def go_wrong(self, act: Act, node: int | None = None) -> None:
        """Cause a fault of a simulated drive, or of the bench's CAN bus, now.

        Args:
            act: function that causes the fault, called with the bench and the drive.
            node: node ID of the faulty drive; None: the drive of the first axis.
        """
        act(self, self.drives[self.spec.left.node if node is None else node])

    def go_wrong_at(self, at_s: float, act: Act, node: int | None = None) -> None:
        """Plan a fault, in addition to those planned before.

        Args:
            at_s: time of the bench at which the fault is caused, in [s]; if it is past, the fault is caused
                in the next period.
            act: function that causes the fault, called with the bench and the drive.
            node: node ID of the faulty drive; None: the drive of the first axis.
        """
        self._planned.append((at_s, lambda: self.go_wrong(act, node)))

    def _inject_what_is_due(self) -> None:
        due = [act for at, act in self._planned if at <= self.time + 1e-9]
        self._planned = [pair for pair in self._planned if pair[0] > self.time + 1e-9]
        for act in due:
            act()

    def close(self) -> None:
        """Close the bus and the simulated robot; a second call does nothing."""
        self._drives.close()
        if self.master is not None:
            self.master.shutdown()
        if self.inner is not None:
            self.inner.close()


def _place(axes: Axes, drives: dict[int, DriveNode]) -> None:
    """Set drives without a robot to positions within their limits."""
    for axis in axes.values():
        if axis.positioned:
            position = min(max(0.0, axis.limits.lower), axis.limits.upper)
            drives[axis.spec.node].stand_at(axis.units.counts(position))
