"""Mutants that no test can kill, each with the reason why: `equivalent.yaml`."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from drawing import DrawnMutant
from ruamel.yaml import YAML

EQUIVALENT_FILE = Path(__file__).with_name("equivalent.yaml")


def read_equivalents(table: Path = EQUIVALENT_FILE) -> Mapping[tuple[str, str, str], str]:
    """Return the reason of each equivalent mutant, by its file, its changed lines and what they become."""
    entries = YAML(typ="safe").load(table.read_text(encoding="utf-8")) or []
    return {(entry["file"], entry["before"], entry["after"]): entry["reason"] for entry in entries}


def key_of(mutant: DrawnMutant) -> tuple[str, str, str]:
    """Return what a mutant is listed by."""
    return mutant.file, mutant.before, mutant.after
