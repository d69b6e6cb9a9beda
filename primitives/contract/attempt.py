"""One attempt of a primitive: supervision, restoring and outcome, the same for all primitives."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Generator
from dataclasses import replace
from typing import NamedTuple, TypeVar

from handcart.backends.robot.robot import Robot
from handcart.primitives.knowledge.bumps import keep_off_bumps, note_bump
from handcart.primitives.knowledge.world_model import ModelView, WorldModel
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.cause import FRAMEWORK_MODULES, Cause, kind_of
from handcart.primitives.outcomes.cause_kind import CauseKind
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured, NeedsPerson
from handcart.primitives.outcomes.outcome import Fail, GiveUp, Outcome, Success, fail_if_restored
from handcart.primitives.outcomes.residual import NOT_MOVED
from handcart.primitives.restoring.arm_command import rejoin
from handcart.primitives.restoring.back_off import back_off
from handcart.primitives.restoring.patience import NO_PATIENCE, Patience
from handcart.primitives.restoring.retrace import reach_again, retrace
from handcart.primitives.restoring.snapshot import (
    Seen,
    Snapshot,
    residuals,
    settle,
    take_snapshot,
    take_snapshot_since_start,
)
from handcart.primitives.restoring.trace import Trace
from handcart.robotics.navigation.following.blocked_motion import Blocked
from handcart.robotics.numerics.arrays import FloatArray

from .action_primitive import ActionPrimitive, Periods
from .halt import halt
from .intents import UNRECORDED_INTENTS, Intents
from .standstill_monitor import StandstillMonitor
from .tracking_error_monitor import TrackingErrorMonitor
from .unmet import check_hand, find_unmet, note_hand

T = TypeVar("T")
FRAMEWORK_MODULES.add(__name__)

RESTORE_MAX_TRIES = 2  # times that restoring is tried before a person is called
LONGEST_RESTORE = 600.0  # [s]
STUCK_TRAVEL_M = 0.01  # minimum travel that counts for a restoring base
RESTLESS_REASON = "the robot doesn't come to rest before the start"
PUSHED_REASON = "the base was moved while it stood"
NOT_ALONE = "another primitive moves the robot at the same time"


def attempt(
    primitive: ActionPrimitive,
    robot: Robot,
    model: WorldModel,
    on_restore: Callable[[str], None] = lambda reason: None,
    intents: Intents = UNRECORDED_INTENTS,
    patience: Patience = NO_PATIENCE,
    is_checked: bool = False,
) -> Generator[None, None, Outcome]:
    """Run a primitive to its outcome; one `yield` is one period, after which the caller steps the robot.

    After a `Discrepancy`, the robot stops, restores, waits for rest and measures. The outcome is Fail if the
    state then equals the snapshot from before the motion, within tolerances, and GiveUp otherwise. To cancel
    an attempt, the caller throws a `Discrepancy` into the generator.

    Args:
        primitive: a new instance with all its parameters.
        robot: the robot, at rest.
        model: world model; the primitive has access only to the entries that it declares.
        on_restore: called with the reason when restoring begins.
        intents: receiver of the primitive's announcements; no command is sent before they are stored.
        patience: limits on repeating the restoring if a fault breaks it off.
        is_checked: True if the preconditions were checked just now. They are checked again only if the robot
            has to come to rest first.
    """
    if primitive.only_knowledge:
        return (yield from _think(primitive, robot, model, is_checked))
    view = model.view(primitive)
    primitive._intents, displaced = intents, robot.localization.displacements
    try:
        while not intents.kept:
            yield
        rests = yield from settle(robot)
        if unmet := find_unmet(primitive, robot, model):
            raise Discrepancy(unmet, check="precondition", cause=causes.PRECONDITION)
        start = _begun(robot)
        keep_off_bumps(robot, model)
        robot.base.starts_here()
    except Exception as early:  # nothing was commanded yet
        robot.stop()
        primitive.evidence.blame(early)
        return fail_if_restored(_words(early), getattr(early, "permanent", False), NOT_MOVED, kind_of(early))
    if not rests or robot.localization.displacements > displaced:
        robot.stop()
        return _not_begun(primitive, robot, rests)
    trace, known = Trace(robot), (model.bumps, model.arm_bumps)
    try:
        start = replace(start, seen=(yield from _recorded(primitive.observe(robot, view), trace)))
        yield from _watched(primitive, primitive.motion(robot, view), robot, model, trace)
        if not (yield from settle(robot)):
            raise Discrepancy("the robot doesn't come to rest", check="rest", cause=causes.NO_REST)
        if not (yield from _recorded(primitive.effect(robot, view), trace)):
            raise Discrepancy(
                "success is not confirmed: the effect is not seen", check="effect", cause=causes.NO_EFFECT
            )
        yield from _recorded(check_hand(primitive, robot, model, start.holding), trace)
        robot.localization.look_again()
        _check_not_pushed(robot, displaced)
        return Success(dict(primitive.facts), primitive.evidence.result)
    except NeedsPerson as need:
        primitive.evidence.blame(need)
        yield from halt(robot)
        return GiveUp(need.reason, cause=need.cause)
    except Discrepancy as discrepancy:
        primitive.evidence.blame(discrepancy)
        failure = _Failure(discrepancy.reason, discrepancy.permanent, discrepancy.cause, known)
    except Exception as error:  # a fault of the primitive's own code is restored from like any other
        primitive.evidence.blame(error)
        failure = _Failure(_words(error), False, kind_of(error), known)
        primitive.found(traceback=traceback.format_exc())
    robot.stop()
    on_restore(failure.reason)
    if primitive._no_return is not None:
        return (yield from _finish(primitive, robot, model, failure, displaced, patience))
    return (yield from _restore(primitive, robot, model, start, trace, failure, patience))


def _begun(robot: Robot) -> Snapshot:
    """Return the robot's state at the start, with the base's pose before the first of several Fails in a row.

    With the current pose, errors within the tolerance would add up.
    """
    now, first = take_snapshot(robot, {}), robot.failed_from
    robot.failed_from = None
    if first is not None:
        start = replace(now, pose=first)
        if not residuals(start, take_snapshot_since_start(robot, {}), robot.spec).moved:
            return start
    robot.localization.set_origin()
    return now


def _not_begun(primitive: ActionPrimitive, robot: Robot, rests: bool) -> GiveUp:
    """Return the GiveUp of a primitive that could not begin: the robot does not rest, or was pushed."""
    pushed = Cause(pushed_reason(robot), "push", kind=causes.DISPLACED)
    cause = pushed if rests else Cause(RESTLESS_REASON, "rest", kind=causes.NO_REST)
    primitive.evidence.causes.append(cause)
    return GiveUp(cause.reason, cause=cause.kind)


def _think(
    primitive: ActionPrimitive, robot: Robot, model: WorldModel, is_checked: bool
) -> Generator[None, None, Outcome]:
    """Attempt a primitive that only changes knowledge: nothing moves, so nothing has to be restored."""
    try:
        if not is_checked and (unmet := find_unmet(primitive, robot, model)):
            raise Discrepancy(unmet, check="precondition", cause=causes.PRECONDITION)
        yield from primitive.motion(robot, model.view(primitive))
        return Success(dict(primitive.facts), primitive.evidence.result)
    except NeedsPerson as need:
        primitive.evidence.blame(need)
        return GiveUp(need.reason, cause=need.cause)
    except Discrepancy as discrepancy:
        primitive.evidence.blame(discrepancy)
        reason, permanent = discrepancy.reason, discrepancy.permanent
        return fail_if_restored(reason, permanent, NOT_MOVED, discrepancy.cause)
    except Exception as error:  # a fault of the primitive's own code
        primitive.evidence.blame(error)
        primitive.found(traceback=traceback.format_exc())
        return fail_if_restored(_words(error), False, NOT_MOVED, kind_of(error))


def _recorded(periods: Generator[None, None, T], trace: Trace) -> Generator[None, None, T]:
    """Run the periods, and record each of them for the way back."""
    trace.record()
    while True:
        try:
            next(periods)
        except StopIteration as end:
            value: T = end.value
            return value
        yield
        trace.record()


def _watched(
    primitive: ActionPrimitive, periods: Periods, robot: Robot, model: WorldModel, trace: Trace
) -> Periods:
    """Run the motion, watched every period; record it for the way back, up to the point of no return."""
    trace.record()
    tracking, displaced = (
        TrackingErrorMonitor(robot, primitive.max_joint_error),
        robot.localization.displacements,
    )
    view = model.view(primitive)
    for _ in periods:
        _alone(robot, primitive)
        yield
        if primitive._no_return is None:
            trace.record()
        tracking.check()
        _check_not_pushed(robot, displaced)
        note_bump(robot, model, primitive.evidence)
        primitive.watch(robot, view)


class _Failure(NamedTuple):
    """Reason why a motion was broken off."""

    reason: str
    permanent: bool
    cause: CauseKind
    bumps_before: tuple[FloatArray, FloatArray]
    """`bumps` and `arm_bumps` of the world model when the motion began."""


def _finish(
    primitive: ActionPrimitive,
    robot: Robot,
    model: WorldModel,
    failure: _Failure,
    displaced: int,
    patience: Patience,
) -> Generator[None, None, Success | GiveUp]:
    """Withdraw, as often as `patience` allows; what happened can't be undone.

    After a fault of a machine or of code it is a Success if the effect was measured on the way. Otherwise a
    person has to look.
    """
    reason, is_measured = failure.reason, False
    for left in range(patience.attempts - 1, -1, -1):
        try:
            is_measured = bool((yield from primitive.finish(robot, model.view(primitive))))
            is_measured &= failure.cause in causes.FAULT_CAUSES and (yield from settle(robot))
            _check_not_pushed(robot, displaced)
            break
        except Exception as error:
            primitive.evidence.blame(error, restoring=True)
            is_measured = False
            if not left or isinstance(error, NeedsPerson) or getattr(error, "permanent", False):
                reason = f"{reason}; and withdrawing: {_words(error)}"
                break
        yield from halt(robot)
        yield from robot.wait(patience.wait_s)
    if is_measured:
        primitive.found(finished_after=failure.reason)
        note_hand(primitive, model)
        robot.localization.look_again()
        return Success(dict(primitive.facts), primitive.evidence.result)
    yield from halt(robot)
    return GiveUp(f"{reason}; after a point of no return ({primitive._no_return})", cause=failure.cause)


def _restore(
    primitive: ActionPrimitive,
    robot: Robot,
    model: WorldModel,
    start: Snapshot,
    trace: Trace,
    failure: _Failure,
    patience: Patience,
) -> Generator[None, None, Fail | GiveUp]:
    """Restore until nothing breaks it off, as often as `patience` allows, and judge what was reached.

    The robot holds in between. The next try begins where the last one ended: nothing is moved towards the
    goal of the motion, and nothing that was put back is touched. Where the base was stopped on its way back,
    it tries to pass again: a drive that refuses to move looks like an obstacle. A base that could move
    neither on nor back was held by its drives: no obstacle is remembered there.
    """
    for left in range(patience.attempts - 1, -1, -1):
        back, known, place = Trace(robot), (model.bumps, model.arm_bumps), robot.localization.odometry_pose
        try:
            return (yield from _restore_once(primitive, robot, model, start, trace, failure, back))
        except Exception as error:
            primitive.evidence.blame(error, restoring=True)
            yield from halt(robot)
            if not left or isinstance(error, NeedsPerson) or getattr(error, "permanent", False):
                return GiveUp(f"{failure.reason}; and restoring failed: {_words(error)}", cause=failure.cause)
        yield from robot.wait(patience.wait_s)
        trace = trace.left_after(back)
        is_stuck = robot.localization.odometry_pose.distance(place) < STUCK_TRAVEL_M
        model.bumps, model.arm_bumps = failure.bumps_before if is_stuck else known
        keep_off_bumps(robot, model, returns=True)
    raise AssertionError("restoring is tried at least once")


def _restore_once(
    primitive: ActionPrimitive,
    robot: Robot,
    model: WorldModel,
    start: Snapshot,
    trace: Trace,
    failure: _Failure,
    back: Trace,
) -> Generator[None, None, Fail | GiveUp]:
    """Restore, wait for rest, measure, compare with the absolute snapshot; record the motion in `back`.

    Raises:
        Exception: a fault broke it off. No second restore is tried on top of it here.
    """
    verdict: Fail | GiveUp = GiveUp(failure.reason, cause=failure.cause)
    view, blocked = model.view(primitive), robot.progress.blocked
    for again in range(RESTORE_MAX_TRIES):
        room = primitive.base_room(robot, view)
        restore = _way_back(primitive.restore(robot, view, start, trace), robot, blocked, trace)
        way_back = reach_again(robot, start, model, room) if again else restore
        yield from _recorded(_within_time(way_back, robot, primitive, model), back)
        yield from settle(robot)
        seen = (yield from _look_again(primitive, robot, view, start)) if start.seen else {}
        now = take_snapshot_since_start(robot, seen)
        found = residuals(start, now, robot.spec, room)
        verdict = fail_if_restored(failure.reason, failure.permanent, found, failure.cause)
        if isinstance(verdict, Fail):
            robot.failed_from = start.pose
            robot.stop()
            return verdict
    yield from halt(robot)
    return verdict


def _way_back(restore: Periods, robot: Robot, blocked: Blocked | None, trace: Trace) -> Periods:
    """Restore as the primitive does; a base that was stopped by an obstacle first leaves it."""
    if trace.is_rest:
        yield from rejoin(robot, trace.moments[-1])
    if blocked is not None:
        yield from back_off(robot, blocked, trace)
        trace.cut_to(robot)
    yield from restore


def _look_again(
    primitive: ActionPrimitive, robot: Robot, view: ModelView, start: Snapshot
) -> Generator[None, None, Seen]:
    """Measure the objects once more; undo the motion that this took."""
    trace = Trace(robot)
    seen = yield from _recorded(primitive.observe(robot, view), trace)
    yield from retrace(robot, start, trace)
    yield from settle(robot)
    return seen


def _within_time(way_back: Periods, robot: Robot, primitive: ActionPrimitive, model: WorldModel) -> Periods:
    displaced, view = robot.localization.displacements, model.view(primitive)
    for _ in settle(robot):  # an arm that turns back at once jerks the base, and objects on it slide
        _alone(robot, primitive)
        yield
    end, tracking = robot.time + LONGEST_RESTORE, TrackingErrorMonitor(robot, primitive.max_joint_error)
    standstill = StandstillMonitor(robot)
    for _ in way_back:
        _alone(robot, primitive)
        yield
        if robot.localization.lifted is not None:
            raise _pushed(robot)
        tracking.check()
        standstill.check()
        _check_not_pushed(robot, displaced)
        note_bump(robot, model, primitive.evidence)
        primitive.watch(robot, view)
        if robot.time > end:
            why = "" if robot.held is None else f": {robot.held.words}"
            raise Discrepancy(f"restoring takes too long{why}", check="time", cause=causes.TIME_OUT)


def pushed_reason(robot: Robot) -> str:
    """Return the reason of a GiveUp after somebody lifted or pushed the base."""
    lifted = robot.localization.lifted
    return PUSHED_REASON if lifted is None else f"the robot doesn't know where it is: {lifted.why}"


def _check_not_pushed(robot: Robot, displaced: int) -> None:
    """Raise `NeedsPerson` if others moved the base since its `displacements` were `displaced`."""
    if robot.localization.displacements > displaced:
        raise _pushed(robot)


def _pushed(robot: Robot) -> NeedsPerson:
    """Return the exception for a base that was moved by others."""
    lifted = robot.localization.lifted
    measured = None if lifted is None else Measured(*lifted[1:])
    return NeedsPerson(pushed_reason(robot), measured, check="push", cause=causes.DISPLACED)


def _alone(robot: Robot, primitive: ActionPrimitive) -> None:
    """Check, once a period, that no other attempt moves the robot; two at once both give up (row N12)."""
    if not robot.moved_by(primitive):
        raise NeedsPerson(NOT_ALONE, check="robot", cause=causes.NOT_ALONE)


def _words(error: Exception) -> str:
    words = getattr(error, "reason", None) or str(error)
    return words if isinstance(error, Discrepancy | NeedsPerson) else f"{type(error).__name__}: {words}"
