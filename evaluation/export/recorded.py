"""What was recorded of a run, in the order of time: as much as its folder keeps."""

from __future__ import annotations

import re
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from handcart.networks.journal.evidence_files import FOLDER
from handcart.networks.journal.past_run import PastRun
from handcart.networks.runs.flight_recorder import SUFFIX, Readings, load_readings
from handcart.networks.runs.run_folder import NoRun

Floats = NDArray[np.float64]


class Picture(NamedTuple):
    """A picture that decided how an action ended."""

    time: float
    """When the action ended, in [s]."""
    name: str
    """Such as `landmark`."""
    path: Path
    """A PNG."""


class Scan(NamedTuple):
    """What the range sensor read."""

    time: float
    """In [s]."""
    ranges: Floats
    """(m,), in [m]."""
    angles: Floats
    """(m,) of its beams, in [rad]."""
    base_T_sensor: Floats
    """(3,), in [m, m, rad]."""


class Joints(NamedTuple):
    """How arm and gripper stood."""

    time: float
    """In [s]."""
    joints: Sequence[float]
    """In [rad], or [m] where one slides."""
    grip: float | None
    """Opening in [m]; None: there is no gripper."""


@dataclass(frozen=True)
class Recorded:
    """Readings around Fails and of the last seconds; what stands in the journal is there of the whole run."""

    run: PastRun

    @cached_property
    def _readings(self) -> list[Readings]:
        """Raises `NoRun` where one is damaged."""
        paths = sorted((self.run.folder / FOLDER).glob(f"*{SUFFIX}"))
        return [self._read(each) for each in paths]

    def _read(self, path: Path) -> Readings:
        try:
            return load_readings(path)
        except (OSError, ValueError, zipfile.BadZipFile) as error:
            raise NoRun(self.run.folder, f"{path.name} in it holds no readings ({error})") from None

    def _rows(self, name: str) -> Iterator[tuple[float, Readings, int]]:
        """Each instant at which something was read, once: when, in which file and in which row."""
        found: dict[float, tuple[Readings, int]] = {}
        for readings in self._readings:
            if name in readings:
                for row, time in enumerate(readings["time_s"]):
                    found.setdefault(float(time), (readings, row))
        for time, (readings, row) in sorted(found.items(), key=lambda each: each[0]):
            yield time, readings, row

    def scans(self) -> list[Scan]:
        """Of the range sensor."""
        return [
            Scan(time, readings["ranges_m"][row], readings["angles_rad"], readings["base_T_sensor"])
            for time, readings, row in self._rows("ranges_m")
        ]

    def joints(self) -> list[Joints]:
        """As read around Fails, and as noted where each action started and ended."""
        found: dict[float, Joints] = {}
        for record in self.run.records:
            at: Mapping[str, Any] = record.get("at") or {}
            if at.get("joints"):
                time = float(record["t"])
                found[time] = Joints(time, at["joints"], at.get("grip"))
        for time, readings, row in self._rows("joints_rad"):
            grip = float(readings["grip_width_m"][row]) if "grip_width_m" in readings else None
            found[time] = Joints(time, readings["joints_rad"][row], grip)
        return [found[time] for time in sorted(found)]

    def pictures(self) -> list[Picture]:
        """Those of `evidence`, in the order of the actions."""
        return [
            Picture(action.end, found[1], path)
            for action in self.run.actions
            for path in sorted((self.run.folder / FOLDER).glob(f"{action.number:03d}_{action.do}_*.png"))
            if (found := re.fullmatch(rf"\d+_{action.do}(?:_Fail|_GiveUp)?_(\w+)", path.stem))
        ]
