"""The gripper of the simulated robot."""

from __future__ import annotations

from typing import ClassVar

from handcart.backends.description.robot_file import GripperSpec
from handcart.backends.description.simulated_errors import Errors
from handcart.backends.pybullet.physics import Physics
from handcart.backends.simulation.body.simulated_parts import SimulatedGripper

from .robot_body import RobotBody

FINGERS = ("left_finger", "right_finger")
PRESSES = 3e-4  # commanded this far beyond where they stand, the fingers press [m]
AHEAD = 2e-3  # [m] that the drive's set-point runs into what the fingers press on: they open at once
STANDS = 3e-4  # [m] in a period: slower fingers stand
_GEAR_FORCE = 500.0  # with which the linkage keeps both fingers alike [N]


class BulletGripper(SimulatedGripper):
    """Two fingers with pads of rubber, one drive, and a linkage by which one mirrors the other."""

    STATE: ClassVar = {**SimulatedGripper.STATE, "_target": float, "_stood": float}

    def __init__(
        self, spec: GripperSpec, errors: Errors, body: RobotBody, physics: Physics, period: float, seed: int
    ) -> None:
        """Take the joints `left_finger` and `right_finger` over and open them."""
        opening = spec.opening_mm / 1e3
        super().__init__(spec, errors, opening, seed)
        self._body, self._physics = body, physics
        self._joints = [body.joint_index[name] for name in FINGERS]
        self._step = spec.speed_mm_s / 1e3 * period
        for name in FINGERS:
            body.reset(name, opening / 2)
        body.pad(FINGERS)
        self._target = self._stood = opening
        self._link()

    def _link(self) -> None:
        p, client = self._physics.p, self._physics.client
        gear = p.createConstraint(
            self._body.id,
            self._joints[0],
            self._body.id,
            self._joints[1],
            p.JOINT_GEAR,
            (0, 1, 0),
            (0, 0, 0),
            (0, 0, 0),
            physicsClientId=client,
        )
        p.changeConstraint(
            gear, gearRatio=-1, maxForce=_GEAR_FORCE / self._physics.substeps, erp=0.8, physicsClientId=client
        )

    def true_width(self) -> float:
        """See `SimulatedGripper`."""
        return float(self._body.states(self._joints)[0].sum())

    @property
    def opening(self) -> bool:
        """Whether it is told to open."""
        return self._command > self._target + PRESSES

    def begin(self, period: int) -> None:
        """A period begins."""
        self._now = period

    def act(self, share: float) -> None:
        """Command the drive for a chunk at whose end `share` of the period has passed."""
        way = max(-self._step, min(self._step, self._command - self._target))
        p = self._physics.p
        goal = (self._target + share * way) / 2
        p.setJointMotorControlArray(
            self._body.id,
            self._joints,
            p.POSITION_CONTROL,
            targetPositions=[goal, goal],
            forces=[self._spec.force_n / self._physics.substeps] * 2,
            positionGains=[0.3, 0.3],
            physicsClientId=self._physics.client,
        )

    def end(self) -> None:
        """A period has ended."""
        self._target += max(-self._step, min(self._step, self._command - self._target))
        width = self.true_width()
        self._target = max(self._target, width - AHEAD)
        stands = abs(width - self._stood) < STANDS
        self._pressing = stands and (self._target < width - PRESSES or self._target <= 0.0)
        self._stood = width
