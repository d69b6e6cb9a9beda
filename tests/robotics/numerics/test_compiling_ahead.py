"""Other processes compile functions that a first run needs later."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest

from handcart.robotics.numerics import compiling_ahead as ahead

ROOT = Path(__file__).parents[3]
NEAR = "handcart.backends.simulation.body.near_pairs"
RUNS = """\
import sys
from pathlib import Path
import numpy as np
from handcart.backends.loading.robot_loading import load_robot
from handcart.evaluation.trials.running import run_task
from handcart.networks.runs.run_options import RunOptions
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.mapping.line_matching import match_surfaces
from handcart.robotics.navigation.mapping.scan_surface import fit_surface
from handcart.robotics.navigation.maps.grid_map import from_boxes
from handcart.robotics.navigation.tracking.moving_tracks import BodyTrack, MovingTracks
from handcart.robotics.navigation.tracking.people import People, with_people
from handcart.robotics.navigation.tracking.seen_free import PastScan
from handcart.robotics.navigation.tracking.yielding import safe_share, yielding_speed
from handcart.robotics.numerics.compiled import COMPILED_AHEAD
from handcart.robotics.numerics.compiling_ahead import types_of

run_task(Path("tasks/track_seam/task.yaml"), Path(sys.argv[1]), RunOptions())
robot = load_robot("librarian")
arm, home = robot.arm_model(), np.array(robot.posture("home"))
list(arm.solutions(arm.forward(home), home + 0.1, restarts=2))
tracks, walker = MovingTracks(6.0), np.array([[2.0, 0.0], [2.0, 0.05]])
beams = np.radians(np.arange(360.0)), np.full(360, 5.0)
for time in (0.0, 0.3):
    tracks.take(walker, PastScan(time, Pose2(0.0, 0.0, 0.0), *beams), np.eye(3))
track = BodyTrack(1, walker[0], np.zeros(2), np.eye(4), 0.3, True, 0.0)
safe_share(Pose2(0.0, 0.0, 0.0), (0.5, 0.0), People.of([track]), 0.3, 1.0, 0.05)
yielding_speed(walker, 1.0, People.of([track]), 0.3, 0.3)
with_people(from_boxes([], 0.1, (0.0, 0.0), (3.0, 3.0)), People.of([track]), np.zeros(2), 0.3, 0.3)
wall = fit_surface(np.column_stack([np.full(40, 2.0), np.linspace(-1.0, 1.0, 40)]), np.zeros(2))
match_surfaces(wall, wall, Pose2(0.0, 0.0, 0.0))
kernels = [each for module in COMPILED_AHEAD.values() for each in module]
assert len(kernels) >= 8
wrong = [kernel for kernel, types in kernels if kernel.dispatcher.signatures != [types_of(types)]]
print(*(kernel.__name__ for kernel in wrong))
"""
CHECK_OF_A_TASK = """\
from pathlib import Path
from handcart.networks.task import preparing
from handcart.robotics.manipulation.arms.screw_table import SCREW_TABLE_TYPES, screw_table
from handcart.robotics.numerics.compiled import COMPILED_AHEAD
from handcart.robotics.numerics.compiling_ahead import types_of
from handcart.tools.commands.check_file import file_facts

check, known_first = preparing.check, []

def watched(*given: object, **named: object) -> object:
    known_first.extend(kernel for module in COMPILED_AHEAD.values() for kernel, _ in module)
    return check(*given, **named)

preparing.check = watched
file_facts(Path("tasks/stack_blocks/task.yaml"), {})
print(screw_table in known_first)
print(screw_table.dispatcher.signatures == [types_of(SCREW_TABLE_TYPES)])
"""
DIES = """\
import os, signal
import numba
from handcart.robotics.numerics import compiling_ahead as ahead

ahead._cores = lambda: 2
ahead.COMPILED_AHEAD.clear()
ahead.COMPILED_AHEAD["takes_a_minute"] = []
with ahead.compiling_ahead():
    numba.njit(lambda x: x + 1.0)(1.0)
    print(open(f"/proc/self/task/{os.getpid()}/children").read(), flush=True)
    os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.mark.slow
def test_it_is_compiled_for_what_runs_call_it_with(tmp_path: Path) -> None:
    """And for nothing else; what the task does not need is called by itself."""
    words = [sys.executable, "-c", RUNS, str(tmp_path)]
    said = subprocess.run(words, cwd=ROOT, stdout=subprocess.PIPE, text=True, check=True, timeout=300)
    assert said.stdout == "\n", "these are called with other types"


@pytest.mark.slow
def test_another_process_leaves_machine_code_on_disk(tmp_path: Path) -> None:
    """It imports nothing from its working folder."""
    (tmp_path / "random.py").write_text("raise SystemExit\n", encoding="utf-8")
    words = [sys.executable, "-P", "-m", ahead.__name__, NEAR]
    env = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "code")}
    with subprocess.Popen(words, env=env, cwd=tmp_path, stdin=subprocess.PIPE) as process:
        assert process.wait(timeout=120) == 0
    kept = {path.name.split("-")[0] for path in tmp_path.rglob("*.nbi")}
    assert kept == {"near_pairs._near_boxes", "near_pairs.near_spheres"}


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="no /proc: a process's children aren't told")
def test_helpers_end_with_a_run_that_is_killed(tmp_path: Path) -> None:
    (tmp_path / "takes_a_minute.py").write_text("import time\ntime.sleep(60.0)\n", encoding="utf-8")
    path = os.pathsep.join(filter(None, (str(tmp_path), os.environ.get("PYTHONPATH"))))
    env = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path), "PYTHONPATH": path}
    said = subprocess.run(
        [sys.executable, "-c", DIES], env=env, stdout=subprocess.PIPE, text=True, timeout=120, check=False
    )
    assert said.returncode == -signal.SIGKILL
    (helper,) = said.stdout.split()
    until = time.monotonic() + 30.0
    while _runs(int(helper)) and time.monotonic() < until:
        time.sleep(0.05)
    assert not _runs(int(helper))


def _runs(process: int) -> bool:
    try:
        return "\nState:\tZ" not in Path(f"/proc/{process}/status").read_text(encoding="utf-8")
    except OSError:
        return False


class Begun:
    """Stub of a process: its arguments."""

    every: list["Begun"]

    def __init__(self, words: list[str], **_: Any) -> None:
        self.words, self.ended = words, 0
        self.every.append(self)

    def kill(self) -> None:
        self.ended += 1

    def communicate(self) -> None:
        assert all(item.ended for item in self.every)
        self.ended += 1


@pytest.mark.parametrize(("cores", "processes"), [(1, 0), (2, 1), (3, 2), (64, 3)])
def test_cores_that_are_free_take_what_is_needed_last(
    monkeypatch: pytest.MonkeyPatch, cores: int, processes: int
) -> None:
    monkeypatch.setattr(Begun, "every", [], raising=False)
    monkeypatch.setattr(subprocess, "Popen", Begun)
    monkeypatch.setattr(ahead, "_cores", lambda: cores)
    monkeypatch.setattr(ahead, "COMPILED_AHEAD", {"first": [], "second": [], "third": []})
    kernel = _kernel()
    with ahead.compiling_ahead():
        assert not Begun.every  # nothing has been compiled
        assert kernel(1.0) == 2.0
        kernel(np.float32(1.0))  # once more: they are at it already
        shares = [item.words[4:] for item in Begun.every]
        assert len(shares) == processes
        if shares:
            assert sorted(name for share in shares for name in share) == ["first", "second", "third"]
            assert shares[0][0] == "third"
        assert all(item.ended == 0 for item in Begun.every)
    assert all(item.ended == 2 for item in Begun.every)


def test_where_no_process_can_be_started_it_is_compiled_here(monkeypatch: pytest.MonkeyPatch) -> None:
    tried = []

    def refused(*words: Any, **_: Any) -> None:
        tried.append(words)
        raise BlockingIOError(11, "Resource temporarily unavailable")

    monkeypatch.setattr(subprocess, "Popen", refused)
    monkeypatch.setattr(ahead, "_cores", lambda: 4)
    kernel = _kernel()
    with ahead.compiling_ahead():
        assert kernel(1.0) == 2.0
        assert kernel(np.float32(1.0)) == 2.0
    assert len(tried) == 1


def _kernel() -> Any:
    """Not kept on disk."""

    def doubled(x: float) -> float:
        return 2.0 * x

    return numba.njit(doubled)


@pytest.mark.slow
def test_a_check_knows_the_domains_kernels_before_the_map_s() -> None:
    """The arm's functions take longest: another core begins with them while the map is checked here."""
    command = [sys.executable, "-c", CHECK_OF_A_TASK]
    ended = subprocess.run(command, cwd=ROOT, check=True, timeout=120, capture_output=True, text=True)
    assert ended.stdout.splitlines()[-2:] == ["True", "True"]


def test_functions_that_a_caller_asked_for_are_compiled_first(monkeypatch: pytest.MonkeyPatch) -> None:
    """A caller of another module's functions needs them soon; other modules may never be used."""
    begun: list[list[str]] = []

    class Started:
        def __init__(self, words: list[str], **_: object) -> None:
            begun.append(words)

    def kernel() -> None: ...

    monkeypatch.setattr(ahead, "_cores", lambda: 2)
    monkeypatch.setattr(subprocess, "Popen", Started)
    asked = {kernel.__module__: [(kernel, "()")], "asks": [(kernel, "()")], "imported_last": []}
    monkeypatch.setattr(ahead, "COMPILED_AHEAD", asked)
    list(ahead._begin(list(asked)))
    assert begun[0][-3:] == ["asks", "imported_last", kernel.__module__]
