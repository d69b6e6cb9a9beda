"""Files in the run's folder with the evidence of primitives."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from io import BytesIO
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from handcart.files.maps.map_writing import MAP_FILE, TRAJECTORY_FILE, trajectory_csv, write_grid
from handcart.files.whole_file import write_whole
from handcart.networks.events.events import Ended, Event
from handcart.networks.events.run_observer import RunObserver
from handcart.primitives.outcomes.calibrated import Calibrated
from handcart.primitives.outcomes.drawn_map import DrawnMap
from handcart.primitives.outcomes.evidence import Evidence
from handcart.primitives.outcomes.outcome import Outcome, Success

EVIDENCE_FOLDER, MAPS_FOLDER = "evidence", "maps"


def stem(number: int, do: str, outcome: Outcome) -> str:
    """Return the begin of the names of an action's evidence files, such as `003_SEARCH_Fail`.

    Args:
        number: number of the action in the run, from 1.
        do: name of the action's primitive.
        outcome: outcome of the action; a Success is not part of the name.
    """
    ended = "" if isinstance(outcome, Success) else f"_{type(outcome).__name__}"
    return f"{number:03d}_{do}{ended}"


def evidence_order(name: str) -> tuple[int, str]:
    """Return the key that sorts names of evidence files by their actions: the action's number, and the name.

    The number is 0 for a file of no action.
    """
    number = name.partition("_")[0]
    return int(number) if number.isascii() and number.isdecimal() else 0, name


class EvidenceFiles(RunObserver):
    """Observer of a run that saves the pictures and points by which each action's outcome was decided.

    For example, `evidence/003_SEARCH_Fail_front.png` is the picture `front` of the third action. Maps that an
    action made are saved in `maps/NAME/`. Calibration values from successful actions are saved as well.
    """

    def __init__(self, run_dir: Path, keep_calibrated: Callable[[Mapping[str, Calibrated]], None]) -> None:
        """Create an observer for a run's folder; `keep_calibrated` receives values found for the robot."""
        self._folder, self._keep_calibrated = run_dir / EVIDENCE_FOLDER, keep_calibrated
        self.lost: str | None = None
        """Reason why nothing more is kept after the disk refused a write; the run continues."""

    def event(self, event: Event) -> None:
        """Handle the event that an action has ended: save the pictures and points by which its outcome was
        decided, and after a Success also its calibration values.
        """
        if isinstance(event, Ended):
            evidence = event.primitive.evidence
            try:
                self._write(stem(event.number, event.action.do, event.outcome), evidence)
            except OSError as error:
                self.lost = error.strerror
            if evidence.calibrated and isinstance(event.outcome, Success):
                with suppress(OSError):  # a full disk does not end the run
                    self._keep_calibrated(evidence.calibrated)

    def _write(self, name: str, evidence: Evidence) -> None:
        if self.lost is not None:
            return
        if evidence.pictures or evidence.points:
            self._folder.mkdir(exist_ok=True)
            write_evidence(self._folder, name, evidence)
        for key, drawn in evidence.maps.items():
            write_map(self._folder.with_name(MAPS_FOLDER) / key, drawn)


def write_evidence(folder: Path, name: str, evidence: Evidence) -> None:
    """Write pictures and points of an attempt into files.

    Args:
        folder: existing folder for the files.
        name: begin of the files' names.
        evidence: pictures and points of the attempt.

    Raises:
        OSError: a file cannot be written.
    """
    for key, picture in evidence.pictures.items():
        _, png = cv2.imencode(".png", picture)
        write_whole(folder / f"{name}_{key}.png", png.tobytes(), sync=False)
    if evidence.points:
        points: dict[str, Any] = dict(evidence.points)
        packed = BytesIO()
        np.savez_compressed(packed, **points)
        write_whole(folder / f"{name}.npz", packed.getvalue(), sync=False)


def write_map(folder: Path, drawn: DrawnMap) -> None:
    """Write a map into a folder: `map.yaml`, `map.pgm` and `trajectory.csv`.

    Raises:
        OSError: a file cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    write_grid(folder / MAP_FILE, drawn.grid)
    table = trajectory_csv(drawn.times, drawn.built.poses, drawn.built.covariances)
    write_whole(folder / TRAJECTORY_FILE, table.encode())
