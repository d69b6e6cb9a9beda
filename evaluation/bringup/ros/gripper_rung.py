"""The step that checks the gripper's direction, scale and latency."""

from __future__ import annotations

import math

from typing_extensions import override

from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.description.robot_file import GripperSpec
from handcart.backends.ros2.ros_backend import RosBackend
from handcart.evaluation.bringup.operator import Held
from handcart.evaluation.bringup.rung import Facts, Rung, RungFailed

from .ros_site import RosSite

OPENING_RATIOS = (0.3, 0.6)
"""Openings that are tried, relative to the full one."""
SLACK_M, MAX_ERROR = 0.003, 0.1
SETTLE_S = 2.0
MOVED_M = 0.001
"""Change of the width from which the fingers move."""


class GripperRung(Rung[RosSite]):
    """Bring-up step that opens the fingers to two widths, and compares the command, the measured width, and
    the width that a person reads from a ruler.
    """

    name = "gripper"
    summary = "the fingers at two widths: command, reading and a ruler agree, and the fingers follow in time"

    @override
    def left_out(self, site: RosSite) -> str:
        return "" if site.robot.gripper is not None else "the robot has no gripper"

    @override
    def climb(self, site: RosSite) -> Facts:
        spec = site.robot.gripper
        assert spec is not None, "left out otherwise"
        if not site.confirm("empty", "Is nothing between the fingers, and no hand near them?"):
            raise RungFailed("something was between the fingers")
        facts: Facts = {}
        latencies = []
        with site.backend() as backend:
            for share in OPENING_RATIOS:
                wanted = share * spec.opening_mm / 1e3
                with site.operator.hold("gripper: hold the space bar; letting go stops it") as held:
                    read, latency = _open_to(backend, wanted, spec, held)
                truth = backend.ground_truth()
                key = f"width_at_{100 * share:.0f}_percent_mm"
                question = f"How wide are the fingers open, by a ruler [mm]? (commanded: {1e3 * wanted:.0f})"
                measured = site.number(key, question, 0.0 if truth is None else 1e3 * truth.width) / 1e3
                _compare(wanted, read, measured)
                facts[f"{key[:-3]}_read_mm"] = round(1e3 * read, 1)
                facts[key] = round(1e3 * measured, 1)
                latencies += [] if math.isnan(latency) else [latency]
        if latencies:
            facts["latency_s"] = round(max(latencies), 3)
            _check_latency(site, max(latencies))
        return facts


def _open_to(backend: RosBackend, width: float, spec: GripperSpec, held: Held) -> tuple[float, float]:
    """Open the fingers to a width in [m], and wait until they are at rest by their speed.

    A reading beyond the opening is in the wrong unit; no motion takes longer than all of the opening.

    Returns:
        The width in [m] that is read at rest, and the time in [s] from the command until the reading moved;
        NaN if it never did.
    """
    gripper = backend.get(Gripper)  # type: ignore[type-abstract]
    assert gripper is not None, "the robot's file has one"
    begun, latency = gripper.width(), math.nan
    seconds = min(abs(width - begun), spec.opening_mm / 1e3) / (spec.speed_mm_s / 1e3) + SETTLE_S
    for number in range(round(seconds / backend.period)):
        if not held():
            backend.stop()
            raise RungFailed("the key was let go before the motion was over")
        gripper.move(width)
        backend.step()
        if math.isnan(latency) and abs(gripper.width() - begun) > MOVED_M:
            latency = (number + 1) * backend.period
    return gripper.width(), latency


def _check_latency(site: RosSite, latency_s: float) -> None:
    """Raise `RungFailed` if the fingers follow so late that, not having moved yet, they count as pressing."""
    assert site.robot.ros2 is not None, "a site of ROS has one"
    rest_ms = site.robot.ros2.gripper.rest_ms
    if 1e3 * latency_s > rest_ms + 1e-6:
        raise RungFailed(
            f"gripper: its reading follows {latency_s:.2f} s after the command; allowed: {rest_ms / 1e3:.2f}"
            " s (`rest_ms`): until then fingers at rest count as pressing on something; raise `rest_ms`"
        )


def _compare(wanted: float, read: float, measured: float) -> None:
    """Raise `RungFailed` unless command, reading and ruler agree, in [m]."""
    allowed = SLACK_M + MAX_ERROR * wanted
    command = f"{1e3 * wanted:.0f} mm were commanded"
    if abs(measured - wanted) > allowed:
        raise RungFailed(
            f"gripper: {command}, the fingers are {1e3 * measured:.1f} mm open;"
            " are `open` and `closed` right?"
        )
    if abs(read - wanted) > allowed:
        raise RungFailed(
            f"gripper: {command}, {1e3 * read:.1f} mm are read; allowed: {1e3 * allowed:.0f} mm apart"
        )
