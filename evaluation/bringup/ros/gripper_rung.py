"""The step that checks the gripper's direction and scale."""

from __future__ import annotations

from typing_extensions import override

from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.ros2.ros_backend import RosBackend
from handcart.evaluation.bringup.operator import Held
from handcart.evaluation.bringup.rung import Facts, Rung, RungFailed

from .ros_site import RosSite

OPENING_RATIOS = (0.3, 0.6)
"""Openings that are tried, relative to the full one."""
SLACK_M, MAX_ERROR = 0.003, 0.1
SETTLE_S = 2.0


class GripperRung(Rung[RosSite]):
    """Step that opens the fingers to two widths, and compares command, reading and a ruler."""

    name = "gripper"
    summary = "the fingers at two widths: command, reading and a ruler agree"

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
        with site.backend() as backend:
            for share in OPENING_RATIOS:
                wanted = share * spec.opening_mm / 1e3
                with site.operator.hold("gripper: hold the space bar; letting go stops it") as held:
                    read = _open_to(backend, wanted, held)
                truth = backend.ground_truth()
                key = f"width_at_{100 * share:.0f}_percent_mm"
                question = f"How wide are the fingers open, by a ruler [mm]? (commanded: {1e3 * wanted:.0f})"
                measured = site.number(key, question, 0.0 if truth is None else 1e3 * truth.width) / 1e3
                _compare(wanted, read, measured)
                facts[f"{key[:-3]}_read_mm"] = round(1e3 * read, 1)
                facts[key] = round(1e3 * measured, 1)
        return facts


def _open_to(backend: RosBackend, width: float, held: Held) -> float:
    """Open the fingers to a width in [m], and return what is read at rest."""
    gripper = backend.get(Gripper)  # type: ignore[type-abstract]
    assert gripper is not None, "the robot's file has one"
    for _ in range(round(SETTLE_S / backend.period)):
        if not held():
            backend.stop()
            raise RungFailed("the key was let go before the motion was over")
        gripper.move(width)
        backend.step()
    return gripper.width()


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
