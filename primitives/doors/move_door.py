"""Common steps of opening and closing a door or drawer."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable, Generator, Sequence
from typing import ClassVar

import numpy as np
from pydantic import PrivateAttr
from typing_extensions import override

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.camera import AnyCamera
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.knowledge.meant_contact import MeantContact
from handcart.primitives.knowledge.world_model import ModelView, WorldModel
from handcart.primitives.motions.grip import close, holds, open_to, width_off
from handcart.primitives.motions.pushing import push
from handcart.primitives.objects.site.object_site import base_T_map
from handcart.primitives.objects.site.roomy_motion import move_with_room, surroundings_to_try
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured
from handcart.primitives.outcomes.exceeds import exceeds
from handcart.primitives.preconditions.hand_use import NEEDS_EMPTY
from handcart.primitives.restoring.retrace import retrace
from handcart.primitives.restoring.snapshot import Seen, Snapshot
from handcart.primitives.restoring.trace import Trace
from handcart.robotics.geometry.transform import Transform, inverse, transform
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.manipulation.doors.door_joint import DoorJoint
from handcart.robotics.manipulation.doors.path_fit import PathFit, PathPrior
from handcart.robotics.numerics.arrays import FloatArray

from .door_look import LocatedHandle, find_handle
from .door_names import DoorName, front_in_world, handle_in_world
from .door_states import measured_joint
from .doors import Doors, DoorState
from .doors_file import UNKNOWN_RADIUS_M, KnownDoor
from .handle_grasp import APPROACH_M, PlannedHandle, plan_handle
from .pulling import Pull, PullEnding, measured_bias, pull, yield_to_force

GRASP_SPEED_M_S = 0.06
GRASP_TOUCH_FORCE_N = 6.0
BAR_WIDTH_TOLERANCE_M = 0.003
CURVATURE_SIGMA_PER_M = 1.5  # of a believed path: a door may be a drawer
HEADING_SIGMA_RAD = 0.2
SLOPE_SIGMA = 0.02
MAX_OFF_M = 0.12  # of a handle from where it is known to be
MAX_LET_GO_M = 0.015  # of a handle from where the hand let it go
MAX_RESTORING_FORCE_N = 45.0
OVER_PERIODS = 4
MAX_JOINT_ERROR_RAD = 0.05  # of a joint from its command: a hand that pulls bends the arm


class MoveDoor(ActionPrimitive):
    """Base class of the primitives that take the handle of a door or drawer and open or close it."""

    door: DoorName
    """Name of the door or drawer."""
    stow: bool = True
    """Bring the arm home in the end, as it must be before the base drives away."""

    needs: ClassVar = (Arm, Gripper, AnyCamera)
    reads: ClassVar = ("map", "sensed_cells", "doors", "objects", "sightings", "held_object")
    writes: ClassVar = ("door_states",)
    hand: ClassVar = NEEDS_EMPTY
    max_joint_error: ClassVar = MAX_JOINT_ERROR_RAD

    _start: LocatedHandle | None = PrivateAttr(default=None)
    _why_unseen: Discrepancy | None = PrivateAttr(default=None)
    _held: bool = PrivateAttr(default=False)
    _done: bool = PrivateAttr(default=False)
    _states_before: tuple[DoorState, ...] | None = PrivateAttr(default=None)
    _over: int = PrivateAttr(default=0)
    _bias: FloatArray = PrivateAttr(default_factory=lambda: np.zeros(3))

    @abstractmethod
    def expected_opening(self, model: ModelView) -> float:
        """Return the present opening of the door by the model, in [rad] if hinged, in [m] if sliding."""

    @abstractmethod
    def span(self, model: ModelView, joint: DoorJoint, seen: Transform) -> tuple[float, float]:
        """Return the present and the wanted opening of the door, in [rad] if hinged, in [m] if sliding.

        Args:
            model: world model.
            joint: assumed hinge or slide of the door, in the base frame.
            seen: (4, 4) measured pose of the handle, in the base frame.
        """

    @abstractmethod
    def move_handle(
        self, robot: Robot, model: ModelView, joint: DoorJoint, span: tuple[float, float], grip: FloatArray
    ) -> Generator[None, None, tuple[Pull, DoorState]]:
        """Move the held handle, check how far it went, and return its path and the state of the door.

        Args:
            robot: robot whose hand holds the handle.
            model: world model.
            joint: assumed hinge or slide of the door, in the base frame.
            span: present and wanted opening, in [rad] if hinged, in [m] if sliding.
            grip: (3,) middle of the handle's bar in the frame of the hand, in [m].
        """

    @override
    def unmet_precondition(self, robot: Robot, model: ModelView) -> str:
        known = model.of(Doors).doors.doors
        return "" if self.door in known else f"unknown door {self.door!r}"

    def known(self, model: ModelView) -> KnownDoor:
        """Return the door that this action moves, as the file of doors describes it."""
        return model.of(Doors).doors.doors[self.door]

    def believed_joint(self, robot: Robot, model: ModelView) -> DoorJoint:
        """Return the door's hinge or slide in the base frame.

        The measured hinge or slide is returned if the robot has moved the door before, otherwise that in the
        file of doors.
        """
        door, state = self.known(model), model.of(Doors).state_of(self.door)
        if state is not None and state.motion != "undetermined":
            return measured_joint(robot, state, door.handle.height_m)
        radius = door.radius_m or UNKNOWN_RADIUS_M
        return door.joint(np.asarray(base_T_map(robot) @ door.handle.pose), radius)

    @override
    def observe(self, robot: Robot, model: ModelView) -> Generator[None, None, Seen]:
        """Return the measured position of the handle in the base frame, in [m], under the door's name.

        The result is empty if the handle is not seen.
        """
        if self.door not in model.of(Doors).doors.doors:
            return {}
        joint = self.believed_joint(robot, model)
        expected = joint.handle_at(self.expected_opening(model)) if self._start is None else self._start[0]
        try:
            found = yield from self._look(robot, model, joint, expected)
        except Discrepancy as why:
            self._why_unseen = why
            return {}
        if self._start is None:
            self._start = found
        x, y, z = found.base_T_handle[:3, 3].tolist()
        return {self.door: (x, y, z)}

    @override
    def motion(self, robot: Robot, model: ModelView) -> Periods:
        door = self.known(model)
        if self._start is None:
            raise self._why_unseen or Discrepancy(f"{self.door} isn't seen", cause=causes.NOT_SEEN)
        seen = self._start.base_T_handle
        believed = self.believed_joint(robot, model)
        self._check_place(believed, seen)
        span = self.span(model, believed, seen)
        joint = believed.with_handle(seen, span[0])
        plan = yield from self._planned(robot, model, door, joint, span)
        grip = yield from self._take_handle(robot, model, door, joint, plan, span)
        pulled, state = yield from self.move_handle(robot, model, joint, span, grip)
        yield from self._let_go(robot)
        left_at = yield from self._check_stays(robot, model, joint, pulled)
        self._states_before = model.of(Doors).door_states
        model.of(Doors).note(state)
        if self.stow:
            home, swept = np.array(robot.spec.posture("home")), model.of(Doors).swept_areas()
            front = self._front(model, joint, left_at)
            yield from move_with_room(robot, model, home, also_around=(front,), open_areas=swept)
        self._done = True

    @override
    def watch(self, robot: Robot, model: ModelView) -> None:
        """Raise a Discrepancy if the handle slips out of the hand, or something holds the hand back."""
        if self._held and not robot.gripper.closed_on_something():
            slipped = Measured("Gripper", "opening", 1e3 * robot.gripper.width(), unit="mm")
            raise Discrepancy("the handle slipped out of the hand", measured=slipped, cause=causes.SLIPPED)
        force = float(np.linalg.norm(robot.arm.hand_force()))
        self._over = self._over + 1 if force > MAX_RESTORING_FORCE_N else 0
        if self._over >= OVER_PERIODS:
            felt = Measured("Arm", "force on the hand", force, MAX_RESTORING_FORCE_N, "N")
            raise Discrepancy("something holds the hand back", measured=felt, cause=causes.ARM_BLOCKED)

    @override
    def effect(self, robot: Robot, model: ModelView) -> Generator[None, None, bool]:
        """Return whether the door was moved as wanted, and the fingers press on nothing."""
        return self._done and not robot.gripper.closed_on_something()
        yield

    @override
    def meant_contacts(self, model: WorldModel) -> Sequence[MeantContact]:
        """Return the intended contacts of the hand, which are with the door's handle and its front."""
        return MeantContact("hand", handle_in_world(self.door)), MeantContact(
            "hand", front_in_world(self.door)
        )

    @override
    def restore(self, robot: Robot, model: ModelView, start: Snapshot, trace: Trace) -> Periods:
        """Repeat the robot's motions backwards, which moves the door back before the fingers open."""
        self._held = False
        yield from retrace(robot, start, trace)
        if self._states_before is not None:
            model.of(Doors).door_states = self._states_before

    def prior(self, joint: DoorJoint, span: tuple[float, float]) -> PathPrior:
        """Return the expected direction and curvature of the handle's path, with their uncertainty.

        The path begins at the handle's present position; directions are in the base frame.

        Args:
            joint: assumed hinge or slide of the door, in the base frame.
            span: present and wanted opening, in [rad] if hinged, in [m] if sliding.
        """
        opens = 1.0 if span[1] > span[0] else -1.0
        heading = joint.heading(span[0]) + (0.0 if opens > 0.0 else math.pi)
        curvature = opens * joint.curvature()
        return PathPrior(heading, HEADING_SIGMA_RAD, curvature, CURVATURE_SIGMA_PER_M, SLOPE_SIGMA)

    def _front(self, model: ModelView, joint: DoorJoint, base_T_handle: Transform) -> Box:
        """Return the front of the door, in the base frame."""
        middle, size = self.known(model).front(joint)
        return Box(np.asarray(base_T_handle @ middle), size, front_in_world(self.door))

    def _look(
        self, robot: Robot, model: ModelView, joint: DoorJoint, expected: Transform
    ) -> Generator[None, None, LocatedHandle]:
        front, door = self._front(model, joint, expected), self.known(model)
        return (yield from find_handle(robot, model, self.door, door, expected, front, self.evidence))

    def _check_place(self, believed: DoorJoint, seen: Transform) -> None:
        """Raise `Discrepancy` if a handle seen at base_T_handle (4, 4) is far from the file's place of it, at
        any opening.
        """
        known = believed.handle_at(believed.opening_at(seen[:3, 3]))
        off = float(np.linalg.norm(known[:3, 3] - seen[:3, 3]))
        self.found(handle_off_mm=round(1e3 * off, 1))
        if exceeds(off, MAX_OFF_M):
            apart = Measured("Camera", "handle off its place", 1e3 * off, 1e3 * MAX_OFF_M, "mm")
            raise Discrepancy(
                f"the handle of {self.door} isn't where it should be", measured=apart, cause=causes.MISPLACED
            )

    def _planned(
        self, robot: Robot, model: ModelView, door: KnownDoor, joint: DoorJoint, span: tuple[float, float]
    ) -> Generator[None, None, PlannedHandle]:
        seen = joint.handle_at(span[0])
        front, swept = self._front(model, joint, seen), model.of(Doors).swept_areas()
        for bodies in surroundings_to_try(robot, model, open_areas=swept):
            plan = yield from robot.compute(plan_handle, robot, door, seen, joint, span, front, bodies)
            if plan is not None and plan.reach == 1.0:
                break
        if plan is None:
            raise Discrepancy(f"the handle of {self.door} is out of reach", cause=causes.OUT_OF_REACH)
        if plan.reach < 1.0:
            share = Measured("Arm", "share of the path within reach", plan.reach, 1.0)
            raise Discrepancy(
                f"the arm can't move {self.door} so far from here", measured=share, cause=causes.OUT_OF_REACH
            )
        self.found(lever_mm=round(1e3 * plan.lever))
        return plan

    def _take_handle(
        self,
        robot: Robot,
        model: ModelView,
        door: KnownDoor,
        joint: DoorJoint,
        plan: PlannedHandle,
        span: tuple[float, float],
    ) -> Generator[None, None, FloatArray]:
        """Take the handle; return the middle (3,) of the bar in the frame of the hand, in [m]."""
        front, swept = self._front(model, joint, joint.handle_at(span[0])), model.of(Doors).swept_areas()
        yield from open_to(robot)
        yield from move_with_room(robot, model, plan.before, also_around=(front,), open_areas=swept)
        self._bias = yield from measured_bias(robot)
        pushed = yield from push(robot, plan.base_T_grip, GRASP_SPEED_M_S, GRASP_TOUCH_FORCE_N)
        if pushed.met:
            felt = Measured("Arm", "force that resists the hand", pushed.force, GRASP_TOUCH_FORCE_N, "N")
            raise Discrepancy("the hand runs into something", measured=felt, cause=causes.ARM_BLOCKED)
        yield from self.intend(f"the fingers close on the handle of {self.door}")
        yield from close(robot)
        if not holds(robot, door.handle.width, BAR_WIDTH_TOLERANCE_M):
            off = width_off(robot, door.handle.width, BAR_WIDTH_TOLERANCE_M, "the bar's width")
            raise Discrepancy("the fingers don't hold the handle", measured=off, cause=causes.NOT_HELD)
        self._held = True
        yield from yield_to_force(robot, self._bias)
        middle = inverse(plan.base_T_grip) @ joint.handle_at(span[0])[:, 3]
        return np.array([middle[0], 0.0, middle[2]])

    def pull_along(
        self,
        robot: Robot,
        joint: DoorJoint,
        span: tuple[float, float],
        grip: FloatArray,
        is_there: Callable[[PathFit, FloatArray], bool],
    ) -> Generator[None, None, Pull]:
        """Move the held handle along its path; record force, travel and hinge for the journal.

        Args:
            robot: robot whose hand holds the handle.
            joint: assumed hinge or slide of the door, in the base frame.
            span: present and wanted opening, in [rad] if hinged, in [m] if sliding.
            grip: (3,) middle of the handle's bar in the frame of the hand, in [m].
            is_there: function that returns whether the handle has moved far enough, given the measured path
                and the middle (3,) of the bar in the base frame, in [m].

        Raises:
            Discrepancy: the arm does not get far enough.
        """
        pulled = yield from pull(robot, grip, self.prior(joint, span), is_there, self._bias)
        path = pulled.path
        self.found(
            force_n=round(pulled.max_force, 1),
            travel_mm=round(1e3 * path.travel(pulled.point), 1),
            path_rms_mm=round(1e3 * path.rms, 2),
        )
        if path.is_curved:
            hinge = path.hinge()
            x, y, z = hinge.point.tolist()
            self.found(
                hinge_x_m=round(x, 4),
                hinge_y_m=round(y, 4),
                hinge_z_m=round(z, 4),
                hinge_sigma_mm=round(1e3 * math.sqrt(float(np.linalg.eigvalsh(hinge.covariance).max())), 1),
                axis_x=round(float(hinge.axis[0]), 5),
                axis_y=round(float(hinge.axis[1]), 5),
                axis_sigma_deg=round(math.degrees(hinge.axis_sigma), 2),
                turned_deg=round(math.degrees(abs(path.turned(pulled.point))), 2),
                radius_mm=round(1e3 * hinge.radius, 1),
                radius_sigma_mm=round(1e3 * hinge.radius_sigma, 1),
            )
        if pulled.ending is PullEnding.OUT_OF_REACH:
            raise Discrepancy(f"the arm can't move {self.door} further", cause=causes.OUT_OF_REACH)
        return pulled

    def _let_go(self, robot: Robot) -> Periods:
        yield from self.intend(f"the fingers let the handle of {self.door} go")
        self._held = False
        yield from open_to(robot)
        back = np.asarray(robot.base_T("hand") @ transform((-APPROACH_M, 0.0, 0.0)))
        pushed = yield from push(robot, back, GRASP_SPEED_M_S, GRASP_TOUCH_FORCE_N)
        if pushed.met:
            felt = Measured("Arm", "force that holds the hand", pushed.force, GRASP_TOUCH_FORCE_N, "N")
            raise Discrepancy("the hand doesn't come off the handle", measured=felt, cause=causes.ARM_BLOCKED)

    def _check_stays(
        self, robot: Robot, model: ModelView, joint: DoorJoint, pulled: Pull
    ) -> Generator[None, None, Transform]:
        """Look again; return base_T_handle (4, 4) where the hand let it go: the handle must be there."""
        turned = pulled.path.turned(pulled.point) if pulled.path.is_curved else 0.0
        assert self._start is not None
        expected = transform(rpy=(0.0, 0.0, turned)) @ self._start.base_T_handle
        expected[:3, 3] = pulled.point
        found = yield from self._look(robot, model, joint, np.asarray(expected))
        off = float(np.linalg.norm(found.base_T_handle[:2, 3] - pulled.point[:2]))
        self.found(let_go_off_mm=round(1e3 * off, 1))
        if exceeds(off, MAX_LET_GO_M):
            apart = Measured("Camera", "handle off where it was let go", 1e3 * off, 1e3 * MAX_LET_GO_M, "mm")
            raise Discrepancy(f"{self.door} doesn't stay", measured=apart, cause=causes.MISPLACED)
        return np.asarray(expected)
