"""The gripper of the simulated robot."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from typing_extensions import override

from handcart.backends.description.robot_file import GripperSpec
from handcart.backends.description.simulated_errors import Errors
from handcart.backends.physics.engine.surface import ContactSurface
from handcart.backends.simulation.body.simulated_parts import SimulatedGripper

from .robot_body import RobotBody

FINGER_JOINTS = ("left_finger", "right_finger")
PRESSING_LEAD_M = 3e-4  # [m] of command beyond their position from which the fingers press
# [m] that the drive's set-point runs into what the fingers press on: they open at once
MAX_SET_POINT_LEAD_M = 2e-3
STILL_TRAVEL_M = 3e-4  # [m] in a period: slower fingers are at rest
FINGER_STEP_RATIO = 0.3  # of the way to where they belong that the fingers make in a step of the solver


class PhysicsGripper(SimulatedGripper):
    """Gripper in a physics engine, whose two fingers have rubber pads and are coupled to one drive."""

    STATE: ClassVar = {**SimulatedGripper.STATE, "_target": float, "_stood": float}

    def __init__(
        self,
        spec: GripperSpec,
        errors: Errors,
        body: RobotBody,
        pads: ContactSurface,
        period: float,
        seed: int,
    ) -> None:
        """Take over the joints `left_finger` and `right_finger`, and open the fingers at once.

        Args:
            spec: section of the gripper in the robot's file.
            errors: simulated errors of the robot's file.
            body: the robot in an engine.
            pads: contact surface of the fingers.
            period: control period, in [s].
            seed: seed of the reading's errors.
        """
        opening = spec.opening_mm / 1e3
        super().__init__(spec, errors, opening, seed)
        self._joints = body.joints(FINGER_JOINTS)
        self._most = np.full(len(FINGER_JOINTS), spec.force_n)
        self._step, self._period = spec.speed_mm_s / 1e3 * period, period
        for name in FINGER_JOINTS:
            body.reset(name, opening / 2)
        body.cover(FINGER_JOINTS, pads)
        self._target = self._stood = opening
        body.mirror(FINGER_JOINTS)

    @override
    def true_width(self) -> float:
        return float(self._joints.states()[0].sum())

    @property
    def opening(self) -> bool:
        """True if the gripper is commanded to open."""
        return self._command > self._target + PRESSING_LEAD_M

    def begin(self, period: int) -> None:
        """Start the control period with the number `period`, to which later readings and commands belong."""
        self._now = period

    def act(self, share: float) -> None:
        """Command the drives of the simulated fingers for the next of several parts of a control period.

        Args:
            share: share of the period, 0 to 1, that will have passed at the end of this part.
        """
        way = max(-self._step, min(self._step, self._command - self._target))
        goal = (self._target + share * way) / 2
        rate = way / (2 * self._period)
        self._joints.stand(np.array([goal, goal]), self._most, FINGER_STEP_RATIO, np.array([rate, rate]))

    def end(self) -> None:
        """End a control period: advance the opening's set-point towards the command, and record whether the
        fingers press on something.
        """
        self._target += max(-self._step, min(self._step, self._command - self._target))
        width = self.true_width()
        self._target = max(self._target, width - MAX_SET_POINT_LEAD_M)
        stands = abs(width - self._stood) < STILL_TRAVEL_M
        self._pressing = stands and (self._target < width - PRESSING_LEAD_M or self._target <= 0.0)
        self._stood = width
