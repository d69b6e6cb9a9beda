"""Raw traffic with the robot, kept beside the journal and around whatever went wrong."""

from __future__ import annotations

from pathlib import Path
from types import TracebackType

from handcart.backends.recording import Recording
from handcart.backends.robot import Robot
from handcart.primitives.contract.outcome import Success

from handcart.networks.coordination.events import Ended, Event, Restoring
from handcart.networks.journal.evidence_files import FOLDER, stem
from .flight_recorder import END


class RecordingKeeper:
    """An onlooker and an observer of a run that steers a recording.

    For each Fail and GiveUp `evidence/003_MOVE_TO_Fail_frames.log` holds the seconds before the motion was
    broken off, and the last ones of the way back; `evidence/end_frames.log` those at the run's end.
    """

    def __init__(self, run_dir: Path, recording: Recording) -> None:
        """Begin: what has passed up to now is written."""
        self._folder, self._recording = run_dir / FOLDER, recording
        recording.open(run_dir)

    def look(self, robot: Robot) -> None:
        """A period has passed."""
        self._recording.look(robot.time)

    def __call__(self, event: Event) -> None:
        """Keep what an event makes worth keeping."""
        match event:
            case Restoring():
                self._recording.mark()
            case Ended(number=number, action=action, outcome=outcome) if not isinstance(outcome, Success):
                self._recording.keep(self._folder / stem(number, action.do, outcome))
            case _:
                pass

    def __enter__(self) -> RecordingKeeper:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._recording.mark()
        self._recording.keep(self._folder / END)
        self._recording.close()
