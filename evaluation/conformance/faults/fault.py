"""Faults that can be injected."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cache
from typing import Any

from handcart.backends.sensors.all_kinds import all_capabilities
from handcart.primitives.outcomes.cause_kind import CauseKind
from handcart.tasks.domain import domains, imported

NO_FAULT = "nothing"
"""The kind of a trial in which no fault is injected."""
FOR_GOOD = 1_000_000
"""Number of periods of a permanent fault, longer than any run."""


class FaultKind(Enum):
    """Kinds of faults that the kit injects into a backend."""

    EXCEPTION = "exception"
    """The backend raises an exception when a sensor is read next, or at the next command."""
    REFUSED = "refused command"
    """The next command is refused."""
    STUCK = "stuck actuator"
    """The next commanded actuator accepts its commands and does not move."""
    SLIP = "slip"
    """The base goes less far than its wheels roll; a standing one slides."""
    STALE = "stale sensor"
    """A sensor repeats its last reading."""
    NAN = "NaN"
    """A sensor gives NaN, a camera black pictures."""
    CANCEL = "cancel"
    """A person cancels the attempt."""
    TIME_OUT = "time-out"
    """The caller of the attempt times out."""
    LIDAR = "lidar faults"
    """Some of a lidar's beams read zero, NaN, -infinity or the robot's own body, as drivers deliver it."""
    WORLD = "world"
    """An event changes the objects that a domain's primitives work on, see `Domain.faults`."""


PRIMITIVE_FAULTS = tuple(kind for kind in FaultKind if kind is not FaultKind.WORLD)
"""Kinds that are tried in any primitive."""

HARMLESS_FAULTS = (
    FaultKind.EXCEPTION,
    FaultKind.REFUSED,
    FaultKind.CANCEL,
    FaultKind.TIME_OUT,
    FaultKind.LIDAR,
)
"""Kinds after which the robot still works, so that its state can be restored."""


@dataclass(frozen=True)
class Fault:
    """Fault of a sensor, of a part of the robot, or of the world around it, to be injected into a
    simulation.
    """

    kind: FaultKind
    sensor: str = ""
    """Affected sensor, one of `all_sensors`; for an exception, empty means the next command. For a fault
    of the world, a short name of the event.
    """
    periods: int = 1
    """Duration in periods."""
    speed: float = 0.0
    """Speed at which a standing base slides ahead, in [m/s]."""
    turn_rate: float = 0.0
    """Rate at which a standing base slides around, in [rad/s]."""
    act: Callable[[Any], None] | None = None
    """Function that changes the simulated world, called with it before each of its periods."""
    causes: tuple[CauseKind, ...] = ()
    """Causes that a Fail or GiveUp after it may name, for a fault of the world; empty: any."""

    def __str__(self) -> str:
        what = f"{self.kind.value} {self.sensor}".rstrip()
        if self.kind in HARMLESS_FAULTS:
            return what
        return f"{what} for good" if self.periods >= FOR_GOOD else f"{what} for {self.periods} periods"


_STUCK, _STALE, _NAN = (20, FOR_GOOD, 5), (20, FOR_GOOD, 60), (1, 10, FOR_GOOD)
_SLIDES = ((0.1, 0.0), (-0.1, 0.0), (0.0, 0.12), (0.0, -0.12))


@cache
def all_sensors() -> tuple[str, ...]:
    """Return the names of all kinds of sensors into which a fault can be injected."""
    readings = (reading for kind in all_capabilities() for reading in kind.READINGS.values())
    return tuple(dict.fromkeys(reading.sensor for reading in readings))


def variant(kind: FaultKind, number: int, sensors: Sequence[str] = ()) -> Fault:
    """Return one of the variants of a kind of fault.

    Args:
        kind: kind of fault.
        number: number of the variant, from 0; numbers beyond the last variant begin again at the first.
        sensors: sensors that may be affected; empty for all.
    """
    sensors = sensors or all_sensors()
    sensor = sensors[number % len(sensors)]
    turn = number // len(sensors)
    match kind:
        case FaultKind.EXCEPTION:
            return Fault(kind, ("", *sensors)[number % (1 + len(sensors))], FOR_GOOD)
        case FaultKind.STUCK:
            return Fault(kind, periods=_STUCK[number % len(_STUCK)])
        case FaultKind.SLIP:
            speed, turn_rate = _SLIDES[number % len(_SLIDES)]
            return Fault(kind, periods=10, speed=speed, turn_rate=turn_rate)
        case FaultKind.STALE:
            return Fault(kind, sensor, _STALE[turn % len(_STALE)])
        case FaultKind.NAN:
            return Fault(kind, sensor, _NAN[turn % len(_NAN)])
        case FaultKind.LIDAR:
            return Fault(kind, "range", FOR_GOOD)
    return Fault(kind, periods=FOR_GOOD)


def faults_of(primitive: str) -> tuple[Fault, ...]:
    """Return the faults for tests of a primitive that the primitive's application domain declares itself.

    Args:
        primitive: name of the primitive.
    """
    named = [
        domain.faults for domain in domains() if primitive in domain.primitives and domain.faults is not None
    ]
    return tuple(fault for path in named for fault in imported(path))
