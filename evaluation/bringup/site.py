"""Site of a bring-up: the robot itself, or a bench."""

from __future__ import annotations

import hashlib
from abc import ABC, abstractmethod
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import can
from typing_extensions import override

from handcart.backends.backend import Backend
from handcart.backends.can.bench.bench import Bench
from handcart.backends.can.bus.can_line import CanLine
from handcart.backends.can.bus.errors import NoDrives
from handcart.backends.can.bus.open_bus import open_bus
from handcart.backends.can.can_backend import CanBackend
from handcart.backends.description.can_spec import CanSpec
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.registry import bench_class
from handcart.networks.runs.robot_claim import claimed

from .operator import Operator


@dataclass
class RobotSite(ABC):
    """Base class of real robots and benches (with simulated drives), on which bring-up steps run."""

    name: str
    """Name of the robot as the user gave it."""
    robot: RobotFile
    operator: Operator
    folder: Path
    """Folder of the records."""
    task: Path
    """Task for which the robot is brought up."""
    bench: str = ""
    """Simulated backend behind simulated drives; "" for the robot itself."""
    world: Path | None = None
    """World of the bench's robot."""
    camera_on_bench: bool = False
    """True to calibrate the camera on a bench as well."""
    answers: dict[str, bool | float] = field(default_factory=dict)
    """Answers given in the current step, by key of the question."""

    @property
    @abstractmethod
    def backend_name(self) -> str:
        """Return the name of the backend that drives the robot."""

    @property
    @abstractmethod
    def fingerprint(self) -> str:
        """Return a hash of those parts of the robot's file that the bring-up procedure checks."""

    @abstractmethod
    def backend(self, seed: int = 0) -> AbstractContextManager[Backend]:
        """Return a context with the backend of the robot, set up and at rest.

        A real robot is reserved for this process meanwhile.
        """

    # Answers of a person, kept in the record

    def confirm(self, key: str, question: str) -> bool:
        """Ask the operator a question; return True for yes. The answer is also kept in `answers` under
        `key`.
        """
        said = self.answers[key] = self.operator.confirm(key, question)
        return said

    def number(self, key: str, question: str, truth: float) -> float:
        """Ask the operator for a measured value and return it, in the unit of the question; on a bench the
        answer is `truth`.

        The answer is also stored in `answers` under `key`, for the step's record.
        """
        said = self.answers[key] = self.operator.number(key, question, lambda: truth)
        return said


@dataclass
class Site(RobotSite):
    """Robot with CAN drives that is brought up, or the bench in this process that simulates the robot."""

    @property
    @override
    def backend_name(self) -> str:
        return CanBackend.name

    @property
    def spec(self) -> CanSpec:
        """Return the section `can` of the robot's file.

        Raises:
            NoDrives: the file has no such section.
        """
        if self.robot.can is None:
            raise NoDrives()
        return self.robot.can

    @property
    def fingerprint(self) -> str:
        """Return a hash of those parts of the robot's file that the bring-up procedure checks.

        These are drives, limits, joints and the URDF, without the calibrated wheel radius and tread.
        """
        spec = self.robot.model_copy(
            update={"drive": self.robot.drive.model_copy(update={"wheel_radius_m": 1.0, "tread_m": 1.0})}
        )
        tried = spec.model_dump_json(include={"can", "period_s", "drive", "arm", "gripper"})
        return hashlib.sha256((tried + self.robot.urdf_text()).encode()).hexdigest()[:16]

    @contextmanager
    def line(self) -> Iterator[tuple[CanLine, list[can.Message]]]:
        """Open the CAN bus without configuring a node; yield it and the list to which received frames are
        appended.
        """
        came: list[can.Message] = []

        def heard(frame: can.Message, sent: bool) -> None:
            if not sent:
                came.append(frame)

        if not self.bench:
            line = CanLine(open_bus(self.spec), None, heard)
            try:
                yield line, came
            finally:
                line.close()
            return
        bench = Bench(self.robot, self.spec, None)
        line = CanLine(bench.open(), bench.serve, heard)
        try:
            yield line, came
        finally:
            line.close()
            bench.close()

    @contextmanager
    def backend(self, seed: int = 0) -> Iterator[CanBackend]:
        """Yield a backend that is connected to the robot; no drive is enabled yet.

        The settings of the drives have been written and read back. A real robot is reserved for this process
        until the context ends.
        """
        made = (
            CanBackend.build_on_bench(self.robot, self.world, seed, bench_class(self.bench, CanBackend.name))
            if self.bench
            else CanBackend.build(self.robot, None, seed)
        )
        try:
            with claimed(made):
                yield made
        finally:
            made.close()
