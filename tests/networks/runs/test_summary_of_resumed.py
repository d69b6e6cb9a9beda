"""The summary of a run that is resumed."""

from __future__ import annotations

from pathlib import Path

from typing_extensions import override

from handcart.networks.events.run_observer import RunObserver
from handcart.networks.run_files.run_names import list_runs
from handcart.networks.runs.run import execute
from handcart.networks.runs.run_options import RunOptions
from handcart.networks.task.preparing import Prepared
from tests.networks.runs.conftest import UnfinishedRun


class Outcomes(RunObserver):
    """Notes which outcome the run is listed with when it begins."""

    def __init__(self, runs: Path) -> None:
        self._runs, self.seen = runs, list[str]()

    @override
    def begin(self, prepared: Prepared, run_dir: Path) -> None:
        self.seen += [run.outcome for run in list_runs(self._runs)]


def test_an_earlier_end_is_not_that_of_a_resumed_run(run: UnfinishedRun) -> None:
    outcomes = Outcomes(run.folder.parent)
    run.cut("START", 1)
    run.forget()
    execute(run.prepare(), run.folder, RunOptions(observers=(outcomes,), sync=False), run.past())
    assert outcomes.seen == [""]
    assert [item.outcome for item in list_runs(run.folder.parent)] == ["Success"]
