"""Raw traffic with the robot, kept next to the journal, and around each Fail and GiveUp."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from typing_extensions import override

from handcart.backends.recording import Recording
from handcart.backends.robot.robot import Robot
from handcart.networks.events.events import Ended, Event, Restoring
from handcart.networks.events.run_observer import RunObserver
from handcart.primitives.outcomes.outcome import Success

from .evidence_files import EVIDENCE_FOLDER, stem
from .flight_recorder import END_STEM

if TYPE_CHECKING:
    from handcart.networks.task.preparing import Prepared


class RecordingKeeper(RunObserver):
    """Observer of a run that saves a backend's recording, such as the frames of a bus, around failures.

    After each Fail and GiveUp, a file such as `evidence/003_MOVE_TO_Fail_frames.log` holds the last seconds
    of the failed action's motion, and of its return to the state at its start. `evidence/end_frames.log`
    holds the last seconds of the run.
    """

    def __init__(self, recording: Recording) -> None:
        """Create the observer; nothing is written yet."""
        self._folder, self._recording = Path(), recording

    def begin(self, prepared: Prepared, run_dir: Path) -> None:
        """Open the recording's files in the run's folder, and write everything recorded so far."""
        self._folder = run_dir / EVIDENCE_FOLDER
        self._recording.open(run_dir)

    def period(self, robot: Robot) -> None:
        """Record the backend's data, such as bus frames, of the control period that has just ended."""
        self._recording.look(robot.time)

    def event(self, event: Event) -> None:
        """Save the recording of the last seconds if the event is a Fail or GiveUp of an action."""
        match event:
            case Restoring():
                self._recording.mark()
            case Ended(number=number, action=action, outcome=outcome) if not isinstance(outcome, Success):
                self._recording.keep(self._folder / stem(number, action.do, outcome))
            case _:
                pass

    @override
    def end(self) -> None:
        self._recording.mark()
        self._recording.keep(self._folder / END_STEM)
        self._recording.close()
