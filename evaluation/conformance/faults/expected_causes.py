"""Causes that an injected fault may lead to, by its kind and the affected sensor."""

from __future__ import annotations

from collections.abc import Mapping

from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.cause_kind import CauseKind

from .fault import Fault, FaultKind

POSE_CAUSES = (causes.LOST, causes.DISPLACED, causes.UNDETERMINED, causes.OFF_GOAL, causes.NO_REST)
"""Causes that concern the pose of the base, or whether it rests."""
CAUSES_OF_SENSORS: Mapping[str, tuple[CauseKind, ...]] = {
    "wheels": (*POSE_CAUSES, causes.BASE_STOPPED, causes.NO_PROGRESS),
    "joints": (causes.NOT_FOLLOWING, causes.ARM_BLOCKED, causes.NO_REST, causes.OFF_GOAL, causes.NO_ARM_PATH),
    "force": (causes.ARM_BLOCKED, causes.OCCUPIED, causes.NO_SUPPORT, causes.NO_REST),
    "width": (causes.FINGERS_STUCK, causes.NOT_HELD, causes.SLIPPED, causes.PRECONDITION, causes.NO_REST),
    "range": (*POSE_CAUSES, causes.NOT_SEEN, causes.AMBIGUOUS, causes.BLOCKED, causes.NO_ROUTE),
    "camera": (causes.NOT_SEEN, causes.AMBIGUOUS, causes.MISPLACED),
    "depth camera": (causes.NOT_SEEN, causes.AMBIGUOUS, causes.MISPLACED),
    "imu": (*POSE_CAUSES, causes.MISPLACED),
    "gps": POSE_CAUSES,
    "beacons": POSE_CAUSES,
    "positioning": POSE_CAUSES,
    "battery": (),
}
"""Causes that wrong readings of a sensor may suggest."""
UNSEEN_CAUSES = (causes.SENSOR_FAULT, causes.NO_EFFECT)
"""Causes of a Fail because a sensor is known to be wrong, or does not show the effect."""
CAUSES_OF_FAULTS: Mapping[FaultKind, tuple[CauseKind, ...]] = {
    FaultKind.EXCEPTION: (causes.CODE_ERROR,),
    FaultKind.REFUSED: (causes.ROBOT_FAULT,),
    FaultKind.STUCK: (
        *(causes.BASE_STOPPED, causes.NO_PROGRESS, causes.NOT_FOLLOWING, causes.ARM_BLOCKED),
        *(causes.FINGERS_STUCK, causes.NOT_HELD, causes.OFF_GOAL, causes.NO_EFFECT),
    ),
    FaultKind.SLIP: (
        *(*POSE_CAUSES, causes.BASE_STOPPED, causes.NO_PROGRESS),
        *(causes.NOT_SEEN, causes.MISPLACED, causes.NO_EFFECT),
    ),
    FaultKind.CANCEL: (causes.CANCELLED,),
    FaultKind.TIME_OUT: (causes.TIME_OUT,),
    FaultKind.LIDAR: (*CAUSES_OF_SENSORS["range"], *UNSEEN_CAUSES),
}
"""Causes that an actuator, a person or an exception may lead to, whichever sensor finds it."""
FALSIFIED_KINDS = (FaultKind.STALE, FaultKind.NAN)


def expected_causes(fault: Fault) -> tuple[str, ...]:
    """Return the causes that a Fail or GiveUp after a fault may name; empty if any cause is allowed.

    A fault that an application domain declares has its own list of causes.
    """
    found = fault.causes or CAUSES_OF_FAULTS.get(fault.kind, ())
    if fault.kind in FALSIFIED_KINDS:
        found = (*CAUSES_OF_SENSORS.get(fault.sensor, ()), *UNSEEN_CAUSES)
    return tuple(item.name for item in found)
