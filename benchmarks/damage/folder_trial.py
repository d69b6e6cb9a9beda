"""One attack on one folder: all that reads run folders reads it, watched."""

from __future__ import annotations

import os
import random
import shutil
import sys
import tempfile
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from handcart.backends.saved_state import NotAState
from handcart.evaluation.trials.running import prepare_again, put_back, resume_task
from handcart.evaluation.viewing.explanation.explanation import as_json, explain
from handcart.evaluation.viewing.explanation.explanation_chart import draw_chart
from handcart.evaluation.viewing.explanation.explanation_words import in_words
from handcart.files.errors import HandcartError
from handcart.files.models.loading import load
from handcart.networks.operator.acknowledging import acknowledge
from handcart.networks.operator.control import ask
from handcart.networks.past_runs.past_run import read_run
from handcart.networks.run_files.run_folder import check_folder
from handcart.networks.runs.calibration import CALIBRATION_FILE, Calibration
from handcart.networks.runs.resuming import task_of
from handcart.networks.runs.run_options import RunOptions
from handcart.networks.task.preparing import Prepared

from .folder_attacks import FOLDER_ACCIDENTS, FOLDER_ATTACKS, Attack, Scene, nothing
from .originals import LEFT, Original, Quiet, key_of, state_of

_RUNS = ("os.system", "os.exec", "os.posix_spawn", "os.spawn", "subprocess.Popen", "pickle.find_class")
_CHANGES = (
    "os.rename",
    "os.remove",
    "os.mkdir",
    "os.rmdir",
    "os.link",
    "os.symlink",
    "os.truncate",
    "os.chmod",
)
_WRITES = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
_CHARTS, _ENDS = 40, 400
"""Every so many folders a chart is drawn, and a run goes on to its end."""


@dataclass
class Watch:
    """Notes what a process does that reading a folder must not do, by Python's audit events."""

    allowed: Sequence[Path]
    """Folders in which writing is allowed."""
    forbidden: Path
    """File that must not be opened."""
    seen: list[str] = field(default_factory=list)
    on: bool = False

    def __call__(self, event: str, words: tuple[Any, ...]) -> None:
        """Record an audit event that a reader of run folders must not cause."""
        if not self.on:
            return
        if event in _RUNS and not (event == "pickle.find_class" and _compiling()):
            self.seen.append(f"{event} {words!r}"[:200])
        elif event == "open" and isinstance(words[0], str | bytes | os.PathLike):
            flags = words[2] or 0
            self._opened(words[0], bool(flags & _WRITES), bool(flags & os.O_NOFOLLOW))
        elif event in _CHANGES:
            if len(words) > 1 and isinstance(words[-1], int) and words[-1] >= 0:
                return  # relative to an open folder, whose opening was seen
            for word in words[:2]:
                if isinstance(word, str | bytes | os.PathLike) and not _cache(word):
                    self._opened(Path(os.fsdecode(word)).parent, True)

    def _opened(self, path: Any, writes: bool, refuses_links: bool = False) -> None:
        named = Path(os.fsdecode(path))
        real = (
            Path(os.path.realpath(named.parent)) / named.name
            if refuses_links
            else Path(os.path.realpath(named))
        )
        if real.is_relative_to(self.forbidden):
            self.seen.append(f"{real} was opened")
        elif writes and not (any(real.is_relative_to(item) for item in self.allowed) or _cache(real)):
            self.seen.append(f"{real} was written")


def _cache(path: Any) -> bool:
    """Return True if Python or Numba keeps compiled code at this path."""
    return "__pycache__" in Path(os.fsdecode(path)).parts


def _compiling() -> bool:
    """Return True if Numba is reading its compiled code."""
    frame: Any = sys._getframe()
    while frame is not None:
        if frame.f_globals.get("__name__", "").startswith(("numba", "llvmlite")):
            return True
        frame = frame.f_back
    return False


@dataclass(frozen=True)
class Verdict:
    """Result of one attack."""

    number: int
    attack: str
    original: str
    ended: str
    """End of `resume`: put back, continued, or the class of the refusal."""
    wrong: tuple[str, ...]


class Trials:
    """Attacks on copies of originals, one after the other, each drawn from a seed and its number."""

    def __init__(self, originals: Sequence[Original], work: Path, seed: int) -> None:
        """`work` is an empty folder for copies."""
        self._originals, self._seed = originals, seed
        self._work, self._outside = work, work / "outside"
        self._made: dict[bytes, Prepared] = {}
        import matplotlib

        matplotlib.get_configdir()  # it makes that folder at the first request, and no watcher exists yet
        (work / "temporary").mkdir()
        tempfile.tempdir = str(work / "temporary")
        caches = [Path(tempfile.tempdir), Path.home() / ".cache", Path.home() / ".config" / "matplotlib"]
        self._watch = Watch([work / "run", *caches, Path("/dev/null")], self._outside)
        sys.addaudithook(self._watch)

    def run(self, number: int) -> Verdict:
        """Attack a folder, read it, look."""
        rng = random.Random(self._seed * 1_000_003 + number)
        original = rng.choices(self._originals, [item.weight for item in self._originals])[0]
        attack: Attack = rng.choice(FOLDER_ACCIDENTS if rng.random() < 0.5 else FOLDER_ATTACKS)
        folder = self._set_out(original)
        canary = self._work / "run" / "canary"
        attack(Scene(folder, self._outside, canary, self._originals, rng))
        before = _contents(self._outside)
        name = f"{original.recipe} {original.folder.name}"
        tried = _Tried(self, folder, original, attack, rng, number)
        with self._watched():
            wrong = tried.all()
        wrong += [item for item in self._watch.seen if not _harmless(item)]
        if canary.exists():
            wrong.append("code ran")
        if _contents(self._outside) != before:
            wrong.append("something outside was changed")
        return Verdict(number, attack.__name__, name, tried.ended, tuple(wrong))

    def prepared(self, folder: Path) -> tuple[Any, Prepared]:
        """Return the robot for a folder; one that was made before, where it would be the same."""
        header = task_of(folder)
        key = key_of(header) if header.keys() >= {"start", "bench"} else b""
        if key not in self._made:
            self._made[key] = prepare_again(folder)[1]
        return header, self._made[key]

    def forget(self) -> None:
        """Close the robots, so that new ones are built: one of them was put into an odd state."""
        for item in self._made.values():
            item.backend.close()
        self._made.clear()

    def close(self) -> None:
        """Let go of all robots."""
        self.forget()

    def _set_out(self, original: Original) -> Path:
        for item in (self._work / "run", self._outside):
            shutil.rmtree(item, ignore_errors=True)
        folder = self._work / "run" / original.folder.name
        shutil.copytree(original.folder, folder)
        (self._outside / "folder").mkdir(parents=True)
        (self._outside / "secret.txt").write_text("nobody reads this\n", encoding="utf-8")
        return folder

    @contextmanager
    def _watched(self) -> Iterator[None]:
        self._watch.seen.clear()
        self._watch.on = True
        try:
            yield
        finally:
            self._watch.on = False


class _Tried:
    """The faces, one after the other."""

    def __init__(
        self,
        trials: Trials,
        folder: Path,
        original: Original,
        attack: Attack,
        rng: random.Random,
        number: int,
    ) -> None:
        self._trials, self._folder, self._original = trials, folder, original
        self._attack, self._rng, self._number = attack, rng, number
        self._wrong: list[str] = []
        self.ended = ""

    def all(self) -> list[str]:
        """Return what is wrong; empty if nothing is."""
        self._answered("explain", self._explain)
        self._answered("status", lambda: ask(self._folder, {"do": "status"}, 1.0))
        self.ended = self._answered("resume", self._resume)
        if self._attack is nothing and (self.ended == "put back") is not (self._original.kind == LEFT):
            self._wrong.append(f"resume: a sound folder ends with {self.ended}")
        self._answered("adopt", self._adopt)
        self._answered("ack", lambda: acknowledge(self._folder, self._rng.randrange(12)))
        return self._wrong

    def _answered(self, face: str, act: Callable[[], object]) -> str:
        try:
            ended = act()
        except HandcartError as error:
            if not str(error) or error.exit_status not in (2, 5, 6):
                self._wrong.append(f"{face}: {type(error).__name__} without words")
            return type(error).__name__
        except Exception:
            last = traceback.format_exc().splitlines()
            self._wrong.append(
                f"{face}: {last[-1][:200]} ({'; '.join(item.strip() for item in last[-5:-1])})"
            )
            return "traceback"
        return str(ended)[:40]

    def _explain(self) -> None:
        run = read_run(self._folder)
        numbers = [action.number for action in run.actions]
        explanation = explain(run, self._rng.choice([None, *numbers]))
        in_words(explanation, None)
        as_json(explanation, None)
        if self._number % _CHARTS == 0:
            path = self._folder / "chart.svg"
            path.unlink(missing_ok=True)
            draw_chart(explanation, path)

    def _resume(self) -> str:
        to_the_end = self._original.recipe == "blocks" and self._number % _ENDS < _ENDS // 100
        if to_the_end and self._attack is not nothing:
            return str(resume_task(self._folder, None, RunOptions(observers=(Quiet(),)))[0]["outcome"])
        header, prepared = self._trials.prepared(self._folder)
        sound = self._attack in FOLDER_ACCIDENTS
        try:
            past = put_back(self._folder, header, prepared)
        except NotAState as error:
            if "needed: " not in str(error) or not sound:
                raise
            self._trials.forget()  # possibly rejected only because that robot has begun another run
            header, prepared = self._trials.prepared(self._folder)
            past = put_back(self._folder, header, prepared)
        if sound and past.checkpoint is not None and not self._true(header, prepared):
            self._wrong.append("resume: restored at another pose")
        if not sound and self._original.recipe == "physics":
            self._trials.forget()  # an engine's world that was put somewhere odd
        return "put back"

    def _true(self, header: Any, prepared: Prepared) -> bool:
        if state_of(prepared) == self._original.state:
            return True
        self._trials.forget()
        header, prepared = self._trials.prepared(self._folder)
        put_back(self._folder, header, prepared)
        return state_of(prepared) == self._original.state

    def _adopt(self) -> None:
        check_folder(self._folder)
        path = self._folder / CALIBRATION_FILE
        if path.is_file():
            load(path, Calibration)


def _contents(folder: Path) -> dict[str, object]:
    """Return each path in a folder with its modification time, size and number of links."""
    return {
        str(path): (path.lstat().st_mtime_ns, path.lstat().st_size, path.lstat().st_nlink)
        for path in sorted(folder.rglob("*"))
    }


def _harmless(words: str) -> bool:
    return words.endswith("/dev/null was written")
