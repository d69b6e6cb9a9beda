"""Doubtful facts of a URDF's joints: limits in other units, followers driven beyond their limits."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from handcart.robotics.kinematics.urdf_reading import UrdfElement, UrdfFault

MAX_TURN_RAD = 4.0 * math.pi
"""Angle of two turns; larger limits are likely to be in degrees."""
MAX_TRAVEL_M = 20.0
"""Travel; larger limits are likely to be in millimetres."""
_ROUNDING = 1e-3  # by which makers round limits [rad] or [m]
_MAX_CHAIN = 100  # joints that mimic each other

Range = tuple[float, float]


def joint_doubts(joints: Mapping[str, UrdfElement]) -> Iterator[UrdfFault]:
    """Yield faults for joint limits that are probably in degrees or millimetres instead of [rad] and [m], and
    for mimicking joints whose leaders can move them beyond their limits.

    Args:
        joints: joints by name, of a URDF without other faults.
    """
    for name, joint in joints.items():
        limits = _limits(joint)
        if limits is None:
            continue
        lower, upper = limits
        turns = joint.get("type") == "revolute"
        farthest = max(abs(lower), abs(upper))
        limit = joint.find("limit")
        assert isinstance(limit, UrdfElement)
        if farthest > (MAX_TURN_RAD if turns else MAX_TRAVEL_M) + _ROUNDING:
            wrong = "rad, more than two turns; degrees? needed: radians" if turns else "m; mm? needed: metres"
            yield _mild(limit, f"joint {name!r}: its limits are {lower:g} to {upper:g} {wrong}")
        yield from _mimic_doubt(name, joint, limits, joints)


def _mimic_doubt(
    name: str, joint: UrdfElement, limits: Range, joints: Mapping[str, UrdfElement]
) -> Iterator[UrdfFault]:
    mimic = joint.find("mimic")
    driven = _driven(joint, joints)
    if not isinstance(mimic, UrdfElement) or driven is None:
        return
    if driven[0] < limits[0] - _ROUNDING or driven[1] > limits[1] + _ROUNDING:
        unit = "m" if joint.get("type") == "prismatic" else "rad"
        goes = f"{mimic.get('joint')!r} drives it from {driven[0]:.4g} to {driven[1]:.4g} {unit}"
        allowed = f"its own limits, {limits[0]:.4g} to {limits[1]:.4g} {unit}"
        yield _mild(mimic, f"joint {name!r}: {goes}; allowed: {allowed}")


def _driven(joint: UrdfElement, joints: Mapping[str, UrdfElement]) -> Range | None:
    """Return the range over which the joint's leader drives it, through chains too; None if unlimited."""
    factor, offset = 1.0, 0.0
    for _ in range(_MAX_CHAIN):
        mimic = joint.find("mimic")
        if mimic is None or mimic.get("joint") not in joints:
            break
        offset += factor * float(mimic.get("offset", "0"))
        factor *= float(mimic.get("multiplier", "1"))
        joint = joints[mimic.get("joint", "")]
    limits = _limits(joint)
    if limits is None:
        return None
    ends = sorted(factor * end + offset for end in limits)
    return ends[0], ends[1]


def _limits(joint: UrdfElement) -> Range | None:
    limit = joint.find("limit")
    if limit is None or joint.get("type") not in ("revolute", "prismatic"):
        return None
    return float(limit.get("lower", "0")), float(limit.get("upper", "0"))


def _mild(element: UrdfElement, message: str) -> UrdfFault:
    return element.fault(message)._replace(mild=True)
