"""The step that measures how long the base keeps its last speeds when this program is silent."""

from __future__ import annotations

from typing_extensions import override

from handcart.backends.ros2.ros_backend import RosBackend
from handcart.evaluation.bringup.rung import Facts, Rung, RungFailed

from .driving import SPEED_M_S, base_of, moved
from .ros_site import RosSite

MAX_KEPT_S = 0.5
"""Longest time for which a base may keep its last speeds without a new command, in [s]."""
WATCH_S = 3.0
KEPT_SHARE, REST_SHARE = 0.7, 0.1
"""Shares of the driven speed above which the base keeps it, and below which the base is at rest."""
DRIVE_S = 1.5


class SilenceRung(Rung[RosSite]):
    """Bring-up step that measures how soon the slowly driving base stops when commands are no longer sent."""

    name = "silence"
    summary = f"the base stops by itself within {MAX_KEPT_S:g} s when no command comes"

    @override
    def climb(self, site: RosSite) -> Facts:
        speed = min(SPEED_M_S, site.robot.drive.top_speed_m_s)
        room = speed * (DRIVE_S + WATCH_S)
        question = f"Is the way clear for {room:.1f} m ahead and behind, and a hand at the emergency stop?"
        if not site.confirm("clear", question):
            raise RungFailed("the way wasn't clear")
        with site.backend() as backend:
            self._drive(site, backend, speed)
            speeds = self._watch(site, backend)
            backend.stop()
            backend.step()
        kept = _last_above(speeds, KEPT_SHARE * speed) * site.robot.period_s
        rest = _last_above(speeds, REST_SHARE * speed) * site.robot.period_s
        facts: Facts = {"speed_m_s": round(speed, 3), "kept_s": round(kept, 3), "rest_s": round(rest, 3)}
        if kept > MAX_KEPT_S:
            more = "longer than" if kept >= WATCH_S - site.robot.period_s else "for"
            raise RungFailed(
                f"{site.spec.velocity.topic}: without a command the base keeps its last speeds {more}"
                f" {kept:.2f} s; allowed: {MAX_KEPT_S:g} s (cmd_vel_timeout of its controller)"
            )
        if not site.confirm("stopped", "Did the base stop by itself, and did nobody press anything?"):
            raise RungFailed("the base was stopped by somebody, or its odometry reports a stop that wasn't")
        return facts

    def _drive(self, site: RosSite, backend: RosBackend, speed: float) -> None:
        """Drive straight on until the odometry shows the speed."""
        base, reached = base_of(backend), 0.0
        with site.operator.hold("hold the space bar: the base drives straight on") as held:
            for _ in range(round(DRIVE_S / backend.period)):
                if not held():
                    backend.stop()
                    raise RungFailed("the key was let go before the motion was over")
                before = base.wheel_travel()
                base.drive(speed, 0.0)
                backend.step()
                step = abs(moved(site, before, base.wheel_travel()).forward)
                reached = max(reached, step / backend.period)
        if reached < 0.5 * speed:
            backend.stop()
            backend.step()
            raise RungFailed(
                f"{site.spec.odometry.topic}: at {speed:.2f} m/s the odometry shows {reached:.3g} m/s"
            )

    def _watch(self, site: RosSite, backend: RosBackend) -> list[float]:
        """Return the speed in [m/s] of each period in which nothing is sent."""
        base, speeds = base_of(backend), []
        for _ in range(round(WATCH_S / backend.period)):
            before = base.wheel_travel()
            backend.watch()
            speeds.append(abs(moved(site, before, base.wheel_travel()).forward) / backend.period)
        return speeds


def _last_above(speeds: list[float], limit: float) -> int:
    """Return the number of periods until all further speeds are at most `limit`, both in [m/s]."""
    return max((number for number, speed in enumerate(speeds, 1) if speed > limit), default=0)
