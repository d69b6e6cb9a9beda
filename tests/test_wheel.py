"""The wheel holds `handcart` alone, and gets on with projects that have rooms of the same names."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path
from zipfile import ZipFile

import pytest

ROOT = Path(__file__).resolve().parents[1]
ROOMS = ("robotics", "files", "backends", "primitives", "networks", "evaluation", "tasks", "tools")
OURS = (*ROOMS, "src", "pyproject.toml", "README.md", "LICENSE")
TEST = """
import files.mine
import tools


def test_rooms_of_its_own():
    assert tools.MINE and files.mine.MINE


def test_our_fixture(do_primitive):
    from handcart.primitives.driving.stand import Stand

    assert type(do_primitive(Stand(seconds=1.0))).__name__ == "Success"
"""


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel, made from a copy of the checkout, without any network."""
    folder = tmp_path_factory.mktemp("wheel")
    for name in OURS:
        if (ROOT / name).is_dir():
            ignored = shutil.ignore_patterns("__pycache__", "*.egg-info")
            shutil.copytree(ROOT / name, folder / "copy" / name, symlinks=True, ignore=ignored)
        else:
            shutil.copy(ROOT / name, folder / "copy" / name)
    words: list[str | Path] = [
        "pip",
        "wheel",
        "-q",
        "--no-deps",
        "--no-build-isolation",
        "--no-index",
        "-w",
        folder,
        folder / "copy",
    ]
    ended = subprocess.run([sys.executable, "-m", *words], capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stderr
    (made,) = folder.glob("*.whl")
    return made


@pytest.mark.slow
def test_it_holds_one_name_and_every_file(wheel: Path) -> None:
    names = set(ZipFile(wheel).namelist())
    tops = {name.split("/")[0] for name in names}
    assert {top for top in tops if not top.endswith(".dist-info")} == {"handcart"}
    kept = (".py", ".yaml", ".urdf", ".png", ".eds", ".csv", ".html")
    ours = {
        f"handcart/{path.relative_to(ROOT)}"
        for room in ROOMS
        for path in (ROOT / room).rglob("*")
        if path.suffix in kept
    }
    assert {"handcart/__init__.py", "handcart/__main__.py", "handcart/py.typed"} <= names
    assert ours - names == set()


@pytest.mark.slow
def test_a_project_with_the_same_rooms_runs_its_tests(wheel: Path, tmp_path: Path) -> None:
    ZipFile(wheel).extractall(tmp_path / "site")
    project = tmp_path / "project"
    for room in (*ROOMS, "tests"):
        (project / room).mkdir(parents=True)
        (project / room / "__init__.py").write_text("MINE = True\n", encoding="utf-8")
        (project / room / "mine.py").write_text("MINE = True\n", encoding="utf-8")
    (project / "tests" / "test_mine.py").write_text(TEST, encoding="utf-8")
    surroundings = os.environ | {"PYTHONPATH": str(tmp_path / "site")}
    words: list[str | Path] = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider"]
    ended = subprocess.run(words, cwd=project, env=surroundings, capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stdout + ended.stderr
    assert "2 passed" in ended.stdout
    code = "import handcart.primitives as room; print(room.__file__)"
    ended = subprocess.run(
        [sys.executable, "-c", code],
        cwd=tmp_path,
        env=surroundings,
        capture_output=True,
        text=True,
        check=True,
    )
    assert ended.stdout.startswith(str(tmp_path / "site"))
