"""Commands without the libraries of arms and labels: those that need none run, the others name the extra."""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest

from handcart.files.extras import EXTRA_MODULES, lack
from handcart.files.shown_path import shown_path
from handcart.tools.terminal.libraries import IMPORT_NAMES, Requirement, check_libraries, required
from tests.tools.conftest import Said

ROOT = Path(__file__).resolve().parents[2]
DRIVE_MAP, RETURN_BOOK = (str(ROOT / "tasks" / name / "task.yaml") for name in ("drive_map", "return_book"))
ARM, LABELS = EXTRA_MODULES["arm"], EXTRA_MODULES["labels"]
WITHOUT = """
import atexit, sys

asked = []

class Missing:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {names!r}:
            asked.append(name)
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)

sys.meta_path.insert(0, Missing())
if {tells_asked}:
    atexit.register(lambda: print("asked for", asked))
from handcart.tools.main import main
main({words!r})
"""
NEEDS_ARM = "needs pinocchio, ompl, toppra, fcl, not installed; install with: pip install 'handcart[arm]'\n"


def without(names: Sequence[str], *words: str, tells_asked: bool = False) -> subprocess.CompletedProcess[str]:
    """`handcart ...` where these modules can't be imported; the last line may tell which were asked for."""
    code = WITHOUT.format(names=(*names, "coal"), words=list(words), tells_asked=tells_asked)
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)


def test_the_extras_are_those_of_the_project() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = project["optional-dependencies"]
    modules = {"pin": "pinocchio", "python-fcl": "fcl"}
    modules |= dict.fromkeys(("ros-rclpy", "ros-rmw-fastrtps-cpp", "ros-common-interfaces"), "rclpy")
    modules |= {"arro3-core": "arro3", "arro3-io": "arro3", "foxglove-sdk": "foxglove"}
    for extra, brought in EXTRA_MODULES.items():
        names = [re.split("[>;]", item)[0] for item in extras[extra]]
        assert {modules.get(item, item) for item in names} == set(brought)
    beside = [extra for extra in EXTRA_MODULES if extra != "ros2"]  # it needs an environment of its own
    assert f"handcart[{','.join((*beside, 'docs'))}]" in extras["dev"]
    assert IMPORT_NAMES["python-fcl"] == "fcl"


@pytest.mark.slow
def test_a_base_asks_for_no_libraries_of_arms_and_labels(tmp_path: Path) -> None:
    """So it loads none of them where they are installed."""
    words = ("run", DRIVE_MAP, "--robot", "cart", "--set", "tour=[desk]", "--runs", str(tmp_path))
    said = without((*ARM, *LABELS), *words, tells_asked=True)
    assert said.returncode == 0, said.stderr
    assert said.stdout.startswith("Success")
    assert said.stdout.splitlines()[-1] == "asked for []"


@pytest.mark.slow
@pytest.mark.parametrize("command", ["check", "run"])
def test_a_task_for_an_arm_says_what_to_install(command: str) -> None:
    said = without((*ARM, *LABELS), command, RETURN_BOOK)
    assert (said.returncode, said.stdout) == (2, "")
    file = re.escape(shown_path(RETURN_BOOK))
    assert re.search(rf"{file}:\d+:10: RECOGNIZE {re.escape(NEEDS_ARM)}$", said.stderr)


def test_world_model_sections_need_no_libraries_of_arms_and_labels() -> None:
    """So a check reads every file of a task, and names the primitives that lack one."""
    code = WITHOUT.format(names=(*ARM, *LABELS, "coal"), words=["list", "primitives"], tells_asked=False)
    code = code.partition("from handcart.tools.main")[0] + (
        "from handcart.primitives.knowledge.sections import sections\nprint(*sections())"
    )
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert "objects" in said.stdout.split(), said.stderr


@pytest.mark.slow
def test_a_robot_with_an_arm_says_what_to_install() -> None:
    said = without(ARM, "run", DRIVE_MAP)
    file = ROOT / "backends" / "robots" / "librarian" / "robot.yaml"
    assert (said.returncode, said.stdout) == (2, "")
    *before, message = said.stderr.splitlines(keepends=True)
    assert message.startswith(f"{shown_path(file)}:")
    assert message.endswith(f": an arm {NEEDS_ARM}")
    assert all(line.startswith("loading ") for line in before)  # said after a second, on a slow machine


@pytest.mark.slow
@pytest.mark.parametrize("library", LABELS)
def test_labels_say_what_to_install(library: str) -> None:
    said = without([library], "check", RETURN_BOOK)
    how = f"SEARCH needs {library}, not installed; install with: pip install 'handcart[labels]'\n"
    assert (said.returncode, said.stdout) == (2, "")
    assert said.stderr.endswith(how)
    own_lines = [line for line in said.stderr.splitlines() if not line.startswith("checking ")]
    assert len(own_lines) == 1  # besides the word that it computes, on a slow machine


@pytest.mark.slow
def test_a_primitive_that_lacks_a_library_hides_no_others() -> None:
    said = without(ARM, "list", "primitives")
    listed = dict(line.split(maxsplit=1) for line in said.stdout.splitlines())
    assert listed["PICK_UP"].startswith("can't be imported: No module named 'ompl'")
    assert listed["MOVE_TO"].startswith("Drive the base to a named place")
    said = without(ARM, "describe", "PICK_UP")
    assert said.returncode == 2
    assert "the library ompl can't be imported: No module named 'ompl'; to install: " in said.stderr
    assert said.stderr.endswith("-m pip install 'handcart[arm]'\n")


@pytest.mark.slow
def test_a_mesh_that_collides_says_what_to_install(tmp_path: Path) -> None:
    urdf = (ROOT / "backends" / "robots" / "cart" / "cart.urdf").read_text(encoding="utf-8")
    solid = '<collision><origin xyz="0 0 0.415"/><geometry><cylinder radius="0.33" length="0.27"/></geometry>'
    mesh = '<collision><geometry><mesh filename="body.obj"/></geometry>'
    assert solid in urdf
    (tmp_path / "cart.urdf").write_text(urdf.replace(solid, mesh), encoding="utf-8")
    (tmp_path / "body.obj").write_text("v 0 0 0\n", encoding="utf-8")
    robot = ROOT / "backends" / "robots" / "cart" / "robot.yaml"
    (tmp_path / "robot.yaml").write_bytes(robot.read_bytes())
    said = without(ARM, "check", str(tmp_path / "robot.yaml"))
    assert said.returncode == 2
    assert f"link 'base': mesh 'body.obj': a mesh that collides {NEEDS_ARM}" in said.stderr


@pytest.mark.slow
def test_a_library_that_is_there_but_broken_is_not_called_missing(tmp_path: Path) -> None:
    (tmp_path / "ompl.py").write_text("raise ImportError('broken', name=__name__)", encoding="utf-8")
    code = f"import sys; sys.path.insert(0, {str(tmp_path)!r}); from handcart.tools.main import main; "
    code += f"main(['check', {RETURN_BOOK!r}])"
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert said.returncode == 2
    assert "the library ompl can't be imported: broken; to install: " in said.stderr


def test_of_extras_only_what_is_installed_must_be_new_enough(
    handcart: Callable[..., Said], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "pin-2.7.dist-info").mkdir()
    info = tmp_path / "handcart-0.1.0.dist-info"
    info.mkdir()
    lines = [
        "Requires-Dist: numpy>=2.0",
        'Requires-Dist: pin>=3.4; extra == "arm"',
        'Requires-Dist: no-such-library>=1.0; extra == "arm"',
        'Requires-Dist: pybullet>=3.2.7; python_version < "3.12" and extra == "sim"',
        'Requires-Dist: no-such-tool>=1.0; extra == "dev"',
    ]
    (info / "METADATA").write_text("\n".join(["Name: handcart", *lines, "", "text"]), encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    assert [requirement.extra for requirement in required()] == ["", "arm", "arm", "sim"]
    said = handcart("list", "backends")
    assert said.status == 2
    assert "the library pin is 2.7; needed: >=3.4; to install: " in said.err
    assert "no-such" not in said.err
    (tmp_path / "pin-2.7.dist-info").rename(tmp_path / "pin-3.4.dist-info")
    check_libraries()
    assert str(Requirement("pin", ">=3.4", "arm")) == "pin>=3.4"


def test_nothing_is_lacking_here() -> None:
    assert [lack("a test", extra) for extra in ("arm", "labels")] == [None, None]
