"""All checks of a CAN bus together."""

from __future__ import annotations

from collections.abc import Callable

import can

from handcart.backends.can.bus.can_line import CanLine
from handcart.backends.can.drives.axes import Axes
from handcart.backends.description.can_spec import CanSpec

from .controller_watch import ControllerWatch
from .emergency_watch import EmergencyWatch
from .node_watch import NodeWatch
from .stranger_watch import StrangerWatch
from .traffic_watch import TrafficWatch
from .watch import Watch


class BusGuard:
    """Monitor of a CAN bus that combines detectors of single kinds of fault (`Watch`), and passes every frame
    to them.
    """

    def __init__(self, line: CanLine, axes: Axes, spec: CanSpec, clock: Callable[[], float]) -> None:
        """Begin to listen.

        Args:
            line: the network of the drives.
            axes: the watched axes.
            spec: the section `can` of the robot's file.
            clock: gives the time in [s].
        """
        self._clock = clock
        names = axes.names
        self._watches: tuple[Watch, ...] = (
            ControllerWatch(lambda: line.interface_state),
            StrangerWatch(names, spec.our_node),
            EmergencyWatch(names, spec.allowed_emergencies),
            NodeWatch(names, spec.heartbeat_timeout_ms / 1e3),
            traffic := TrafficWatch(
                1000 * spec.bitrate_kbit_s, lambda: line.malformed, lambda: line.last_malformed
            ),
        )
        self._traffic = traffic
        line.listen(self._hear)

    def begin(self) -> None:
        """Begin to check for faults, once the drives are enabled."""
        now = self._clock()
        for watch in self._watches:
            watch.begin(now)

    def end_set_up(self) -> None:
        """Forget the load of the frames that set up the drives.

        On a bench these frames all have the same time, and would count as load of one period.
        """
        self._traffic.begin(self._clock())

    def check(self) -> None:
        """Check the CAN bus by all detectors of faults (`Watch`); called once a period.

        Raises:
            CanFault: one of the detectors found a fault.
        """
        now = self._clock()
        for watch in self._watches:
            watch.check(now)

    def _hear(self, frame: can.Message, sent: bool) -> None:
        now = self._clock()
        for watch in self._watches:
            watch.hear(frame, sent, now)
