"""The packages come from this checkout, and what documents show exists."""

from __future__ import annotations

import importlib
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


@pytest.mark.parametrize(
    "name", ["robotics", "files", "backends", "primitives", "networks", "evaluation", "tools", "tasks"]
)
def test_each_package_is_this_checkouts(name: str) -> None:
    assert Path(str(importlib.import_module(name).__file__)).parent == ROOT / name


@pytest.mark.parametrize(
    "document",
    [
        "README.md",
        "docs/tasks.md",
        "docs/primitives.md",
        "docs/backends.md",
        "docs/hardware.md",
        "docs/explain.md",
        "docs/conformance.md",
        "docs/faults.md",
        "docs/robots.md",
    ],
)
def test_links_lead_somewhere(document: str) -> None:
    path = ROOT / document
    links = re.findall(r"\]\(([^)#]+)\)", path.read_text(encoding="utf-8"))
    missing = [link for link in links if not link.startswith("http") and not (path.parent / link).exists()]
    assert missing == []


@pytest.mark.parametrize("document", ["README.md", "docs/tasks.md"])
def test_tasks_in_documents_are_right(tmp_path: Path, document: str) -> None:
    from handcart.networks.run import prepare

    text = (ROOT / document).read_text(encoding="utf-8")
    blocks = [each for each in re.findall(r"```yaml\n(.*?)```", text, re.S) if "handcart-task/" in each]
    for source in (ROOT / "tasks" / "return_book").iterdir():
        if source.is_file():
            (tmp_path / source.name).write_bytes(source.read_bytes())
    for block in blocks:
        (tmp_path / "shown.yaml").write_text(block, encoding="utf-8")
        with prepare(tmp_path / "shown.yaml") as prepared:
            assert prepared.task.network.goal == "at_shelf"
    assert len(blocks) == 1


@pytest.mark.parametrize(
    "document",
    [
        "README.md",
        "docs/tasks.md",
        "docs/primitives.md",
        "docs/backends.md",
        "docs/explain.md",
        "docs/conformance.md",
        "docs/faults.md",
        "docs/robots.md",
    ],
)
def test_commands_in_documents_exist(document: str) -> None:
    from handcart.tools.command_line import COMMANDS

    shown = re.findall(r"`handcart ([\w-]+)", (ROOT / document).read_text(encoding="utf-8"))
    assert set(shown) <= set(COMMANDS)
    assert document != "README.md" or set(shown) == set(COMMANDS)
