"""Real run folders, as they are when a run is killed, has ended, or has given up."""

from __future__ import annotations

import shutil
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import orjson
from typing_extensions import override

from handcart.backends.saved_state import digest, pack
from handcart.evaluation.trials.running import prepare_again, put_back, run_task
from handcart.networks.events.events import Ended, Event
from handcart.networks.events.run_observer import RunObserver
from handcart.networks.journal.journal import Journal
from handcart.networks.run_files.run_folder import JOURNAL_FILE, read_run_journal
from handcart.networks.runs.run_options import RunOptions
from handcart.networks.task.preparing import Prepared

LEFT, OVER, GAVE_UP = "left", "over", "gave up"


@dataclass(frozen=True)
class Recipe:
    """A run to take folders from."""

    name: str
    task: str
    """Path of the task in the tasks folder."""
    after: tuple[int, ...]
    """Actions after which it is left."""
    backend: str | None = None
    bench: str | None = None
    settings: tuple[tuple[str, str], ...] = ()
    whole: bool = False
    """True if the task is run to its end; otherwise it is left after the last of these actions."""
    weight: float = 1.0
    """Relative frequency with which its folders are chosen."""


_OF_BLOCKS = (("method", "fix_once"), ("look", "false"))
RUN_RECIPES = (
    Recipe("blocks", "stack_blocks/unload.yaml", (1, 3, 5), settings=_OF_BLOCKS, whole=True, weight=3.0),
    Recipe("first block", "stack_blocks/unload.yaml", (1,), settings=_OF_BLOCKS, weight=0.2),
    Recipe("field", "deploy_straight/task.yaml", (1,)),
    Recipe("seam", "track_seam/task.yaml", (1, 2)),
    Recipe("books", "return_book/task.yaml", (1, 2, 3), weight=0.4),
    Recipe("drives", "drive_map/task.yaml", (1,), "can", "kinematic", (("robot", "cart"),), weight=0.2),
    Recipe("physics", "stack_blocks/unload.yaml", (1, 2), "pybullet", weight=0.4),
)


@dataclass(frozen=True)
class Original:
    """A sound run folder."""

    folder: Path
    recipe: str
    kind: str
    weight: float
    state: str = ""
    """Digest of what its checkpoint holds, once put back."""


class Enough(BaseException):
    """A run is left where it is, as if it were killed."""


class Quiet(RunObserver):
    """Copies the folder of a run after some actions, and may leave it then."""

    def __init__(self, after: Sequence[int] = (), to: Path = Path(), whole: bool = True) -> None:
        self._after, self._to, self._whole, self._folder = after, to, whole, Path()

    @override
    def begin(self, prepared: Prepared, run_dir: Path) -> None:
        self._folder = run_dir

    def event(self, event: Event) -> None:
        """Copy what would be left if the run were killed now."""
        if isinstance(event, Ended) and event.number in self._after:
            _copy(self._folder, self._to / f"{event.number}")
            if not self._whole and event.number == max(self._after):
                raise Enough


def make(recipe: Recipe, tasks: Path, where: Path) -> list[Original]:
    """Run a recipe, and give its folders: left, over, and one that gave up."""
    copies = where / recipe.name
    with suppress(Enough):
        run_task(
            tasks / recipe.task,
            where / "runs",
            RunOptions(
                recipe.backend,
                dict(recipe.settings),
                seed=3,
                checkpoints=True,
                bench=recipe.bench,
                observers=(Quiet(recipe.after, copies, recipe.whole),),
            ),
        )
        (whole,) = (where / "runs").glob("*")
        _copy(whole, copies / OVER)
    shutil.rmtree(where / "runs")
    left = [copies / f"{item}" for item in recipe.after if (copies / f"{item}").is_dir()]
    gave_up = copies / "gave-up"
    _copy(left[0], gave_up)
    _give_up(gave_up)
    share = recipe.weight / (len(left) + 1)
    found = [Original(item, recipe.name, LEFT, share) for item in left]
    if (copies / OVER).is_dir():
        found.append(Original(copies / OVER, recipe.name, OVER, share / 2))
    found.append(Original(gave_up, recipe.name, GAVE_UP, share / 2))
    return found


def _copy(folder: Path, to: Path) -> None:
    shutil.copytree(folder, to, ignore=shutil.ignore_patterns("control*"))


def _give_up(folder: Path) -> None:
    """Append records as if the next action had given up."""
    contents = read_run_journal(folder)
    done = sum(record["kind"] == "START" for record in contents.records)
    plan = next(record for record in contents.records if record["kind"] == "PLAN")
    rows = contents.records[0]["plan_on"]["actions"]
    index = plan["way"][done]
    do, source, target, *_ = rows[index]
    action = {"index": index, "do": do, "from": source, "to": target, "with": {}}
    last = contents.records[-1]["t"]
    with Journal.go_on(folder / JOURNAL_FILE, contents) as journal:
        journal.append("START", last, {"n": done + 1, "action": action})
        fields = {"n": done + 1, "outcome": "GiveUp", "reason": "it fell", "residuals": {}}
        journal.append("RESULT", last, fields)
        journal.append("END", last, {"outcome": "GiveUp", "situation": source, "reason": "it fell"})


def state_of(prepared: Prepared) -> str:
    """Return a digest of the state of a run; the engine's own part has checks of its own."""
    backend = prepared.backend.state()
    kept = (
        {key: value for key, value in backend.items() if key != "engine"} if isinstance(backend, dict) else {}
    )
    return digest(pack({"backend": kept, "robot": prepared.robot.state(), "model": prepared.model.state()}))


def key_of(header: Mapping[str, Any]) -> bytes:
    """Return the key that two headers share if their runs continue alike."""
    names = ("task_path", "backend", "settings", "seed", "start", "errors", "bench")
    return orjson.dumps({name: header[name] for name in names})


def true_state(original: Original, scratch: Path) -> str:
    """Digest of what is put back from a sound folder; of one that is over, without its end."""
    folder = scratch / "state"
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(original.folder, folder)
    lines = (folder / JOURNAL_FILE).read_bytes().splitlines(keepends=True)
    ends = 0 if original.kind == LEFT else 1 if original.kind == OVER else 3
    (folder / JOURNAL_FILE).write_bytes(b"".join(lines[: len(lines) - ends]))
    header, prepared = prepare_again(folder)
    with prepared:
        put_back(folder, header, prepared)
        return state_of(prepared)
