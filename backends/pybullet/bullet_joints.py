"""Joints of the robot in Bullet."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from typing_extensions import override

from handcart.backends.physics.body.joint_group import JointGroup
from handcart.robotics.numerics.arrays import FloatArray

from .bullet_engine import BulletEngine


class BulletJoints(JointGroup):
    """Joints of a simulated robot in PyBullet that are moved by Bullet's motors.

    A motor of Bullet is a constraint on the joint's velocity with a limited impulse.
    """

    def __init__(self, engine: BulletEngine, body: int, joints: Sequence[int]) -> None:
        """Select joints of a body by Bullet's numbers."""
        self._p, self._client, self._substeps = engine.p, engine.client, engine.substeps
        self._body, self._joints = body, list(joints)

    @override
    def states(self) -> tuple[FloatArray, FloatArray]:
        read = self._p.getJointStates(self._body, self._joints, physicsClientId=self._client)
        return np.array([item[0] for item in read]), np.array([item[1] for item in read])

    @override
    def turn(self, speeds: FloatArray, most: FloatArray) -> None:
        self._p.setJointMotorControlArray(
            self._body,
            self._joints,
            self._p.VELOCITY_CONTROL,
            targetVelocities=speeds.tolist(),
            forces=(most / self._substeps).tolist(),
            physicsClientId=self._client,
        )

    @override
    def stand(
        self, positions: FloatArray, most: FloatArray, share: float, rates: FloatArray | None = None
    ) -> None:
        self._p.setJointMotorControlArray(
            self._body,
            self._joints,
            self._p.POSITION_CONTROL,
            targetPositions=positions.tolist(),
            forces=(most / self._substeps).tolist(),
            positionGains=[share] * len(self._joints),
            physicsClientId=self._client,
        )

    @override
    def push(self, torques: FloatArray) -> None:
        self._p.setJointMotorControlArray(
            self._body,
            self._joints,
            self._p.TORQUE_CONTROL,
            forces=torques.tolist(),
            physicsClientId=self._client,
        )
