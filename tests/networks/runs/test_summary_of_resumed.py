"""What a run that is resumed says of its end and of its permissions."""

from __future__ import annotations

from pathlib import Path

from typing_extensions import override

from handcart.networks.events.run_observer import RunObserver
from handcart.networks.operator.permits import Permits
from handcart.networks.run_files.run_names import OVERVIEW_FILE, REPORT_FILE, list_runs
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
    pages = [run.folder / name for name in (REPORT_FILE, OVERVIEW_FILE)]
    for page in pages:
        page.write_text("of the earlier end", encoding="utf-8")
    execute(run.prepare(), run.folder, RunOptions(observers=(outcomes,), sync=False), run.past())
    assert outcomes.seen == [""]
    assert not any(page.exists() for page in pages)
    assert [item.outcome for item in list_runs(run.folder.parent)] == ["Success"]


def test_the_journal_tells_by_which_rule_permissions_were_given(run: UnfinishedRun) -> None:
    """A real robot's first run refuses them by default, a person continues it with `--permit always`."""
    run.cut("START", 1)
    run.forget()
    execute(run.prepare(), run.folder, RunOptions(permits=Permits("always"), sync=False), run.past())
    said = {record["kind"]: record["wall"].get("permits") for record in run.records}
    assert (said["RUN"], said["EPOCH"]) == ("never", "always")
