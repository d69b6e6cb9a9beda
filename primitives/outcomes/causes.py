"""Causes that any primitive, or the framework around it, may have; domains declare theirs beside them."""

from __future__ import annotations

from typing import Final

from .cause_kind import CauseKind

# On the way of the base
BLOCKED: Final = CauseKind("blocked", "An obstacle is in the way of the base.")
NO_ROUTE: Final = CauseKind("no_route", "No route leads there, or the base does not fit there.")
NO_PROGRESS: Final = CauseKind("no_progress", "The base does not move as it is driven.")
OFF_GOAL: Final = CauseKind("off_goal", "The robot does not come to its goal within the tolerance.")
BASE_STOPPED: Final = CauseKind("base_stopped", "Something stops the base, or its drives are off.")

# Positions of the robot and of things
LOST: Final = CauseKind("lost", "The robot does not know where it is.")
DISPLACED: Final = CauseKind("displaced", "The robot was moved by others.")
UNDETERMINED: Final = CauseKind("undetermined", "The sensors do not determine a pose well enough.")
AMBIGUOUS: Final = CauseKind("ambiguous", "Several explanations of the readings are left.")
NOT_SEEN: Final = CauseKind("not_seen", "A sensor does not see what should be there.")
MISPLACED: Final = CauseKind("misplaced", "A thing is not where it should be.")
OCCUPIED: Final = CauseKind("occupied", "Something is where a thing is to be put down.")
NO_SUPPORT: Final = CauseKind("no_support", "Nothing is below a thing that is put down.")

# Arm and gripper
OUT_OF_REACH: Final = CauseKind("out_of_reach", "The arm does not reach its goal from here.")
NO_ARM_PATH: Final = CauseKind("no_arm_path", "The arm has no free path to its goal.")
ARM_BLOCKED: Final = CauseKind("arm_blocked", "Something stops the arm or what it holds.")
FINGERS_STUCK: Final = CauseKind("fingers_stuck", "The fingers do not open or close.")
NOT_HELD: Final = CauseKind("not_held", "The hand does not hold the thing that it should hold.")
SLIPPED: Final = CauseKind("slipped", "A thing slipped out of the hand.")

# Conditions before the start
NOT_KNOWN: Final = CauseKind("not_known", "Knowledge is missing that a file or an earlier action gives.")
UNSUITABLE: Final = CauseKind("unsuitable", "The robot has not the parts that are needed.")
PRECONDITION: Final = CauseKind("precondition", "A condition of the start is not met.")
REFUSED: Final = CauseKind("refused", "The operator did not permit the start.")

# Found by the framework
NO_REST: Final = CauseKind("no_rest", "The robot does not come to rest.")
NO_EFFECT: Final = CauseKind("no_effect", "The effect is not seen after the motion.")
NOT_FOLLOWING: Final = CauseKind("not_following", "A joint does not follow its commands.")
TIME_OUT: Final = CauseKind("time_out", "It takes too long.")
CANCELLED: Final = CauseKind("cancelled", "A person cancelled it.")
PREEMPTED: Final = CauseKind("preempted", "The tree around the network had something more urgent to do.")
NOT_ALONE: Final = CauseKind("not_alone", "Another primitive moves the robot at the same time.")

# Faults of machines and code
SENSOR_FAULT: Final = CauseKind("sensor_fault", "A sensor gives no readings, or none of use.")
ROBOT_FAULT: Final = CauseKind("robot_fault", "The robot reports a fault, or refuses a command.")
CODE_ERROR: Final = CauseKind("code_error", "An exception that is not an outcome: an error in the code.")
TREE_FAILED: Final = CauseKind("tree_failed", "A leaf of the primitive's behaviour tree fails.")
UNNAMED: Final = CauseKind("unnamed", "The primitive names no cause.")

OUTSIDE_CAUSES: Final = (CANCELLED, PREEMPTED, TIME_OUT, DISPLACED, ROBOT_FAULT, SENSOR_FAULT, CODE_ERROR)
"""Causes that an attempt may have whatever its primitive does: people, time limits, exceptions."""
FAULT_CAUSES: Final = (ROBOT_FAULT, SENSOR_FAULT, CODE_ERROR)
"""Faults of machines and code; they do not show that the motion itself was wrong, so it may be completed."""
