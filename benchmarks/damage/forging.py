"""Forge a journal or a checkpoint with changed content and correct checksums."""

from __future__ import annotations

import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import orjson

from handcart.backends.saved_state import digest, pack, unpack
from handcart.networks.journal.journal_record import FIRST_CHECKSUM, read_journal, seal
from handcart.networks.run_files.run_folder import JOURNAL_FILE

ODD_VALUES: tuple[Any, ...] = (
    *(None, True, False, 0, -1, 1, 7, 2**31, 2**63 - 1, -(2**63), 0.0, -0.5, 1e300, -1e300, 3.25),
    *("", "../../../etc/passwd", "\x1b[2J", "\u202e", "x" * 5000, "%s%n", "__import__('os').system('x')"),
    *([], {}, [[]], {"a": 1}, [None] * 50, {"n": {"n": {}}}, [1e308, -1e308], {"": ""}),
)
"""Unexpected values for any field."""
_ARRAYS: tuple[Callable[[np.ndarray], Any], ...] = (
    lambda a: np.full_like(a, np.nan) if a.dtype.kind == "f" else a,
    lambda a: np.full_like(a, np.inf) if a.dtype.kind == "f" else a,
    lambda a: a * 1e200 if a.dtype.kind == "f" else a,
    lambda a: a[..., :-1] if a.ndim else a,
    lambda a: np.concatenate([a, a]) if a.ndim else a,
    lambda a: a.astype(np.uint8),
    lambda a: a.ravel(),
    lambda a: np.zeros((0, 0)),
    lambda a: a.tolist(),
    lambda a: -a if a.dtype.kind == "f" else a,
)


def reseal(folder: Path, change: Callable[[list[dict[str, Any]]], None]) -> None:
    """Change a journal's records, and recompute their checksums."""
    records = [dict(item) for item in read_journal(folder / JOURNAL_FILE).records]
    change(records)
    lines, last = [], FIRST_CHECKSUM
    for number, record in enumerate(records):
        wall = record.pop("wall", {})
        wall = {key: value for key, value in wall.items() if key != "crc"} if isinstance(wall, dict) else {}
        record.pop("h", None)
        fields = {key: value for key, value in record.items() if key not in ("q", "p")}
        line, last = seal(orjson.dumps({"q": number, "p": last, **fields}), orjson.dumps(wall)[:-1])
        lines.append(line)
    (folder / JOURNAL_FILE).write_bytes(b"".join(lines))


def change_somewhere(rng: random.Random, tree: Any, depth: int = 0) -> None:
    """Put something odd, or nothing, in one place of a tree of lists and mappings."""
    keys = list(tree) if isinstance(tree, dict) else list(range(len(tree)))
    if not keys:
        return
    key = rng.choice(keys)
    below = tree[key]
    if isinstance(below, dict | list) and below and rng.random() < 0.9 and depth < 30:
        change_somewhere(rng, below, depth + 1)
    elif isinstance(below, np.ndarray) and rng.random() < 0.8:
        tree[key] = rng.choice(_ARRAYS)(below)
    elif rng.random() < 0.15:
        del tree[key]
    else:
        tree[key] = rng.choice(ODD_VALUES)


def forge_state(folder: Path, change: Callable[[dict[str, Any]], None]) -> None:
    """Change a checkpoint, and let the journal name it as if it were its own."""
    path = folder / "checkpoint"
    kept = unpack(path.read_bytes())
    change(kept)
    try:
        content = pack(kept)
    except TypeError:
        return
    path.write_bytes(content)

    def name(records: list[dict[str, Any]]) -> None:
        for record in reversed(records):
            if "checkpoint" in record["wall"]:
                record["wall"] = {**record["wall"], "checkpoint": digest(content)}
                return

    reseal(folder, name)
