"""A robot without physics, with a real robot's errors."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from typing_extensions import override

from handcart.backends.description.ground_spec import GroundSpec
from handcart.backends.description.robot_file import ALL_DRIVE_KINDS, RobotFile
from handcart.backends.simulation.body.base_contact import move_base, touching_passers
from handcart.backends.simulation.body.hand import SimulatedHand
from handcart.backends.simulation.body.rough_ride import RoughRide
from handcart.backends.simulation.simulated_backend import ChangingPart, SimulatedBackend
from handcart.backends.simulation.world.suspension import lean_of
from handcart.backends.simulation.world.world_file import WorldFile
from handcart.robotics.geometry.pose2 import Pose2

from .kinematic_car import KinematicCar
from .kinematic_holonomic import KinematicHolonomicBase
from .kinematic_parts import KinematicArm, KinematicBase, KinematicGripper

KinematicWheels = KinematicBase | KinematicCar | KinematicHolonomicBase
LEVEL_GROUND = GroundSpec(roughness_deg=0.0)
"""Ground that a car drives on if the world's file has no ground."""


class KinematicBackend(SimulatedBackend):
    """Simulation of a mobile base with arm, gripper, camera and lidar among solid things, without dynamics.

    Simulated errors, drawn from the seed: radius of each wheel, tread, slip in each period, joint
    repeatability, the tilt of the base after the arm has swung, ranges, image noise, blur, light and lens,
    the force reading, and the places at which a person puts the robot and things.

    Differences from hardware:
    - No mass: wheels, joints and fingers follow their commands within the period; limits of speed are
      checked, those of acceleration are not. Nothing swings, tips or heats up.
    - Contacts are quasi-static. The base has the outline of its footprint, and stops with slipping wheels
      when it meets something. The arm stops where a contact begins; the force grows by 2 N per mm of further
      command, up to 60 N. The hand, or the held thing, slides along a surface on which it presses, with a
      coefficient of friction of 0.4. Collisions of the arm with itself and with its base are not detected.
      The base also stops where the arm, a part mounted above the base or a thing carried on it would hit
      something.
    - A gripped thing is centred in the hand and fixed to it: it neither slips nor sags, but a person who
      pulls harder than the fingers' friction holds can tear it out.
    - Rules of a thing's domain (`...simulation.world.props`) decide whether the thing gives way to the hand
      and where it ends up when released; by default it stays on the support right below it. Without a support
      it falls to the floor and is lost; nothing collides with it there.
    - Encoders have no bias. The camera is as in the robot's file, unless `errors` changes its mount or focal
      length.
    - Light has no shadows; the lidar ignores glass, mirrors and black lacquer.

    `scene` is ground truth: only evaluation may read it.
    """

    name = "kinematic"
    SIMULATIONS = ("kinematic", "scene")
    drive_kinds = ALL_DRIVE_KINDS
    _base: KinematicWheels
    _arm: KinematicArm | None
    _gripper: KinematicGripper | None

    def __init__(self, robot: RobotFile, world: WorldFile, seed: int) -> None:
        """Set robot and world up. The same seed gives the same run, bit for bit."""
        super().__init__(robot, world, seed)
        self.remarks = list(_not_simulated(world))
        self._base, self._ride = self._wheels(robot, world, seed)
        self._hand: SimulatedHand | None = None
        model = self.scene.arm
        if model is not None:
            self._hand = SimulatedHand(self.scene, model)
            self._arm = KinematicArm(robot, self._hand, seed)
            if robot.gripper is not None:
                self._gripper = KinematicGripper(robot.gripper, self._hand, self.period, seed)
        self._build_sensors(settled=False)
        self._build_sensors(settled=True)

    def _wheels(
        self, robot: RobotFile, world: WorldFile, seed: int
    ) -> tuple[KinematicWheels, RoughRide | None]:
        if robot.drive.kind == "holonomic":
            return KinematicHolonomicBase(robot, seed), None
        if robot.drive.kind != "ackermann":
            return KinematicBase(robot, seed), None
        ride = RoughRide(robot, world.ground or LEVEL_GROUND, seed)
        self.scene.lean_to(ride.tilt)
        return KinematicCar(robot, ride), ride

    @override
    def step(self) -> None:
        self._begin_period()
        motion = self._base.advance(self._periods)
        if (there := self._kidnapped_to()) is not None:
            self.scene.move_base(there)
            if self._hand is not None:
                self._hand.follow_base()
            motion = Pose2(0.0, 0.0, 0.0)
        if self._ride is not None:
            self.scene.lean_to(self._ride.tilt)
        touching = self._move_base(motion)
        fingers = self._gripper is not None and self._gripper.advance(self._periods)
        if self._arm is not None:
            touching |= self._arm.advance(self._periods, disturbed=fingers)
            self._lean()
            if self._arm.swung:
                self._move_base(Pose2(0.0, 0.0, self._arm.swing_yaw()))
        self._advance_sensors()
        self.scene.touch(touching | touching_passers(self.scene))

    def _move_base(self, motion: Pose2) -> frozenset[tuple[str, str]]:
        if motion == Pose2(0.0, 0.0, 0.0):
            return frozenset()
        touching = move_base(self.scene, motion, self._hand)
        if self._hand is not None:
            self._hand.follow_base()
        return touching

    def _lean(self) -> None:
        """Tilt the base on its suspension towards the hand."""
        rate = self.scene.robot.errors.lean_mrad_per_m
        if rate == 0.0 or self.scene.arm is None or self._hand is None:
            return
        x, y = self.scene.arm.forward(self.scene.joints)[:2, 3]
        self.scene.lean_to(lean_of((float(x), float(y)), rate))
        self._hand.follow_base()

    @override
    def set_state(self, state: object) -> None:
        super().set_state(state)
        if self._hand is not None:
            self._hand.forget_derived()

    def _own_parts(self) -> Mapping[str, ChangingPart | None]:
        rules = self._hand.rules if self._hand is not None else {}
        return {"ride": self._ride, **{f"rule {name}": rule for name, rule in rules.items()}}

    def close(self) -> None:
        """Do nothing, because there is nothing to release."""


def _not_simulated(world: WorldFile) -> Iterator[str]:
    """Yield a remark for each key of a world's file that needs a physics engine."""
    if world.camera == "engine":
        yield "camera: engine: without physics there is none; the scene's renderer draws what the camera sees"
    if world.ground is not None and world.ground.softness_mm_per_100n > 0.0:
        yield "ground: softness_mm_per_100n: without physics wheels don't sink in; the ground is as if hard"
