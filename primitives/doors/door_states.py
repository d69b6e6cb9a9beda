"""State of a door from the measured path of its handle, and its joint from that state."""

from __future__ import annotations

import math

import numpy as np

from handcart.backends.robot.robot import Robot
from handcart.primitives.objects.site.object_site import base_T_map
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform, inverse
from handcart.robotics.manipulation.doors.door_joint import DoorJoint
from handcart.robotics.manipulation.doors.path_fit import PathFit
from handcart.robotics.numerics.arrays import FloatArray

from .doors import DoorState, MeasuredHinge
from .pulling import Pull


def measured_joint(robot: Robot, state: DoorState, height: float) -> DoorJoint:
    """Return the hinge or slide, in the base frame, of a door from its measured state.

    Args:
        robot: the robot, whose pose on the map is used.
        state: state, on the map, that the robot measured when it last moved the door.
        height: height of the door's handle above the floor, in [m].
    """
    closed = np.asarray(base_T_map(robot) @ state.closed.lift(height))
    if state.hinge is None:
        return DoorJoint(closed, None, state.sign)
    there = Pose2(state.hinge.x, state.hinge.y, 0.0).relative_to(state.closed)
    return DoorJoint(closed, (there.x, there.y), state.sign)


def state_after(
    robot: Robot, name: str, joint: DoorJoint, pulled: Pull, span: tuple[float, float]
) -> DoorState:
    """Return the state of a door after the robot has moved its handle.

    Args:
        robot: robot at the place from which it moved the handle.
        name: name of the door.
        joint: hinge or slide in the base frame, as assumed before the motion.
        pulled: measured path of the handle.
        span: opening before the motion, and the wanted opening, in [rad] if the door is hinged, in [m] if it
            slides.
    """
    path, opens = pulled.path, 1.0 if span[1] > span[0] else -1.0
    if path.is_curved is None:
        opened = span[0] + opens * path.travel(pulled.point) / (joint.travel(1.0) or 1.0)
        return DoorState(name, "undetermined", opened, _on_map(robot, joint.closed), joint.sign)
    measured = _joint_of(path, joint.handle_at(span[0]), opens)
    before = span[0] if (joint.hinge is None) == (measured.hinge is None) else 0.0
    moved = abs(path.turned(pulled.point)) if path.is_curved else path.travel(pulled.point)
    opened = max(0.0, before + opens * moved)
    measured = measured.with_handle(joint.handle_at(span[0]), before)
    closed = _on_map(robot, measured.closed)
    if measured.hinge is None:
        return DoorState(name, "sliding", opened, closed, measured.sign)
    return DoorState(name, "hinged", opened, closed, measured.sign, _hinge_on_map(robot, path))


def _joint_of(path: PathFit, handle: Transform, opens: float) -> DoorJoint:
    """Return the joint that a measured path shows, as if the handle's pose (4, 4) at its begin were the
    closed one.
    """
    if path.is_curved:
        x, y, _ = (inverse(handle) @ np.append(path.hinge().point, 1.0))[:3].tolist()
        return DoorJoint(handle, (x, y), opens * math.copysign(1.0, path.curvature))
    ahead = float(handle[:3, 0] @ path.tangent(path.origin))
    return DoorJoint(handle, None, opens * math.copysign(1.0, ahead))


def _hinge_on_map(robot: Robot, path: PathFit) -> MeasuredHinge:
    hinge = path.hinge()
    (x, y), pose = hinge.point[:2].tolist(), robot.pose
    on_map: FloatArray = pose.apply(np.array([[x, y]]))[0]
    sigma = math.sqrt(float(np.linalg.eigvalsh(hinge.covariance).max()))
    return MeasuredHinge(float(on_map[0]), float(on_map[1]), sigma, hinge.radius, hinge.radius_sigma)


def _on_map(robot: Robot, base_T_handle: Transform) -> Pose2:
    x, y = base_T_handle[:2, 3].tolist()
    heading = math.atan2(base_T_handle[1, 0], base_T_handle[0, 0])
    return robot.pose.compose(Pose2(x, y, heading))
