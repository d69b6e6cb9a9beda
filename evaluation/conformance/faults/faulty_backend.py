"""Any backend, with faults on purpose."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from itertools import product
from typing import Any

import numpy as np
from typing_extensions import override

from handcart.backends.backend import Backend, CommandError
from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.base import Base, WheelTravel
from handcart.backends.capabilities.capability import Capability, Reading
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.capabilities.scan import Scan
from handcart.backends.simulation.sensors.range_faults import RangeFaults
from handcart.evaluation.conformance.rig.numbers import broken
from handcart.evaluation.conformance.rig.parts import part_of
from handcart.evaluation.conformance.rig.periods import SETTLING_PERIODS
from handcart.evaluation.judging.survey import simulated_world
from handcart.evaluation.layers.layered_backend import Kind, LayeredBackend
from handcart.robotics.numerics.arrays import FloatArray

from .fault import Fault, FaultKind, all_sensors

LOST_ROLL_RATIO = 0.5  # share of the wheels' roll that is lost
LIDAR_FAULTS = RangeFaults(zero=0.05, nan=0.05, too_close=0.05, own_body=0.05)
SLIDING_SPEED_M_S = 0.1  # [m/s] of a standing car, see `Fault.speed`
SLIDING_SPEED_RATIOS = (1.0, 0.5, 0.25, 0.125)  # tried one after the other, until the base takes one


class InjectedError(RuntimeError):
    """Exception that the faulty backend raises on purpose."""


class FaultyBackend(LayeredBackend):
    """Wrapper of a backend that passes on all calls, and changes readings or commands by an injected fault.

    A fault lasts for as many control periods as it states. A joint that was stuck then catches up with its
    command by 0.02 rad a period.

    Attributes:
        bitten: number of readings or commands that the fault has changed; 0 means that it had no effect.
        asked: True while a primitive calls the backend; only then are exceptions injected.
    """

    def __init__(self, inner: Backend) -> None:
        super().__init__(inner)
        self.bitten, self.asked = 0, True
        self._fault: Fault | None = None
        self._left = 0
        self._stuck: Capability | None = None
        self._last: dict[tuple[int, str], Any] = {}
        self._read_once: set[str] = set()
        self._joints: FloatArray | None = None
        self._width: float | None = None
        self._hidden = np.zeros(3)
        self._driven = False

    def inject(self, fault: Fault) -> None:
        """Begin a fault, instead of the one injected before, for its number of periods."""
        self._fault, self._left = fault, fault.periods
        self._stuck = None

    @property
    def sensors_read(self) -> tuple[str, ...]:
        """Names of the sensors that were read so far."""
        return tuple(name for name in all_sensors() if name in self._read_once)

    def _slide(self, base: Base, fault: Fault) -> None:
        """Slide a base at rest; a base that cannot turn on the spot slides ahead or back instead.

        A base that refuses the speed, because it is slower, slides at half of it, and so on.
        """
        ways = [(fault.speed, fault.turn_rate)]
        if fault.turn_rate:
            ways.append((math.copysign(SLIDING_SPEED_M_S, fault.turn_rate), 0.0))
        for share, (speed, turn_rate) in product(SLIDING_SPEED_RATIOS, ways):
            with suppress(CommandError):
                base.drive(share * speed, share * turn_rate)
                return

    def stay(self) -> bool:
        """End an injected slip of the base; return whether it slid in the last `SETTLING_PERIODS` periods.

        Goals that a stuck arm or gripper has not reached are dropped, so that the fault moves nothing more.
        """
        slid = (
            self._fault is not None and self._fault.kind is FaultKind.SLIP and self._left > -SETTLING_PERIODS
        )
        self._left = min(0, self._left) if slid else self._left
        self._joints = self._width = None
        return slid

    @override
    def step(self) -> None:
        slips = self._is(FaultKind.SLIP)
        base = part_of(self.inner, Base) if slips else None
        before = base.wheel_travel() if base else WheelTravel(0.0, 0.0)
        if slips and base and not self._driven and self._fault:
            self._slide(base, self._fault)
        self._catch_up()
        if self._is(FaultKind.WORLD) and self._fault and self._fault.act:
            self._fault.act(simulated_world(self.inner))
            self.bitten += 1
        self.inner.step()
        if base:
            went = np.subtract(base.wheel_travel(), before)
            shown = went / (1.0 - LOST_ROLL_RATIO) if self._driven else 0.0
            self._hidden += shown - went
            self.bitten += bool(went.any())
        self._driven = False
        self._left -= 1

    def stop(self) -> None:
        """Stop the backend; commands that a stuck arm or gripper has not carried out are dropped."""
        self.inner.stop()
        self._joints = self._width = None
        self._driven = False

    # Commands

    @override
    def pass_on(self, part: Capability, kind: Kind, method: str, *words: Any) -> Any:
        take = partial(super().pass_on, part, kind, method, *words)
        reading = kind.READINGS.get(method)
        if reading is not None:
            return self._read(reading, (id(part), method), take)
        if method in kind.COMMANDS:
            self._call("")
        return take()

    def base_drive(self, base: Base, *command: float) -> None:
        """Pass a command on to the base, unless the injected fault is a blocked base (stop) or a slip (drive
        slower).
        """
        self._driven = True
        if self._sticks(base):
            base.drive(0.0, 0.0)
        elif self._is(FaultKind.SLIP):
            base.drive(*((1.0 - LOST_ROLL_RATIO) * rate for rate in command))
        else:
            base.drive(*command)

    def arm_move(self, arm: Arm, joints: FloatArray) -> None:
        """Pass on the arm's command (n,), in [rad] or [m], unless the injected fault makes the arm stick."""
        if self._sticks(arm) or self._joints is not None:
            self._joints = np.array(joints, dtype=np.float64)
        else:
            arm.move(joints)
            self._joints = None

    def arm_command(self, arm: Arm) -> FloatArray:
        """Return the joints (n,) last commanded, in [rad] or [m], even if the injected fault held back that
        command.
        """
        return arm.command() if self._joints is None else self._joints.copy()

    def gripper_move(self, gripper: Gripper, width: float) -> None:
        """Pass on the gripper's commanded width, in [m], unless the fault holds the gripper."""
        if self._sticks(gripper):
            self._width = float(width)
        else:
            gripper.move(width)
            self._width = None

    def gripper_command(self, gripper: Gripper) -> float:
        """Return the width last commanded, in [m], even if the fault held back the command."""
        return gripper.command() if self._width is None else self._width

    def _sticks(self, part: Capability) -> bool:
        if not self._is(FaultKind.STUCK):
            return False
        self._stuck = self._stuck or part
        if self._stuck is not part:
            return False
        self.bitten += 1
        return True

    def _catch_up(self) -> None:
        """Move released parts towards their last commands."""
        if self._is(FaultKind.STUCK):
            return
        gripper = part_of(self.inner, Gripper)
        if self._width is not None and gripper:
            gripper.move(self._width)
            self._width = None
        arm = part_of(self.inner, Arm)
        if self._joints is None or arm is None:
            return
        if self._goes_on(arm, self._joints - arm.command(), _STEP):
            self._joints = None

    def _goes_on(self, arm: Arm, way: FloatArray, step: float) -> bool:
        """Move the arm by `way` (n,), in [rad] or [m], but each joint at most by `step`; return whether that
        was all.

        The step is halved if a joint is too slow for it.
        """
        try:
            arm.move(arm.command() + np.clip(way, -step, step))
        except CommandError:
            return step > _LEAST and self._goes_on(arm, way, 0.5 * step)
        return float(np.abs(way).max()) <= step

    # Readings

    def base_wheel_travel(self, base: Base) -> WheelTravel:
        """Return the wheels' travel, falsified if the injected fault is a slip.

        During a slip, driven wheels report more travel than the base moves; a base that slides without a
        command reports no travel.
        """
        return WheelTravel(*np.add(base.wheel_travel(), self._hidden))

    def _read(self, reading: Reading, name: tuple[int, str], take: Callable[[], Any]) -> Any:
        self._call(reading.sensor)
        concerned = self._fault is not None and self._fault.sensor == reading.sensor
        if concerned and self._is(FaultKind.STALE) and name in self._last:
            self.bitten += 1
            return self._last[name]
        value = self._last[name] = take()
        self._read_once.add(reading.sensor)
        if concerned and self._is(FaultKind.NAN):
            self.bitten += 1
            return broken(value, reading.measured)
        if self._is(FaultKind.LIDAR) and isinstance(value, Scan):
            self.bitten += 1
            rng = np.random.default_rng(self._left)  # the same however often it is asked for in a period
            return value._replace(ranges=LIDAR_FAULTS.spoil(value.ranges, rng))
        return value

    def _call(self, sensor: str) -> None:
        """Raise the fault's exception if it concerns this sensor; an empty name stands for a command."""
        if not self.asked or self.bitten or self._fault is None:
            return
        if self._is(FaultKind.EXCEPTION) and self._fault.sensor == sensor:
            self.bitten += 1
            raise InjectedError("the backend broke")
        if self._is(FaultKind.REFUSED) and not sensor:
            self.bitten += 1
            raise CommandError("refused on purpose; allowed: nothing")

    def _is(self, kind: FaultKind) -> bool:
        return self._fault is not None and self._fault.kind is kind and self._left > 0


_STEP = 0.02  # [rad] or [m] a period that a joint catches up with
_LEAST = 1e-5  # the same: slower than any joint
