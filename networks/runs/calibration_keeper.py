"""Writing what a run found of the robot into its folder."""

from __future__ import annotations

from pathlib import Path

from handcart.files.models.loading import load
from handcart.files.whole_file import write_whole
from handcart.networks.coordination.events import Ended, Event
from handcart.networks.run_observer import RunObserver
from handcart.networks.task.preparing import Prepared
from handcart.primitives.contract.outcome import Success

from .calibration import NAME, Calibration, Value, rounded


class CalibrationKeeper(RunObserver):
    """An observer that keeps `calibration.yaml`: what actions found that succeeded; the last one counts."""

    def __init__(self, run_dir: Path, prepared: Prepared) -> None:
        self._path = run_dir / NAME
        name = prepared.task.robot
        self._robot = str(Path(name).resolve()) if name.endswith((".yaml", ".yml")) else name
        self._backend = prepared.backend_name
        self.lost: str | None = None
        """Why it isn't kept, where the disk took no more; the journal has what was found."""

    def event(self, event: Event) -> None:
        """Take in what an action found."""
        if not (isinstance(event, Ended) and isinstance(event.outcome, Success)):
            return
        found = rounded(event.primitive.evidence.calibrated)
        if found:
            try:
                self._write(found)
            except OSError as error:
                self.lost = error.strerror

    def _write(self, found: dict[str, Value]) -> None:
        before = dict(load(self._path, Calibration).found) if self._path.exists() else {}
        whole = Calibration(
            format="handcart-calibration/1",
            robot=self._robot,
            backend=self._backend,
            found=before | found,
        )
        write_whole(self._path, whole.text())
