"""Steps that check that the robot stops."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from typing_extensions import override

from handcart.backends.can.can_backend import CanBackend
from handcart.backends.can.drives.axis import ENABLED
from handcart.backends.capabilities.base import Base

from .jog import HAND_SPEED
from .rung import Facts, Rung, RungFailed
from .site import Site

BUTTON_TIMEOUT_S = 60.0
"""Time in which a person has to press a button, in [s]."""
_BENCH_PATIENCE = 100  # periods
_WATCH = 2.0  # [s] after the emergency stop is released
STOP_TRIALS = 5
"""Number of trials of each stop."""


class EmergencyStopRung(Rung[Site]):
    """Bring-up step that checks that the emergency stop removes the drives' torque.

    Releasing the emergency stop must not restore the torque.
    """

    name = "emergency_stop"
    summary = "the emergency stop (STO) takes every drive out of OPERATION ENABLED; released, none comes back"

    @override
    def climb(self, site: Site) -> Facts:
        with site.backend() as backend:
            bench = backend.bench

            def press(pressed: bool) -> None:
                for drive in bench.drives.values() if bench else ():
                    drive.pressed = pressed

            backend.enable()
            site.operator.act(
                "press",
                "Press the emergency stop now; the drives have torque and are at rest.",
                lambda: press(True),
            )
            states, took = _until_off(backend)
            if not site.confirm("pressed", "Did you press it, and did nothing else stop the drives?"):
                raise RungFailed("the drives stopped, but not by the emergency stop")
            site.operator.act("release", "Release the emergency stop; stay away.", lambda: press(False))
            for _ in range(round(_WATCH / backend.period)):
                backend.watch()
            back = [name for name, axis in backend.axes.items() if axis.drive_state == ENABLED]
        if back:
            raise RungFailed(f"came back by itself: {', '.join(back)}; releasing must give no torque")
        return {"states": states, "all_off_within_s": round(took, 3)}


def _until_off(backend: CanBackend) -> tuple[dict[str, str], float]:
    """Wait until no drive is enabled; return their states, and the time from the first to the last, in
    [s].
    """
    end, periods, first = time.monotonic() + BUTTON_TIMEOUT_S, 0, -1
    while time.monotonic() < end and (backend.bench is None or periods < _BENCH_PATIENCE):
        backend.watch()
        states = {name: axis.drive_state for name, axis in backend.axes.items()}
        on = [name for name, state in states.items() if state == ENABLED]
        if not on:
            return states, (periods - first) * backend.period if first >= 0 else 0.0
        if len(on) < len(states) and first < 0:
            first = periods
        periods += 1
    raise RungFailed(f"still enabled: {', '.join(on)}; does the emergency stop reach their drives?")


class StopTestRung(Rung[Site]):
    """Bring-up step that measures the stopping distance of the base for each kind of stop."""

    name = "stop_test"
    summary = "how far the base runs on at 250 mm/s: a stop by the program, and our heartbeat gone"

    @override
    def climb(self, site: Site) -> Facts:
        speed = _trial_speed(site)
        site.operator.tell(
            f"The base drives {speed * 1.5:.2f} m straight on and stops, {2 * STOP_TRIALS} times."
        )
        facts: Facts = {"speed_m_s": speed, "times": STOP_TRIALS}
        for name, stop in (("program", _by_program), ("heartbeat", _by_silence)):
            if not site.confirm(f"clear_{name}", f"Is the way clear? Next: {name}."):
                raise RungFailed("the way wasn't clear")
            stops = [_stop_once(site, stop, number) for number in range(STOP_TRIALS)]
            facts[name] = spread = _spread(stops)
            allowed = self._allowed(site, name)
            facts[f"{name}_allowed_m"] = round(allowed, 4)
            if spread["max_m"] > allowed:
                raise RungFailed(f"{name}: ran on {spread['max_m']:.3f} m; allowed: {allowed:.3f} m")
        measured = site.number(
            "tape_m",
            "Stopping distance of the base in the last stop, by tape [m]?",
            facts["heartbeat"]["last_m"],
        )
        facts["tape_m"] = measured
        off = abs(measured - facts["heartbeat"]["last_m"])
        if off > max(0.02, 0.1 * measured):
            raise RungFailed(f"tape and encoders are {1e3 * off:.0f} mm apart: do the wheels slip?")
        return facts

    @staticmethod
    def _allowed(site: Site, how: str) -> float:
        """Return the allowed stopping distance v t + v²/2a, in [m]; the delay t includes two periods."""
        drive, period, speed = site.robot.drive, site.robot.period_s, _trial_speed(site)
        delay = 2 * period + (site.spec.heartbeat_timeout_ms / 1e3 if how == "heartbeat" else 0.0)
        return speed * delay + speed**2 / (2 * drive.acceleration_m_s2)


Stop = Callable[[CanBackend], None]


def _trial_speed(site: Site) -> float:
    """Return the speed of the base from which it stops, in [m/s]."""
    return min(HAND_SPEED, site.robot.drive.top_speed_m_s)


def _stop_once(site: Site, stop: Stop, number: int) -> float:
    """Drive up to the speed of the trials and stop; return the stopping distance of the base, in [m]."""
    with site.backend(number) as backend:
        base = backend.get(Base)  # type: ignore[type-abstract]
        assert base is not None
        drive, period = site.robot.drive, backend.period
        speed = _trial_speed(site)
        for _ in range(round((speed / drive.acceleration_m_s2 + 0.5) / period)):
            base.drive(speed, 0.0)
            backend.step()
        before = _rolled(backend)
        stop(backend)
        return abs(_rolled(backend) - before)


def _rolled(backend: CanBackend) -> float:
    """Return the mean travel of both wheels in [m], as the drives answer to SDO requests."""
    wheels = (backend.axes.left, backend.axes.right)
    return float(np.mean([axis.units.position(int(axis.sdo[0x6064].raw)) for axis in wheels]))


def _by_program(backend: CanBackend) -> None:
    backend.stop()
    for _ in range(round(_WATCH / backend.period)):
        backend.step()


def _by_silence(backend: CanBackend) -> None:
    """Send SYNCs, so that time passes on a bench, but no heartbeat and no commands."""
    for _ in range(round(_WATCH / backend.period)):
        backend.watch(beat=False)


def _spread(ways: list[float]) -> dict[str, float]:
    p50, p99 = (round(float(item), 4) for item in np.percentile(ways, (50, 99)))
    return {"p50_m": p50, "p99_m": p99, "max_m": round(max(ways), 4), "last_m": round(ways[-1], 4)}
