"""Procedure to bring up a robot: steps in order, none skipped."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from handcart.backends.backend import RobotFault
from handcart.backends.can.can_backend import CanBackend
from handcart.backends.ros2.wire.ros_errors import NotOnTheAir
from handcart.files.errors import InputError
from handcart.files.suggest import suggest

from .axis_rungs import AxesRung, LimitsRung
from .bus_rungs import IdentifyRung, InterfaceRung, ReadBackRung
from .record import RungRecord, read, save
from .rung import Facts, Rung, RungFailed
from .site import RobotSite
from .stop_rungs import EmergencyStopRung, StopTestRung
from .use_rungs import CalibrationRung, CameraRung, PrimitiveRung, TaskRung

ALL_RUNGS: tuple[Rung[Any], ...] = (
    InterfaceRung(),
    IdentifyRung(),
    ReadBackRung(),
    EmergencyStopRung(),
    AxesRung(),
    LimitsRung(),
    StopTestRung(),
    CalibrationRung(),
    CameraRung(),
    PrimitiveRung(),
    TaskRung(),
)
"""Steps of the procedure, in order."""


class UnknownRung(InputError):
    """Error for a step name that the bring-up procedure does not have."""

    def __init__(self, name: str, allowed: list[str]) -> None:
        super().__init__(f"unknown step {name!r}{suggest(name, allowed)}")


class BenchFirst(InputError):
    """Error for a bring-up step that must first pass on the bench, with simulated drives.

    It has to pass there with the current version of the robot's file.
    """

    def __init__(self, rung: str, robot: str, backend: str) -> None:
        words = robot if backend == CanBackend.name else f"{robot} --{backend}"
        super().__init__(
            f"the step {rung!r} was not passed on the bench with the robot's file as it is; "
            f"needed first: handcart bringup {words} --bench kinematic --all"
        )


@dataclass
class Ladder:
    """Sequence of a robot's bring-up steps, with records of the passed steps in a folder."""

    site: RobotSite
    rehearsed: Path | None = None
    """Folder of the bench's records; None on the bench itself."""
    rungs: Sequence[Rung[Any]] = ALL_RUNGS
    """Steps in order."""

    def records(self, folder: Path | None = None) -> list[RungRecord]:
        """Return the records of the steps passed so far, up to the first step without a valid record.

        A record is valid if the step passed with this version of the robot's file.

        Args:
            folder: folder of the records; None: the folder of the site, which is the robot or its bench.
        """
        found = []
        for number, rung in enumerate(self.rungs, 1):
            path = _path(folder or self.site.folder, number, rung)
            record = read(path) if path.is_file() else None
            if record is None or not record.passed or record.fingerprint != self.site.fingerprint:
                break
            found.append(record)
        return found

    @property
    def next(self) -> Rung[Any] | None:
        """First step that has not been passed yet; None if all steps have been passed."""
        done = len(self.records())
        return self.rungs[done] if done < len(self.rungs) else None

    def climb(self, tell: Callable[[str], None] = lambda _: None) -> RungRecord:
        """Run the next step of the bring-up and record it, passed or failed; there has to be a next step.

        Args:
            tell: receives number, name and summary of the step before it runs.

        Raises:
            BenchFirst: the step has not passed on the bench, that is with simulated drives.
            InputError: an input of the step is missing, or a question was not answered.
        """
        rung = self.next
        assert rung is not None
        number = [rung_.name for rung_ in self.rungs].index(rung.name) + 1
        if self.rehearsed is not None and len(self.records(self.rehearsed)) < number:
            raise BenchFirst(rung.name, self.site.name, self.site.backend_name)
        self.site.folder.mkdir(parents=True, exist_ok=True)
        self.site.answers.clear()
        tell(f"{number}. {rung.name}: {rung.summary}")
        record = self._tried(rung)
        save(record, _path(self.site.folder, number, rung))
        return record

    def _tried(self, rung: Rung[Any]) -> RungRecord:
        site, reason = self.site, ""
        left_out = rung.left_out(site)
        facts: Facts = {}
        try:
            facts = {"left_out": left_out} if left_out else rung.climb(site)
        except (RungFailed, RobotFault, NotOnTheAir) as error:
            reason = str(error)
        return RungRecord(
            rung=rung.name,
            passed=not reason,
            reason=reason,
            robot=site.name,
            fingerprint=site.fingerprint,
            bench=site.bench,
            when=datetime.now(UTC).isoformat(timespec="seconds"),
            facts=facts,
            answers=dict(site.answers),
        )

    def again(self, name: str) -> None:
        """Invalidate the result of a step and of all later steps, so that they have to run again. Their
        records move into a subfolder `before_TIME`.

        Raises:
            UnknownRung: no step has that name.
        """
        names = [rung_.name for rung_ in self.rungs]
        if name not in names:
            raise UnknownRung(name, names)
        aside = self.site.folder / f"before_{datetime.now(UTC):%Y%m%dT%H%M%S}"
        for number, rung in enumerate(self.rungs, 1):
            path = _path(self.site.folder, number, rung)
            if number > names.index(name) and path.is_file():
                aside.mkdir(exist_ok=True)
                shutil.move(path, aside / path.name)


def _path(folder: Path, number: int, rung: Rung[Any]) -> Path:
    return folder / f"{number:02d}_{rung.name}.yaml"
