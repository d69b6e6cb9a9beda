"""Plan of faults that are injected into a campaign's trials."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from pathlib import Path
from random import Random
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from handcart.backends.backend import Backend
from handcart.backends.robot.robot import Robot
from handcart.evaluation.conformance.faults.fault import FOR_GOOD, Fault, FaultKind, all_sensors
from handcart.evaluation.conformance.faults.faulty_backend import FaultyBackend
from handcart.files.models.loading import load
from handcart.files.models.model import FileModel
from handcart.files.suggest import suggest
from handcart.networks.events.run_observer import RunObserver

Seconds = Annotated[float, Field(gt=0.0, le=1e6)]
_OF_A_SENSOR = ("stale sensor", "NaN")
_IN_ONE_CALL = (FaultKind.EXCEPTION, FaultKind.REFUSED)
"""Kinds that wait for the next call that they concern, and end with it."""


class PlannedFault(FileModel):
    """Fault to inject once (`at_s`), periodically (`every_s`) or at random times (`rate_per_s`)."""

    kind: Literal[
        "exception", "refused command", "stuck actuator", "slip", "stale sensor", "NaN", "lidar faults"
    ]
    sensor: str = ""
    """Affected sensor; empty for an exception that the next command raises."""
    periods: Annotated[int, Field(ge=1, le=1_000_000)] | None = None
    """Duration in periods; None: until the next call for an exception and a refused command, otherwise 1."""
    speed_m_s: float = 0.0
    """Speed at which a standing base slides forwards."""
    turn_deg_s: float = 0.0
    """Rate at which a standing base slides around."""
    at_s: Annotated[float, Field(ge=0.0, le=1e6)] | None = None
    """Robot time of a single occurrence."""
    every_s: Seconds | None = None
    """Time between occurrences, and before the first one."""
    rate_per_s: Annotated[float, Field(gt=0.0, le=1e3)] | None = None
    """Mean rate of occurrences at instants drawn by the trial's seed."""

    @model_validator(mode="after")
    def _whole(self) -> PlannedFault:
        if sum(item is not None for item in (self.at_s, self.every_s, self.rate_per_s)) != 1:
            raise ValueError("when it comes isn't clear; needed: one of at_s, every_s, rate_per_s")
        if self.sensor not in all_sensors() and (self.sensor or self.kind in _OF_A_SENSOR):
            raise ValueError(f"unknown sensor {self.sensor!r}{suggest(self.sensor, all_sensors())}")
        return self

    def fault(self) -> Fault:
        """Return the fault to inject, as the keys of this entry of a faults file describe it."""
        kind, turn = FaultKind(self.kind), math.radians(self.turn_deg_s)
        periods = self.periods or (FOR_GOOD if kind in _IN_ONE_CALL else 1)
        return Fault(kind, self.sensor, periods, self.speed_m_s, turn)

    def instants(self, draw: Random) -> Iterator[float]:
        """Yield the robot times in [s] at which the fault is injected, in ascending order.

        The times go on without end for a repeated fault.

        Args:
            draw: random generator for a fault that is planned with a mean rate, `rate_per_s`, instead of
                fixed times.
        """
        if self.at_s is not None:
            yield self.at_s
        elif self.every_s is not None:
            yield from itertools.count(self.every_s, self.every_s)
        else:
            time = 0.0
            while True:
                time += draw.expovariate(self.rate_per_s or 1.0)
                yield time


class FaultPlan(FileModel):
    """Content of a faults file, with the faults to inject into each trial of a campaign."""

    format: Literal["handcart-faults/1"]
    faults: Annotated[list[PlannedFault], Field(min_length=1)]


def load_faults(path: Path) -> FaultPlan:
    """Load a file that states which faults are injected into trials, and when.

    Raises:
        FileError: the file is invalid.
    """
    return load(path, FaultPlan)


class InjectedFaults(RunObserver):
    """Observer that injects the faults of a plan into a trial, through a wrapper of the trial's backend.

    Only one fault is active: a new fault ends the one before it. A fault that raises an exception raises it
    in the next call of the backend that does not come from the localizer.
    """

    def __init__(self, plan: FaultPlan, seed: int) -> None:
        """Prepare without injecting anything.

        Args:
            plan: faults and their times.
            seed: seed of the trial.
        """
        self.injected: list[dict[str, Any]] = []
        """Injected faults, each with `fault`, `at_s` and `bitten`, the number of readings or commands that it
        changed.
        """
        self._backend: _Faulty | None = None
        self._coming = [
            (fault.fault(), fault.instants(Random(f"{seed} fault {number}")))
            for number, fault in enumerate(plan.faults)
        ]
        self._next = [next(instants, math.inf) for _, instants in self._coming]

    def around(self, backend: Backend) -> Backend:
        """Wrap a backend so that faults can be injected into it; return the wrapper, to be used instead."""
        self._backend = _Faulty(backend)
        return self._backend

    def period(self, robot: Robot) -> None:
        """Inject the faults that are due in this period."""
        assert self._backend is not None
        self._backend.asked = True
        for number, (fault, instants) in enumerate(self._coming):
            if robot.time < self._next[number] - 1e-9:
                continue
            while self._next[number] <= robot.time + 1e-9:
                self._next[number] = next(instants, math.inf)
            self._note()
            self._backend.bitten = 0
            self._backend.inject(fault)
            self.injected.append({"fault": str(fault), "at_s": round(robot.time, 6), "bitten": 0})

    def end(self) -> None:
        """Complete the record of the last fault: the number of readings or commands that it changed."""
        self._note()

    def _note(self) -> None:
        if self.injected and self._backend is not None:
            self.injected[-1]["bitten"] = self._backend.bitten


class _Faulty(FaultyBackend):
    """Backend with faults. Readings during `step` are the localizer's, not a primitive's."""

    def step(self) -> None:
        self.asked = False
        super().step()
