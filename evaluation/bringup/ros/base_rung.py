"""The step that checks the base's directions and units: cmd_vel, odometry and a tape must agree."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

from typing_extensions import override

from handcart.evaluation.bringup.rung import Facts, Rung, RungFailed

from .driving import SPEED_M_S, TURN_DEG_S, DriveTrial, Motion, drive
from .ros_site import RosSite
from .scan_turn import check_side, scan_of
from .unit_words import unit_hint

DRIVE_S = 2.0
NO_TURN_WORDS = "which way round the lidar counts isn't determined: this base doesn't turn on the spot"
MAX_ODOMETRY_ERROR = 0.15
"""Share by which odometry and tape may differ."""
MAX_COMMAND_ERROR = 0.4
"""Share by which the commanded and the real motion may differ: ramps, friction."""


class BaseAxis(NamedTuple):
    """Test motion of the base along or about one axis, with the question for the operator who measures it."""

    name: str
    """Field of `Motion`."""
    speeds: Motion
    question: str
    unit: str
    shown: float
    """Factor from [m] or [rad] to the unit of the question."""
    slack: float
    """Error of a person's measurement, in [m] or [rad]."""


class BaseRung(Rung[RosSite]):
    """Bring-up step that moves the base a little along each axis and checks that measurements agree.

    It compares command, odometry, lidar and the operator's tape measure.
    """

    name = "base"
    summary = (
        "forward, to the left and turning left, a little each: cmd_vel, odometry, a tape and the lidar agree"
    )

    @override
    def climb(self, site: RosSite) -> Facts:
        if not site.confirm("clear", "Is the way clear for 0.5 m around the base?"):
            raise RungFailed("the way wasn't clear")
        facts: Facts = {}
        with site.backend() as backend:
            for axis in _axes(site):
                words = f"{axis.name}: hold the space bar; letting go stops it"
                before = scan_of(backend)
                with site.operator.hold(words) as held:
                    done = drive(site, backend, held, axis.speeds, DRIVE_S)
                truth = axis.shown * getattr(done.true, axis.name)
                measured = site.number(f"{axis.name}_{axis.unit}", axis.question, truth) / axis.shown
                _compare(site, axis, done, measured)
                if axis.name == "turn" and before is not None:
                    if axis.speeds.forward:
                        site.operator.tell(f"   {NO_TURN_WORDS}")
                    else:
                        check_side(site, before, scan_of(backend), measured)
                    facts["lidar_turn_checked"] = not axis.speeds.forward
                odometry = axis.shown * getattr(done.measured, axis.name)
                facts[f"{axis.name}_{axis.unit}"] = round(axis.shown * measured, 2)
                facts[f"{axis.name}_by_odometry_{axis.unit}"] = round(odometry, 2)
                facts[f"{axis.name}_latency_s"] = round(done.latency_s, 3)
        return facts


def _axes(site: RosSite) -> Iterator[BaseAxis]:
    drive_spec = site.robot.drive
    speed = min(SPEED_M_S, drive_spec.top_speed_m_s)
    turn = min(math.radians(TURN_DEG_S), math.radians(drive_spec.top_turn_deg_s))
    ahead = "How far did the base drive forward, by tape [mm]? (backward: negative)"
    yield BaseAxis("forward", Motion(speed, 0.0, 0.0), ahead, "mm", 1e3, 0.005)
    if drive_spec.kind == "holonomic":
        aside = "How far did the base drive to its left, by tape [mm]? (right: negative)"
        yield BaseAxis(
            "sideways", Motion(0.0, min(speed, drive_spec.top_sideways), 0.0), aside, "mm", 1e3, 0.005
        )
    turned = "By how much did the base turn to the left [deg]? (right: negative)"
    if drive_spec.kind == "ackermann":
        curved = Motion(speed, 0.0, 0.5 * drive_spec.sharpest_per_m * speed)
        yield BaseAxis("turn", curved, turned, "deg", math.degrees(1.0), math.radians(2.0))
    else:
        yield BaseAxis("turn", Motion(0.0, 0.0, turn), turned, "deg", math.degrees(1.0), math.radians(2.0))


def _compare(site: RosSite, axis: BaseAxis, done: DriveTrial, measured: float) -> None:
    """Raise `RungFailed` unless command, odometry and the person's measurement agree."""
    asked, read = getattr(done.commanded, axis.name), getattr(done.measured, axis.name)
    shown = f"{axis.shown * measured:.3g} {axis.unit}"
    _agree(
        f"{site.spec.velocity.topic} ({axis.name}): {axis.shown * asked:.3g} {axis.unit} were commanded,"
        f" the base moved {shown}",
        asked,
        measured,
        MAX_COMMAND_ERROR * abs(asked) + axis.slack,
    )
    _agree(
        f"{site.spec.odometry.topic} ({axis.name}): the odometry says {axis.shown * read:.3g} {axis.unit},"
        f" the base moved {shown}",
        read,
        measured,
        MAX_ODOMETRY_ERROR * abs(measured) + axis.slack,
    )


def _agree(words: str, one: float, other: float, allowed: float) -> None:
    if abs(one - other) > allowed:
        raise RungFailed(f"{words}; {unit_hint(one, other)}")
