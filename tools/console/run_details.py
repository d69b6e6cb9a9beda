"""All that the page shows of one run, from its folder."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from handcart.evaluation.viewing.explanation.explanation import relying_on_the_journal
from handcart.evaluation.viewing.explanation.explanation_words import choice_words
from handcart.files.errors import HandcartError
from handcart.networks.analysis.outlook import NoOutlook, outlook
from handcart.networks.chains.policy import TooLarge
from handcart.networks.drawing.folded_network import Spot
from handcart.networks.drawing.network_picture import draw_network
from handcart.networks.drawing.svg import to_svg
from handcart.networks.journal.waiting import waiting
from handcart.networks.operator.acknowledging import cause_of
from handcart.networks.operator.view_address import view_address
from handcart.networks.past_runs.hindsight import choice_of, counts_now
from handcart.networks.past_runs.past_run import read_run
from handcart.networks.run_files.run_folder import read_run_journal
from handcart.networks.run_files.run_names import REPORT_FILE
from handcart.networks.runs.evidence_files import evidence_order
from handcart.networks.task.task_file import load_task

EVIDENCE_PATH = "evidence"
EVIDENCE_SUFFIXES = (".png", ".jpg", ".jpeg")
RUN_PAGES = (REPORT_FILE,)
MOST_ACTIONS = 500
"""Maximum number of actions that the page shows, the last ones; a run's report has all."""


class RunDetails:
    """Reader of a run's journal, which returns the actions, situation and other data that the console's page
    shows.

    The run may be running or have ended.
    """

    def __init__(self, folder: Path, alive: bool) -> None:
        """Read the journal of a run.

        Raises:
            NoRun, JournalError: the journal cannot be read.
        """
        self._folder, self._alive, self._run = folder, alive, read_run(folder)

    def summary(self, situation: str | None) -> dict[str, Any]:
        """Return the details of the run that the console's page shows; `situation` is the situation of the
        network that the run itself reports while it is running.
        """
        run = self._run
        end = run.end
        last = str(end["situation"]) if end else (run.actions[-1].source if run.actions else "")
        return {
            "task": run.header["task"],
            "situation": situation or last,
            "reason": str(end["reason"]) if end else "",
            "actions": [_action(action) for action in run.actions[-MOST_ACTIONS:]],
            "network": self._network(),
            "waits": [] if self._alive else self._waits(),
            "moved": self._moved(),
            "pictures": self._pictures(),
            "pages": [name for name in RUN_PAGES if (self._folder / name).is_file()],
            "view": view_address(self._folder) if self._alive else None,
            "view_command": f"handcart view {shlex.quote(str(self._folder))}",
            "resume": f"handcart resume {shlex.quote(str(self._folder))}",
        }

    def after(self, situation: str, action: int) -> dict[str, Any]:
        """Return the probabilities of reaching the goal after a person's answer about an action.

        The action waits for permission; the person may permit it, report that it has succeeded already, or
        refuse it.

        Args:
            situation: present situation of the run.
            action: index of the waiting action in the network.

        Returns:
            the probabilities `permitted`, `succeeded` and `refused`; or, as `unknown`, the reason why they
            cannot be computed.
        """
        run = self._run
        try:
            task = load_task(Path(str(run.header["task_path"])), run.header.get("settings") or {})
            if task.network.fingerprint() != run.header.get("network"):
                return {"unknown": "the task's file has changed since the run began"}
            return outlook(task, situation, counts_now(run), action)._asdict()
        except (NoOutlook, TooLarge, HandcartError) as error:
            return {"unknown": str(error).splitlines()[0]}

    def why(self, number: int) -> dict[str, Any]:
        """Return why an action was chosen.

        Args:
            number: number of the action in the run, from 1.

        Returns:
            `why`: a line for each alternative, with its probability of reaching the goal and its time; or, as
            `unknown`, the reason why the alternatives are not known.

        Raises:
            JournalError: the journal's content is inconsistent.
        """
        run = self._run
        action = next((item for item in run.actions if item.number == number), None)
        if action is None:
            return {"unknown": f"no action {number} was started"}
        with relying_on_the_journal(run):
            choice = choice_of(run, action)
        if choice is None:
            return {"unknown": "the journal does not keep what else there was"}
        return {"why": list(choice_words(choice))}

    def _network(self) -> dict[str, Any] | None:
        kept = self._run.network
        if kept is None:
            return None
        picture = draw_network(kept.network, [(action.index, action.outcome) for action in self._run.actions])
        boxes = [
            {
                "x": box.x,
                "y": box.y,
                "width": box.width,
                "height": box.height,
                "name": box.is_of.name,
                "situations": list(box.is_of.members),
            }
            for box in picture.boxes
            if isinstance(box.is_of, Spot)
        ]
        return {"svg": to_svg(picture), "situations": boxes}

    def _waits(self) -> list[dict[str, Any]]:
        """Return the records that wait for a person, each with the checksum of its cause (row U12)."""
        contents = read_run_journal(self._folder)
        return [
            {
                "record": record,
                "reason": reason,
                "cause": cause_of(contents, record)["h"],
                "action": contents.records[record].get("n") if record < len(contents.records) else None,
            }
            for record, reason in waiting(contents).items()
        ]

    def _moved(self) -> list[dict[str, Any]]:
        """Return the robot's residuals against its last state, from each resume of the run (row U13), and
        each change of the world between two actions, with its reason.
        """
        found: Sequence[Mapping[str, Any]] = self._run.records
        return [
            {
                "record": entry["q"],
                "residuals": entry.get("residuals") or {},
                "unknown": entry.get("unknown") or [],
                "reason": str(entry.get("reason", "")),
            }
            for entry in found
            if entry["kind"] == "RECON"
        ]

    def _pictures(self) -> list[dict[str, Any]]:
        """Return the robot's pictures, the newest last, each with the number of its action."""
        folder = self._folder / EVIDENCE_PATH
        if not folder.is_dir() or folder.is_symlink():
            return []
        names = [
            path.name
            for path in folder.iterdir()
            if path.suffix in EVIDENCE_SUFFIXES and not path.is_symlink()
        ]
        numbered = sorted(map(evidence_order, names))
        return [{"action": number, "file": f"{EVIDENCE_PATH}/{name}"} for number, name in numbered]


def _action(action: Any) -> dict[str, Any]:
    return {
        "number": action.number,
        "index": action.index,
        "do": action.do,
        "from": action.source,
        "to": action.target,
        "with": {key: str(value) for key, value in action.parameters.items()},
        "start": action.start,
        "end": action.end,
        "outcome": action.outcome,
        "reason": action.reason,
    }
