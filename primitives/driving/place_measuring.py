"""Measurement, before the base drives up to a place, of the thing that the place was computed for."""

from __future__ import annotations

from collections.abc import Callable

from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import Periods
from handcart.primitives.knowledge.place import Place
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.robotics.geometry.pose2 import Pose2

MEASURING_DISTANCE_M = 0.35  # before the place: more than what it belongs to may have come towards it


def measure_place(
    robot: Robot,
    model: ModelView,
    name: str,
    drive: Callable[[Place], Periods],
    report: Callable[..., None],
) -> Periods:
    """Measure the object to which a place belongs, from a stop before the place, and move the place with the
    object.

    Nothing happens if the object cannot have moved or was measured before, or if a detour was planned. If
    there is no room for the stop, no way leads there, or the base is nearer to the place already, the robot
    measures from its present pose.

    Args:
        robot: the robot.
        model: world model with the place.
        name: name of the place.
        drive: function that drives to a place, used for the stop.
        report: function that receives metrics of the measurement.
    """
    has_detour = model.detour is not None and model.detour.goal == name
    measuring = None if has_detour else model.measuring(robot, name, report)
    if measuring is None:
        return
    place = model.places[name]
    before = place.pose.compose(Pose2(-MEASURING_DISTANCE_M, 0.0, 0.0))
    if robot.pose.distance(place.pose) > MEASURING_DISTANCE_M:
        try:
            yield from drive(place.model_copy(update={"x_m": before.x, "y_m": before.y}))
        except Discrepancy as no_room:
            if no_room.cause is not causes.NO_ROUTE:
                raise
    yield from measuring


def until_blocked(
    drive: Periods, robot: Robot, since: Callable[[], float | None], patience: float
) -> Periods:
    """Drive as long as a way leads on.

    Args:
        drive: the drive, period by period.
        robot: the robot.
        since: function that returns the time since which no way leads on, in [s]; None while one does.
        patience: time without a way, in [s], after which the drive ends.
    """
    for _ in drive:
        begin = since()
        if begin is not None and robot.time >= begin + patience:
            drive.close()
            return
        yield
