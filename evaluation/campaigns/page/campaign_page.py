"""Page of a campaign: one HTML file that loads nothing from elsewhere."""

from __future__ import annotations

import base64
import hashlib
import os
from collections.abc import Iterator, Mapping
from contextlib import suppress
from importlib.resources import files
from pathlib import Path, PurePath
from typing import Any
from urllib.parse import quote

import numpy as np

from handcart.evaluation.campaigns.data.campaign_folder import RUNS, CampaignFolder
from handcart.evaluation.campaigns.data.trial import Trial
from handcart.evaluation.campaigns.statistics.campaign_report import CampaignReport, Spread
from handcart.evaluation.campaigns.statistics.claim import Settling
from handcart.evaluation.campaigns.statistics.divergence import first_difference
from handcart.evaluation.campaigns.statistics.exact_value import compare_share, exact_goal, file_chances
from handcart.evaluation.campaigns.statistics.rerun import rerun
from handcart.evaluation.viewing.report.report import write_report
from handcart.files.errors import HandcartError
from handcart.files.whole_file import write_whole
from handcart.networks.run_files.run_names import GENERIC_STEM, REPORT_FILE

from .plots import histogram, share_axis
from .trial_table import TrialTable, constant, short

RATE_WIDTH = 300.0  # of the success rate's axis, in [px]
MOST_BLAMES = 100


class CampaignPage:
    """HTML report of the trials that a campaign's folder holds so far."""

    def __init__(self, found: CampaignFolder, report: CampaignReport, settling: Settling | None) -> None:
        """Prepare the page.

        Args:
            found: the campaign's folder.
            report: report of the trials that count.
            settling: state of the claim about the success rate; None without a claim.
        """
        self.folder, self._arguments = found.folder, found.arguments
        self._report, self._settling = report, settling
        self.skipped_bytes = 0
        """Size of the log's last line, in bytes, if its trial is missing because it is damaged."""

    @classmethod
    def of(cls, folder: Path) -> CampaignPage:
        """Return the page of a campaign that has ended or is still running.

        Raises:
            NoCampaign, TrialLogError: the folder cannot be read.
        """
        found = CampaignFolder.read_runs(folder)
        trials, said = found.trials(), found.arguments
        seeds = range(said["first"], said["first"] + said["trials"])
        settling = Settling.heard(said["until"], seeds, trials)
        page = cls(found, CampaignReport(trials if settling is None else trials[: settling.count]), settling)
        page.skipped_bytes = trials.skipped_bytes
        return page

    def write_runs(self) -> None:
        """Write the report pages of the worst trials, such as failed ones, if their runs can be read."""
        for trial in self._report.worst():
            run = self._run(trial.run_name)
            if run is not None and not (run / REPORT_FILE).exists():
                with suppress(HandcartError, OSError):
                    write_report(run)

    def write(self, path: Path | None = None) -> Path:
        """Write the page (default: `report.html` in the folder), and return its path.

        Raises:
            OSError: the file cannot be written.
        """
        path = path or self.folder / REPORT_FILE
        write_whole(path, self._page(path))
        return path

    def _page(self, path: Path) -> str:
        from jinja2 import Environment, PackageLoader

        report = self._report
        table = TrialTable(report.trials)
        names, rows, left_out = table.listed()
        worst = {trial.seed: self._link(path, trial.run_name, page=True) for trial in report.worst()}
        script = files(__package__).joinpath("sorting.js").read_text(encoding="utf-8")
        digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
        goal = self._goal()
        limits = self._limits()
        pages = Environment(loader=PackageLoader(__package__, ""), autoescape=True, trim_blocks=True)
        return pages.get_template("page.html").render(
            name=self._name,
            sentence=self._sentence(),
            about=", ".join(self._about()),
            report=report,
            count=len(report.trials),
            rate=self._rate(goal) if report.trials else None,
            verdicts=list(self._verdicts(goal)),
            chances=file_chances(Path(self._arguments["task"]), self._arguments["settings"]),
            most_blames=MOST_BLAMES,
            metrics=list(self._metrics(table, limits)),
            limited=any(name in limits for name in table.columns),
            same=", ".join(_same(table, limits)),
            worst=[self._first_look(trial, worst[trial.seed]) for trial in report.worst()],
            names=names,
            rows=[{"it": row, "link": worst.get(row.seed) or self._link(path, row.run)} for row in rows],
            left_out=left_out,
            script=script,
            script_hash=f"sha256-{digest}",
        )

    @property
    def _name(self) -> str:
        task = PurePath(self._arguments["task"])
        return task.parent.name or task.stem if task.stem == GENERIC_STEM else task.stem

    def _sentence(self) -> str:
        """Return the result in one sentence."""
        report, asked = self._report, self._arguments["trials"]
        count = len(report.trials)
        if not count:
            return f"{self._name}: no trial has ended yet."
        low, high = report.wilson
        bounds = f"95 % interval {100 * low:.1f} to {100 * high:.1f} %"
        share = f"reached the goal: {100 * report.successes / count:.1f} % ({bounds})"
        rest = f", {asked} were asked for" if count < asked else ""
        untrue = len(report.untrue)
        doubt = f"; the ground truth contradicts {untrue} of them" if untrue else ""
        most = f"; {_blamed(report)}" if report.blames else ""
        return f"{self._name}: {report.successes} of {count} trials{rest} {share}{doubt}{most}."

    def _about(self) -> Iterator[str]:
        said = self._arguments
        yield str(said["task"])
        yield from (f"{name}={value}" for name, value in said["settings"].items())
        if learned := said.get("learned_from"):
            yield f"no robot: actions end as in {', '.join(learned)}"
        elif said["level"] == "network":
            yield "network alone"
        else:
            yield f"backend {said['backend'] or 'of the task'}"
        yield f"seeds {said['first']} to {said['first'] + said['trials'] - 1}"
        for key in ("vary_file", "faults", "shard"):
            if said.get(key):
                yield f"{key.removesuffix('_file')} {said[key]}"
        yield from said["generate"]
        yield f"handcart {said['handcart']}"

    def _goal(self) -> float | str:
        if not self._report.trials:
            return "no trial has ended"
        return exact_goal(Path(self._arguments["task"]), self._arguments["settings"])

    def _rate(self, goal: float | str) -> dict[str, Any]:
        low, high = self._report.wilson
        shares = [low, high]
        exact = None if isinstance(goal, str) else goal
        limit = None if self._settling is None else self._settling.claim.limit
        axis = share_axis([*shares, *(item for item in (exact, limit) if item is not None)], RATE_WIDTH)
        return {
            "axis": axis,
            "measured": 100.0 * self._report.successes / len(self._report.trials),
            "low": 100.0 * low,
            "high": 100.0 * high,
            "exact": None if exact is None else 100.0 * exact,
            "limit": None if limit is None else 100.0 * limit,
            "claim": "" if self._settling is None else str(self._settling.claim),
        }

    def _verdicts(self, goal: float | str) -> Iterator[str]:
        if self._settling is not None:
            yield f"Claimed: {self._settling.words()}."
        if isinstance(goal, str):
            yield f"There is no exact value to compare with: {goal}."
        else:
            found = compare_share(goal, self._report.successes, len(self._report.trials))
            verdict = "they agree" if found.agrees else "they differ: the file's probabilities don't hold"
            tested = f"(exact test, p = {found.p_value:.3g})"
            yield f"handcart check computes {100 * goal:.2f} %: {verdict} {tested}."

    def _metrics(self, table: TrialTable, limits: Mapping[str, float]) -> Iterator[dict[str, Any]]:
        """Yield the metrics that differ between trials, or have a limit."""
        spreads = self._report.spreads()
        for name, values in table.columns.items():
            if name not in spreads:
                continue  # a value that varies is not a metric
            if constant(values) and name not in limits:
                continue
            limit = limits.get(name)
            words = _spread_words(spreads[name], name in self._report.tally.yes_no)
            if limit is not None:
                words += f"; at most {limit:g} is allowed"
            yield {"name": name, "words": words, "plot": histogram(values, table.success, limit)}

    def _limits(self) -> dict[str, float]:
        """Return the largest value of each metric that the ground truth accepts for a Success."""
        if self._arguments["level"] != "run":
            return {}
        from handcart.evaluation.judging.surveys import survey_kinds

        return {name: limit for kind in survey_kinds() for name, limit in kind.limits.items()}

    def _first_look(self, trial: Trial, link: str) -> dict[str, Any]:
        median = self._report.median_run
        differs = ""
        if median is not None and (found := first_difference(trial, median)):
            differs = found.words("it", f"the median run (seed {median.seed})")
        return {
            "seed": trial.seed,
            "outcome": trial.summary["outcome"],
            "why": "; ".join(trial.untrue) or trial.summary["reason"] or "with Fails",
            "differs": differs,
            "varied": ", ".join(f"{name} {value:g}" for name, value in trial.varied.items()),
            "faults": ", ".join(f"{fault['fault']} at {fault['at_s']:g} s" for fault in trial.faults),
            "rerun": rerun(self._arguments, trial.seed),
            "link": link,
        }

    def _run(self, name: str) -> Path | None:
        """Return the folder of a trial's run, or None if it does not exist."""
        folder = self.folder / RUNS / name
        return folder if name and folder.is_dir() else None

    def _link(self, page_path: Path, name: str, page: bool = False) -> str:
        """Return a link to a run's page or folder; empty if neither exists."""
        run = self._run(name)
        if run is None:
            return ""
        target = f"{os.path.relpath(run, page_path.absolute().parent)}/"
        return quote(target + (REPORT_FILE if page and (run / REPORT_FILE).exists() else ""))


def _same(table: TrialTable, limits: Mapping[str, float]) -> Iterator[str]:
    """Yield the metrics that have the same value in all trials, with that value."""
    for name, values in table.columns.items():
        there = values[np.isfinite(values)]
        if len(there) and constant(values) and name not in limits:
            yield f"{name} {short(float(there[0]))}"


def _blamed(report: CampaignReport) -> str:
    blame, times = report.blames[0]
    return f"what failed most is {blame.primitive} ({times} times: {blame.reason or blame.check})"


def _spread_words(spread: Spread, yes_no: bool) -> str:
    between = "" if spread.low is None or spread.high is None else f" ({spread.low:.4g} to {spread.high:.4g})"
    if yes_no:
        return f"yes in {100 * spread.mean:.1f} % of {spread.count} trials{between}"
    quantile = f"95 % at most {spread.most_95:.4g}, largest {spread.most:.4g}"
    return f"median {spread.median:.4g}{between}, {quantile}; {spread.count} trials"
