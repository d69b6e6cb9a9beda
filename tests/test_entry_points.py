"""Primitives and backends from outside, by entry point: those that the documents show."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from handcart.backends import registry as backends
from handcart.evaluation.conformance.checks.all_checks import checks
from handcart.evaluation.conformance.rig.bench import KitBench
from handcart.files.plugins import BrokenPlugin
from handcart.primitives import registry as primitives
from handcart.tasks.domain import BrokenDomain, domains

ROOT = Path(__file__).resolve().parents[1]


def shown(document: str, name: str) -> str:
    """The code block of a document that defines a class."""
    text = (ROOT / document).read_text(encoding="utf-8")
    blocks: list[str] = re.findall(r"```python\n(.*?)```", text, re.S)
    return next(block for block in blocks if f"class {name}(" in block)


def install(folder: Path, document: str) -> None:
    """A distribution with what the documents show, as pip would leave it in `folder`."""
    (folder / "forward.py").write_text(shown(document, "Forward"), encoding="utf-8")
    (folder / "ideal.py").write_text(shown("docs/how_to/backends.md", "Ideal"), encoding="utf-8")
    info = folder / "outside-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: outside\nVersion: 1.0\n", encoding="utf-8")
    points = "[handcart.primitives]\nFORWARD = forward:Forward\nGONE = gone:Gone\n"
    points += "[handcart.backends]\nideal = ideal:Ideal\n"
    (info / "entry_points.txt").write_text(points, encoding="utf-8")


def handcart(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """`handcart ...` where the distribution of `folder` is installed."""
    env = os.environ | {"PYTHONPATH": str(folder)}
    command = [sys.executable, "-m", "handcart", *words]
    return subprocess.run(command, env=env, cwd=ROOT, capture_output=True, text=True, check=False)


@pytest.mark.slow
@pytest.mark.parametrize("document", ["README.md", "docs/how_to/primitives.md"])
def test_a_primitive_of_another_package_runs(tmp_path: Path, document: str) -> None:
    install(tmp_path, document)
    said = handcart(tmp_path, "do", "FORWARD", "distance_m=0.3")
    assert said.returncode == 0, said.stderr
    assert said.stdout.startswith("Success")


@pytest.mark.slow
def test_it_is_listed_and_one_that_is_broken_hides_no_others(tmp_path: Path) -> None:
    install(tmp_path, "README.md")
    said = handcart(tmp_path, "list", "primitives")
    assert said.returncode == 0, said.stderr
    listed = dict(line.split(maxsplit=1) for line in said.stdout.splitlines())
    assert listed["FORWARD"] == "Drive straight on for a while."
    assert listed["GONE"] == "can't be imported: No module named 'gone'"
    assert "MOVE_TO" in listed


PLANTS = "[handcart.domains]\nplants = garden:DOMAIN\n"
UNUSABLE = "the domain 'plants' of the package outside can't be used: {}; allowed: to mend the package"


@pytest.mark.parametrize(
    ("code", "wrong"),
    [
        ("", "AttributeError: module 'garden' has no attribute 'DOMAIN'"),
        ("DOMAIN = 7", "garden:DOMAIN is no Domain"),
        (
            "from handcart.tasks.domain import Domain\nDOMAIN = Domain('books')",
            "there is another domain of the name 'books'",
        ),
        (
            "from handcart.tasks.domain import Domain\nDOMAIN = Domain('walls', {'STACK': 'walls:Stack'})",
            "another domain has the primitive STACK already",
        ),
    ],
)
def test_a_broken_domain_is_told_with_its_package(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, code: str, wrong: str
) -> None:
    outside(tmp_path, code, PLANTS)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "garden", raising=False)
    with pytest.raises(BrokenDomain) as raised:
        domains.__wrapped__()
    assert UNUSABLE.format(wrong) in str(raised.value)
    assert raised.value.exit_status == 2


@pytest.mark.slow
def test_a_domain_that_ends_the_process_is_told_with_its_package(tmp_path: Path) -> None:
    outside(tmp_path, "raise SystemExit(0)", PLANTS)
    said = handcart(tmp_path, "list", "primitives")
    message = UNUSABLE.format("it ends the process when it is imported (SystemExit: 0)")
    assert (said.returncode, said.stdout, message in said.stderr) == (2, "", True), said.stderr


@pytest.mark.slow
def test_a_backend_of_another_package_is_asked_what_it_can_do(tmp_path: Path) -> None:
    install(tmp_path, "README.md")
    said = handcart(tmp_path, "do", "FORWARD", "distance_m=0.3", "--backend", "ideal")
    assert said.returncode == 2
    assert said.stderr.endswith("the robot has no RangeSensor; it has: Base\n")


def test_the_documents_backend_drives() -> None:
    from handcart.backends.loading.robot_loading import load_robot
    from handcart.backends.robot.robot import Robot
    from handcart.robotics.geometry.pose2 import Pose2

    code: dict[str, type] = {}
    exec(shown("docs/how_to/backends.md", "Ideal"), code)
    spec = load_robot("librarian")
    with code["Ideal"].build(spec, None, 0) as backend:  # type: ignore[attr-defined]
        robot = Robot(backend, spec, Pose2(0.0, 0.0, 0.0))
        for _ in range(40):
            robot.base.drive(0.5, 0.0)
            robot.step()
        robot.step()  # not renewed, the command is over
        assert robot.pose.x == pytest.approx(1.0)


def wheels_only(folder: Path) -> Path:
    """The cart's file as docs/how_to/backends.md says: without range sensor and CAN drives."""
    source = ROOT / "backends" / "robots" / "cart"
    (folder / "cart.urdf").write_bytes((source / "cart.urdf").read_bytes())
    text = (source / "robot.yaml").read_text(encoding="utf-8")
    kept = re.sub(r"(?m)^(range_sensor|can):.*\n(?:[ \t].*\n|\n)*", "", text)
    path = folder / "wheels.yaml"
    wheels = "odometry: {wheel_radius_percent: 0.2, tread_percent: 0.2, slip_percent: 0.2}\n"
    path.write_text(kept.replace("localizer: scan ", "localizer: odometry ") + wheels, encoding="utf-8")
    return path


@pytest.mark.slow
def test_documents_backend_keeps_the_contract(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In all checks of the kit, made in this process."""
    install(tmp_path, "README.md")
    bench = KitBench("ideal", str(wheels_only(tmp_path)))
    monkeypatch.syspath_prepend(tmp_path)
    with fresh_registries():
        found = {name: check(bench) for name, check in checks().items()}
    assert [f"{name}: {finding.wrong}" for name, finding in found.items() if not finding.ok] == []
    made = {name for name, finding in found.items() if not finding.skipped}
    assert made >= {"base", "limits", "stop", "one period", "close", "snapshot"}


@pytest.mark.slow
def test_the_documents_tests_pass(tmp_path: Path) -> None:
    source = shown("docs/how_to/primitives.md", "Forward")
    text = (ROOT / "docs/how_to/primitives.md").read_text(encoding="utf-8")
    tests = [block for block in re.findall(r"```python\n(.*?)```", text, re.S) if "def test_" in block]
    for number, block in enumerate(tests):
        (tmp_path / f"test_{number}.py").write_text(f"{source}\n\n{block}", encoding="utf-8")
    words = [sys.executable, "-m", "pytest", "-q", "-W", "error", "-p", "no:cacheprovider", "."]
    said = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert said.returncode == 0, said.stdout + said.stderr
    assert "4 passed" in said.stdout


def outside(folder: Path, code: str, points: str) -> None:
    """A distribution with one module, as pip would leave it in `folder`."""
    (folder / "garden.py").write_text(code, encoding="utf-8")
    info = folder / "outside-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: outside\nVersion: 1.0\n", encoding="utf-8")
    (info / "entry_points.txt").write_text(points, encoding="utf-8")


SHIPPED = {
    "backend": ("handcart.backends", "kinematic", "handcart.backends.kinematic.kinematic_backend"),
    "primitive": ("handcart.primitives", "MOVE_TO", "handcart.primitives.driving.move_to"),
}


@pytest.mark.parametrize("kind", SHIPPED)
def test_a_shipped_name_is_not_replaced_silently(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str
) -> None:
    group, name, module = SHIPPED[kind]
    outside(tmp_path, "class Mine: pass", f"[{group}]\n{name} = garden:Mine\n")
    monkeypatch.syspath_prepend(tmp_path)
    with fresh_registries() as class_of, pytest.raises(BrokenPlugin) as raised:
        class_of[kind](name)
    assert module in str(raised.value)
    assert f"the name {name!r} in {group}" in str(raised.value)
    assert "garden:Mine of the package outside" in str(raised.value)
    assert raised.value.exit_status == 2


@pytest.mark.parametrize("kind", SHIPPED)
@pytest.mark.parametrize(
    ("code", "wrong"),
    [("raise SystemExit(1)", "it ends the process when it is imported"), ("1 / 0", "ZeroDivisionError")],
)
def test_a_plugin_that_cannot_be_imported_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str, code: str, wrong: str
) -> None:
    name = SHIPPED[kind][1] + "_2"
    outside(tmp_path, code, f"[{SHIPPED[kind][0]}]\n{name} = garden:Mine\n")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "garden", raising=False)
    with fresh_registries() as class_of:
        assert class_of[kind](SHIPPED[kind][1])  # the others continue
        with pytest.raises(BrokenPlugin, match=wrong):
            class_of[kind](name)


@contextmanager
def fresh_registries() -> Iterator[dict[str, Callable[[str], type]]]:
    """Functions that return a class by its name; the path is read again, and forgotten after the test."""
    cached = (backends._all, primitives._all, primitives._own)
    for item in cached:
        item.cache_clear()
    try:
        yield {"backend": backends.backend_class, "primitive": primitives.primitive_class}
    finally:
        for item in cached:
            item.cache_clear()


@pytest.mark.parametrize("module", ["handcart", "handcart.tools.main"])
def test_the_command_line_runs_as_a_module(module: str) -> None:
    words = [sys.executable, "-m", module, "no-such-command"]
    said = subprocess.run(words, capture_output=True, text=True, check=False)
    assert said.returncode == 2
    assert "no-such-command" in said.stderr
