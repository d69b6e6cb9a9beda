"""Check makers' URDFs and mutants: `python -m benchmarks.hostile.makers_urdfs FOLDER... --mutants 300`.

Each URDF under the folders is checked as it is, drafted as a robot and checked as that, by `handcart
check` in a process of its own; a robot without a fault is then built and stepped on simulated backends.
Without a folder: the shipped robots, and those that come with PyBullet. Exit status 1 if one is not
reported clearly: another status than 0 or 2, a traceback, output on stderr beside `--json`, a finding
without its place in the URDF, more lines than a person reads, no end in time, or a backend that raises
another error than one of bad input.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import multiprocessing
import os
import random
import re
import resource
import shutil
import signal
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from importlib.util import find_spec
from multiprocessing.connection import Connection
from multiprocessing.context import ForkProcess
from pathlib import Path
from typing import NamedTuple

from benchmarks.damage.mutated_urdfs import mutated

ROBOTS_FOLDER = Path(__file__).parents[2] / "backends" / "robots"
DRIVE_TEXT = """\
drive: {wheel_radius_m: 0.1, tread_m: 0.5, top_speed_m_s: 0.5, top_turn_deg_s: 60, acceleration_m_s2: 0.5,
        turn_acceleration_deg_s2: 90}
"""
STEP_PERIODS = 3  # periods that a backend is stepped
MAX_LINES = 60  # default number of printed lines
NAMED_CAUSE = re.compile(r"link|joint|URDF|mesh|xacro|well-formed|DOCTYPE|character|stand at")
CRASH_WORDS = re.compile(r"status (5|1|-)|a traceback|it crashed")
PROGRESS_WORDS = re.compile(r"checking .* \.\.\.$")
"""Progress line of a command that takes long, as it may on a busy machine."""
LOOK_PERIOD = 4  # of the checks of printed messages
WALL_TIME_RATIO = 20  # times as long as a processor's time it may take on a busy machine


class Case(NamedTuple):
    """A URDF to look at."""

    path: Path
    text: str | None
    """Text that replaces the file's; None: the file is used as it is."""
    what: str
    people: bool
    """True if the output without `--json` and `--allow` are tested too."""
    backends: tuple[str, ...] = ()
    """On which the robot drafted from it is built."""


class Seen(NamedTuple):
    """Result of one case."""

    statuses: tuple[int, ...]
    violations: tuple[str, ...]
    seconds: float


def main() -> None:
    """Print progress, and everything that is not reported clearly."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", nargs="*", type=Path)
    parser.add_argument("--mutants", type=int, default=300)
    parser.add_argument("--most", type=int, default=1_000_000, help="URDFs as they are")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--limit-s", type=int, default=60, help="of a processor's time for one")
    parser.add_argument("--build", default="kinematic", help="backends that robots are built on, or none")
    given = parser.parse_args()
    folders = given.folders or [ROBOTS_FOLDER, *_package_folders("pybullet_data")]
    backends = tuple(part for part in given.build.split(",") if part not in ("", "none"))
    with tempfile.TemporaryDirectory(prefix="urdfs-", dir=os.environ.get("TMPDIR")) as scratch:
        copies = [_linked(folder, Path(scratch) / str(n)) for n, folder in enumerate(folders)]
        cases = [
            case._replace(backends=backends) for case in _cases(copies, given.mutants, given.most, given.seed)
        ]
        sys.exit(_look(cases, given.jobs, given.limit_s))


def _package_folders(name: str) -> list[Path]:
    """Return the folders of an installed package; none where it is not installed."""
    spec = find_spec(name)
    return (
        [Path(location) for location in (spec.submodule_search_locations or ())] if spec is not None else []
    )


def _linked(folder: Path, target: Path) -> Path:
    """Link the files into another folder without copying them: a draft is written beside each URDF."""

    def link(source: str, to: str) -> None:
        try:
            os.link(source, to)
        except OSError:
            shutil.copyfile(source, to)

    shutil.copytree(folder, target, copy_function=link, symlinks=False, ignore_dangling_symlinks=True)
    return target


def _cases(folders: list[Path], mutants: int, most: int, seed: int) -> list[Case]:
    found = [path for folder in folders for path in sorted(folder.rglob("*.urdf"))]
    rng = random.Random(seed)
    chosen = found if len(found) <= most else sorted(rng.sample(found, most))
    cases = [Case(path, None, "as it is", n % LOOK_PERIOD == 0) for n, path in enumerate(chosen)]
    # A thousand copies that differ in a mesh are one kind of robot.
    kinds = [path for path in found if "random_urdfs" not in path.parts]
    while mutants > 0:
        path = rng.choice(kinds)
        try:
            text, what = mutated(path.read_text(encoding="utf-8"), rng.randrange(1 << 30))
        except (SyntaxError, UnicodeDecodeError):
            continue
        cases.append(Case(path, text, what, mutants % LOOK_PERIOD == 0))
        mutants -= 1
    # Group by robot, robots in any order, so that early output covers all kinds.
    order = {path: rng.random() for path in {case.path: None for case in cases}}
    return sorted(cases, key=lambda case: order[case.path])


def _look(cases: list[Case], jobs: int, limit: int) -> int:
    statuses: Counter[tuple[int, ...]] = Counter()
    bad, crashed, slowest = 0, 0, (0.0, "")
    for number, (case, seen) in enumerate(_all(cases, jobs, limit), start=1):
        statuses[seen.statuses] += 1
        slowest = max(slowest, (seen.seconds, str(case.path)))
        crashed += any(CRASH_WORDS.search(violation) for violation in seen.violations)
        for violation in seen.violations:
            bad += 1
            print(f"\r{case.path}, {case.what}: {violation}")
        print(f"\r{number} of {len(cases)}, {bad} violations", end="", flush=True)
    print(f"\n{len(cases)} URDFs: {bad} violations; slowest {slowest[0]:.1f} s, {slowest[1]}")
    print(f"of these {sum(case.text is not None for case in cases)} mutated; status 5: {crashed}")
    print("statuses (URDF; robot drafted from it; and with --allow):")
    for key, count in sorted(statuses.items()):
        print(f"  {', '.join(map(str, key)):<12} {count}")
    return 1 if bad else 0


def _all(cases: list[Case], jobs: int, limit: int) -> Iterator[tuple[Case, Seen]]:
    """Yield each case with its result, each in a forked process of its own, so that crashes are seen."""
    for name in (
        "handcart.tools.main",
        "handcart.tools.commands.check_file",
        "handcart.tools.checks.check_robot",
        "handcart.evaluation.robot_report.report",
    ):
        __import__(name)
    __import__("handcart.evaluation.robot_report.urdf_report")
    context = multiprocessing.get_context("fork")
    running: list[tuple[Case, ForkProcess, Connection, float]] = []
    waiting, warm = list(reversed(cases)), None
    while waiting or running:
        while waiting and len(running) < jobs:
            case = waiting.pop()
            if case.path != warm:
                warm = case.path
                _read_meshes(warm)
            mine, theirs = context.Pipe(duplex=False)
            process = context.Process(target=_child, args=(case, theirs, limit))
            process.start()
            theirs.close()
            running.append((case, process, mine, time.monotonic()))
        for entry in list(running):
            case, process, mine, begun = entry
            passed = time.monotonic() - begun
            ready = mine.poll(0.02)
            if not ready and process.is_alive() and passed < WALL_TIME_RATIO * limit:
                continue
            running.remove(entry)
            yield case, _result(mine, process, passed, limit)


def _read_meshes(path: Path) -> None:
    """Read the meshes once for all processes that are forked from here."""
    from handcart.backends.urdf.robot_parts import read_part
    from handcart.files.errors import HandcartError

    with contextlib.suppress(HandcartError, ValueError, OSError):  # reported by each forked `check`
        read_part(path.name, path.parent)


def _result(mine: Connection, process: ForkProcess, passed: float, limit: int) -> Seen:
    try:
        if mine.poll(0.0):
            seen: Seen = mine.recv()
            process.join(10.0)
            return seen
    except EOFError:
        pass  # it ended without an answer: its exit code says why
    process.kill()
    process.join()
    late = passed >= WALL_TIME_RATIO * limit or process.exitcode == -signal.SIGXCPU
    why = f"no end in {limit} s" if late else f"it crashed: {process.exitcode}"
    return Seen((-1,), (why,), passed)


def _child(case: Case, answer: Connection, limit: int) -> None:
    resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 5))
    path = case.path
    if case.text is not None:
        path = path.with_name(f"{path.stem}.mutant-{os.getpid()}.urdf")
        path.write_text(case.text, encoding="utf-8")
    draft = path.with_name(f"{path.stem}.robot-{os.getpid()}.yaml")
    try:
        begun = time.process_time()
        seen = _checked(path, draft, case.people, case.backends)._replace(seconds=time.process_time() - begun)
    finally:
        draft.unlink(missing_ok=True)
        if case.text is not None:
            path.unlink(missing_ok=True)
    answer.send(seen)


def _checked(path: Path, draft: Path, people: bool = True, backends: tuple[str, ...] = ()) -> Seen:
    status, violations = _check(path, path.name, "--draft", str(draft), people=people)
    statuses = [status]
    if status == 0:
        if "\ndrive:" not in draft.read_text(encoding="utf-8"):
            with draft.open("a", encoding="utf-8") as file:  # as a person has to
                file.write(DRIVE_TEXT)
        status, more = _check(draft, path.name, people=people)
        violations += [f"as a robot: {item}" for item in more]
        statuses.append(status)
        if status == 0 and people:
            status, more = _check(draft, path.name, "--allow", json_too=False)
            violations += [f"with --allow: {item}" for item in more]
            statuses.append(status)
        if statuses[1] == 0:
            violations += [wrong for backend in backends for wrong in _built(draft, backend)]
    return Seen(tuple(statuses), tuple(violations), 0.0)


def _built(draft: Path, backend: str) -> Iterator[str]:
    """Yield what is wrong with a robot built in an empty world and stepped with commands to its arm."""
    from handcart.backends.capabilities.arm import Arm
    from handcart.backends.loading.robot_loading import load_robot
    from handcart.backends.registry import make_backend
    from handcart.files.errors import HandcartError

    world = draft.with_suffix(".world.yaml")
    world.write_text("format: handcart-world/1\nstart: {x_m: 0, y_m: 0, heading_deg: 0}\n", encoding="utf-8")
    try:
        robot = make_backend(backend, load_robot(str(draft)), world, 0)
        arm = robot.get(Arm)  # type: ignore[type-abstract]
        for _ in range(STEP_PERIODS):
            if arm is not None:
                arm.move(arm.command())
            robot.step()
        robot.close()
    except HandcartError as error:
        if error.exit_status != 2:
            yield f"status {error.exit_status} on {backend}: {error}"
    except Exception as error:
        yield f"status 5 on {backend}: {type(error).__name__}: {' '.join(str(error).split())[:300]}"
    finally:
        world.unlink(missing_ok=True)


def _check(
    path: Path, urdf: str, *options: str, json_too: bool = True, people: bool = True
) -> tuple[int, list[str]]:
    status, out, err = _said("check", str(path), *options, *(["--json"] if json_too else []))
    wrong = []
    if status not in (0, 2):
        wrong.append(f"status {status}: {' '.join(err.split())[-300:]}")
    if "Traceback" in err + out:
        wrong.append("a traceback")
    if json_too:
        err = "\n".join(line for line in err.splitlines() if not PROGRESS_WORDS.match(line))
        if err.strip():
            wrong.append(f"on stderr: {err.strip()[:200]}")
        wrong += _of_json(status, out, urdf)
        out, err = _for_people(status, path, wrong) if people else ("", "")
    # `--allow` reports its changes on stderr, a line a pair.
    if (lines := len((out if "--allow" in options else out + err).splitlines())) > MAX_LINES:
        wrong.append(f"{lines} lines")
    return status, wrong


def _for_people(status: int, path: Path, wrong: list[str]) -> tuple[str, str]:
    """Return the output without `--json`; for a sound robot, the output of `--allow`."""
    if status == 0 and path.suffix != ".urdf":
        return "", ""
    again, out, err = _said("check", str(path))
    if again != status:
        wrong.append(f"status {again} without --json")
    return out, err


def _of_json(status: int, out: str, urdf: str) -> Iterator[str]:
    try:
        report = json.loads(out.splitlines()[-1])
    except (ValueError, IndexError):
        yield f"no JSON: {out[:100]!r}"
        return
    if status == 2:
        findings = report.get("findings", [])
        if report.get("ok") or not findings:
            yield "status 2 without a finding"
        for finding in findings:
            if finding["line"] < 1 or not str(finding["file"]).endswith((urdf, ".yaml")):
                yield f"no place: {finding}"
            elif not NAMED_CAUSE.search(finding["message"]):
                yield f"names no link or joint: {finding['message']}"


def _said(*words: str) -> tuple[int, str, str]:
    """Return a command's status and output, including that of libraries below Python."""
    from handcart.tools.main import main as handcart

    out = io.StringIO()
    with tempfile.TemporaryFile() as heard:
        kept = os.dup(2)
        sys.stderr.flush()
        os.dup2(heard.fileno(), 2)
        err, sys.stderr = sys.stderr, os.fdopen(os.dup(2), "w", buffering=1)
        try:
            with contextlib.redirect_stdout(out):
                handcart(list(words))
            status = 0
        except SystemExit as end:
            status = int(end.code or 0)
        finally:
            sys.stderr.close()
            sys.stderr = err
            os.dup2(kept, 2)
            os.close(kept)
        heard.seek(0)
        return status, out.getvalue(), heard.read().decode(errors="replace")


if __name__ == "__main__":
    main()
