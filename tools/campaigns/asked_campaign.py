"""A campaign requested from a shell or from Python: checked before anything moves."""

from __future__ import annotations

import tempfile
from collections.abc import Generator, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from handcart.backends.registry import check_seed
from handcart.evaluation.campaigns.campaign import run_campaign
from handcart.evaluation.campaigns.campaign_setting import CampaignSetting, Level, WorldGenerator
from handcart.evaluation.campaigns.data.campaign_folder import RUNS, CampaignFolder
from handcart.evaluation.campaigns.data.trial_log import TrialLog
from handcart.evaluation.campaigns.data.walked_trials import WalkedSequence
from handcart.evaluation.campaigns.rare.rare_event import RareEvent
from handcart.evaluation.campaigns.statistics.campaign_report import CampaignReport
from handcart.evaluation.campaigns.statistics.claim import RateClaim, Settling
from handcart.evaluation.campaigns.trial_run import walked_trials
from handcart.evaluation.campaigns.variation import Variation, load_variation
from handcart.files.errors import InputError
from handcart.networks.task.task_file import Task, load_task

if TYPE_CHECKING:
    from handcart.evaluation.campaigns.learned.learned import Learned
    from handcart.evaluation.campaigns.statistics.walk_tally import WalkTally

CAMPAIGN_LEVELS: Mapping[str, Level] = {"run": "run", "fitted": "fitted", "network": "network"}


class NotPossible(InputError):
    """Error of campaign options that are invalid, alone or together; raised before any run begins."""


@dataclass(frozen=True, kw_only=True)
class AskedCampaign:
    """Settings of a campaign that a user starts, one for each option of the command `handcart campaign`."""

    task: Path
    trials: int = 20
    first: int = 0
    backend: str | None = None
    settings: Mapping[str, str] = field(default_factory=dict)
    generate: Sequence[str] = ()
    out: Path | None = None
    shard: str | None = None
    until: str | None = None
    vary: Path | None = None
    faults: Path | None = None
    level: str = "run"
    learned_from: Sequence[Path] = ()
    runs: Path | None = None
    rare: str | None = None
    importance: str | None = None
    population: int | None = None

    @contextmanager
    def opened(self) -> Iterator[OpenCampaign]:
        """Check the arguments, and yield the campaign with its folder.

        Without a folder in the arguments, a temporary one is used, which is removed when the context ends.

        Raises:
            InputError: an argument is invalid, as the message states; nothing has moved.
            TrialLogError: the folder's trials cannot be read, or written.
        """
        self._check()
        worlds = _worlds(self.generate) if self.generate else None
        claim = None if self.until is None else RateClaim.of(self.until)
        needed = self.out is not None or self.vary is not None or self.learned_from
        read = load_task(self.task, self.settings) if needed else None
        learned = self._learned(read)
        setting = self._setting(worlds, self._variation(read))
        arguments = self._arguments(setting, claim)
        with ExitStack() as stack:
            if self.out is None:
                folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
                log = TrialLog(folder / "trials.jsonl", sync=False)
            else:
                assert read is not None
                log = CampaignFolder.made(self.out, {**arguments, **_made_of(setting, read)}).log()
            stack.enter_context(log)
            seeds = self._seeds()
            settling = None if claim is None else Settling(claim, seeds)
            yield OpenCampaign(setting, seeds, arguments, log, settling, self.out, learned)

    def _learned(self, task: Task | None) -> Learned | None:
        """Return the outcomes learned from campaign folders, validated on held-out trials; None without such
        folders.
        """
        if not self.learned_from or task is None:
            return None
        from handcart.evaluation.campaigns.learned.learned import Learned

        learned = Learned.read(task, self.learned_from)
        learned.check()
        return learned

    def _check(self) -> None:
        walks = self.level != "run"
        if self.level not in CAMPAIGN_LEVELS:
            raise NotPossible(f"--level {self.level}; allowed: {', '.join(CAMPAIGN_LEVELS)}")
        if (self.level == "fitted") != bool(self.learned_from):
            raise NotPossible("--level fitted and --learned-from; needed: both of them, or none")
        if self.learned_from and self.vary is not None:
            raise NotPossible(
                "--level fitted --vary; allowed: one of them, observed outcomes don't vary with it"
            )
        if walks and self.generate:
            raise NotPossible(
                f"--level {self.level} --generate; allowed: one of them, a network has no world"
            )
        if self.vary is not None and self.generate:
            raise NotPossible("--vary --generate; allowed: one of them, a generated world has no file")
        if self.shard is not None and self.out is None:
            raise NotPossible("--shard without --out; needed: the folder for this part")
        if self.shard is not None and self.until is not None:
            raise NotPossible("--until --shard; allowed: one of them, a part alone can't settle it")
        check_seed(self.first, "--first")
        check_seed(self.first + max(0, self.trials - 1), "--first: the last trial's seed")
        self._check_rare()
        if self.faults is not None:
            from handcart.evaluation.campaigns.fault_plan import load_faults

            load_faults(self.faults)
            if walks:
                raise NotPossible(
                    f"--level {self.level} --faults; allowed: one of them, a network has no robot"
                )
        self._seeds()

    def _check_rare(self) -> None:
        if self.rare is None:
            if self.importance is not None or self.population is not None:
                raise NotPossible("--importance, --population; needed: --rare with them")
            return
        others = {
            "--until": self.until,
            "--vary": self.vary,
            "--faults": self.faults,
            "--generate": self.generate,
        }
        if other := next((name for name, given in others.items() if given), None):
            raise NotPossible(f"--rare {other}; allowed: one of them")
        if self.level == "fitted":
            wrong = "allowed: run, network; some hundred trials don't show what comes once in thousands"
            raise NotPossible(f"--rare --level fitted; {wrong}")
        if self.first < 0:
            raise NotPossible(f"--rare --first {self.first}; allowed: 0 and more")
        RareEvent.of(self.rare, self.importance, self.population)

    def _seeds(self) -> range:
        """Return the seeds that this process has to run."""
        seeds = range(self.first, self.first + self.trials)
        if self.shard is None:
            return seeds
        number, _, count = self.shard.partition("/")
        if not (number.isdecimal() and count.isdecimal() and 1 <= int(number) <= int(count)):
            raise NotPossible(f"--shard {self.shard}; allowed: K/N with K from 1 to N, such as 3/40")
        return seeds[int(number) - 1 :: int(count)]

    def _variation(self, task: Task | None) -> Variation | None:
        """Return the variation, whose entries are numbers in the task's files."""
        if self.vary is None or task is None:
            return None
        varied = load_variation(self.vary, task)
        if varied.design == "latin_hypercube" and self.first < 0:
            wrong = f"--first {self.first} with the design latin_hypercube of --vary"
            raise NotPossible(f"{wrong}; allowed: 0 and more")
        return varied

    def _setting(self, worlds: WorldGenerator | None, varied: Variation | None) -> CampaignSetting:
        runs = self.runs or (Path(RUNS) if self.out is None else self.out / RUNS)
        every = range(0) if varied is None else range(self.first, self.first + self.trials)
        return CampaignSetting(
            self.task,
            self.backend,
            self.settings,
            worlds,
            runs,
            CAMPAIGN_LEVELS[self.level],
            varied,
            every,
            self.faults,
            tuple(self.learned_from),
            None if self.rare is None else RareEvent.of(self.rare, self.importance, self.population),
        )

    def _arguments(self, setting: CampaignSetting, claim: RateClaim | None) -> dict[str, Any]:
        """Return the arguments as kept in the campaign's folder."""
        return {
            "task": str(self.task),
            "backend": self.backend,
            "settings": dict(self.settings),
            "generate": sorted(self.generate),
            "first": self.first,
            "trials": self.trials,
            "level": self.level,
            "learned_from": [str(path) for path in self.learned_from],
            "vary_file": None if self.vary is None else str(self.vary),
            "vary": None if setting.varied is None else setting.varied.model_dump(mode="json"),
            "faults": None if self.faults is None else str(self.faults),
            "until": None if claim is None else str(claim),
            "shard": self.shard,
            "rare": None if setting.rare is None else asdict(setting.rare),
        }


@dataclass
class OpenCampaign:
    """Campaign whose arguments were checked, and which can be run or continued."""

    setting: CampaignSetting
    seeds: range
    arguments: dict[str, Any]
    log: TrialLog
    settling: Settling | None
    """State of a sequential test; None: no claim is tested."""
    out: Path | None
    learned: Learned | None = None
    """Learned outcomes from which trials are drawn."""
    _counted: WalkTally | None = None

    def run(self, jobs: int | None, cluster: str | None = None) -> Generator[int, None, None]:
        """Run the missing trials until all are done or the claim `until` is decided; yield numbers of new
        trials.

        Trials without a robot are random walks through the network. If they are not stored and no claim is
        tested, they are counted in batches of thousands; each of them can be repeated by its seed.

        Args:
            jobs: number of parallel processes; None: 1 for random walks, otherwise 2.
            cluster: address of a Dask scheduler, or path of its file; its workers run the trials instead.

        Raises:
            InputError: both `jobs` and `cluster` are given.
            HandcartError: a trial cannot be run or stored.
            KeyboardInterrupt: the user ended the campaign.
        """
        if cluster is not None and jobs is not None:
            raise NotPossible(
                "--cluster --jobs; allowed: one of them, the cluster sets the number of processes"
            )
        if self.in_one_process:
            from handcart.evaluation.campaigns.statistics.walk_tally import WalkTally

            self._counted = WalkTally(walked_trials(self.setting), self.seeds)
            yield from self._counted.count_all()
            return
        jobs = jobs or (1 if self.setting.walks else 2)
        if self.settling is not None and any(self.settling.hear(item) for item in self.log.trials()):
            return
        with closing(run_campaign(self.setting, self.seeds, jobs, self.log, cluster)) as running:
            for trial in running:
                yield 1
                if self.settling is not None and self.settling.hear(trial):
                    return

    @property
    def in_one_process(self) -> bool:
        """True if the trials are random walks that are counted in this process, in batches of thousands."""
        alone = self.setting.walks and not (self.setting.varied or self.setting.rare)
        return alone and self.out is None and self.settling is None

    @property
    def done(self) -> int:
        """Number of the campaign's trials that have ended so far."""
        return len(self.log) if self._counted is None else self._counted.count

    def report(self) -> CampaignReport:
        """Return the report on the campaign's trials.

        If the campaign tests a claim about the success rate, the report covers only the trials up to the one
        after which the claim was accepted or rejected.
        """
        holds = None if self.settling is None else self.settling.verdict
        if self._counted is not None:
            walked = WalkedSequence(self._counted.trials, self.seeds[: self._counted.count])
            return CampaignReport(walked, holds, self._counted)
        trials = self.log.trials()
        return CampaignReport(trials if self.settling is None else trials[: self.settling.count], holds)

    def write_page(self, report: CampaignReport, runs: bool = True) -> Path | None:
        """Write the campaign's page into its folder, and return the page's path.

        Args:
            report: report returned by `report`.
            runs: True to write pages of the most interesting runs, too.

        Returns:
            The path; None without a folder, and for a campaign of a rare event, which has no page.

        Raises:
            OSError: the page cannot be written.
        """
        if self.out is None or self.setting.rare is not None:
            return None
        from handcart.evaluation.campaigns.page.campaign_page import CampaignPage

        page = CampaignPage(CampaignFolder.read(self.out), report, self.settling)
        if runs:
            page.write_runs()
        return page.write()


def _made_of(setting: CampaignSetting, task: Task) -> dict[str, Any]:
    """Return the version and checksums of files that decide how a campaign's trials end."""
    from importlib.metadata import version

    from handcart.evaluation.campaigns.campaign_files import checksums

    return {"handcart": version("handcart"), "files": checksums(setting, task)}


def _worlds(words: Sequence[str]) -> WorldGenerator:
    """Return the generator of worlds with these options, from the domain that defines its name."""
    from handcart.files.suggest import suggest
    from handcart.tasks.domain import domains, imported
    from handcart.tools.terminal.typed_model import typed_model

    known = {name: path for domain in domains() for name, path in domain.worlds.items()}
    named = [word.partition(".") for word in words]
    name = named[0][0]
    if other := next((item for item, _, _ in named if item != name), None):
        raise NotPossible(f"--generate {name} and {other}; allowed: worlds of one kind")
    if name not in known:
        raise NotPossible(f"--generate {name}: unknown kind of generated world{suggest(name, known)}")
    options = [option for _, _, option in named if option]
    worlds: WorldGenerator = typed_model(imported(known[name]), options, f"--generate {name}")
    return worlds
