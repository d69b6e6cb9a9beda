"""Damage to a run's folder: accidents and attacks."""

from __future__ import annotations

import io
import os
import random
import shutil
import struct
import zipfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from handcart.networks.run_files.run_folder import JOURNAL_FILE

from .forging import ODD_VALUES, change_somewhere, forge_state, reseal
from .originals import Original

CHECKPOINT_FILE = "checkpoint"
_FILES = (
    JOURNAL_FILE,
    CHECKPOINT_FILE,
    "summary.json",
    "telemetry.npz",
    "error.txt",
    "evidence",
    "calibration.yaml",
)
_ALSO = ("summary.new", "checkpoint.new", "explained_001.svg", ".new.explained_001.svg", "survey.jsonl")


@dataclass(frozen=True)
class Scene:
    """Folder that is attacked, with its surroundings."""

    folder: Path
    """The run's, a copy of an original."""
    outside: Path
    """Folder outside the run, which must stay untouched."""
    canary: Path
    """Made by code that runs."""
    originals: Sequence[Original]
    rng: random.Random

    def other(self, name: str) -> Path | None:
        """Return a file of that name of another original."""
        found = [original.folder / name for original in self.originals if (original.folder / name).is_file()]
        return self.rng.choice(found) if found else None

    def bytes_of(self, name: str) -> bytearray:
        """Return a file's content; empty if the file doesn't exist."""
        path = self.folder / name
        return bytearray(path.read_bytes()) if path.is_file() else bytearray()


Attack = Callable[[Scene], None]


def nothing(scene: Scene) -> None:
    """Leave the folder as it is."""


# Accidents


def flip_journal(scene: Scene) -> None:
    """Flip a few bits of the journal."""
    _flip(scene, JOURNAL_FILE)


def flip_checkpoint(scene: Scene) -> None:
    """Flip a few bits of the checkpoint."""
    _flip(scene, CHECKPOINT_FILE)


def _flip(scene: Scene, name: str) -> None:
    content = scene.bytes_of(name)
    if not content:
        return
    for place in {scene.rng.randrange(len(content)) for _ in range(scene.rng.choice((1, 1, 1, 2, 5)))}:
        content[place] ^= 1 << scene.rng.randrange(8)
    (scene.folder / name).write_bytes(content)


def flip_newline(scene: Scene) -> None:
    """Flip a bit of a newline between two records."""
    content = scene.bytes_of(JOURNAL_FILE)
    ends = [place for place, byte in enumerate(content) if byte == 10]
    if ends:
        content[scene.rng.choice(ends[-4:])] ^= 1 << scene.rng.randrange(8)
        (scene.folder / JOURNAL_FILE).write_bytes(content)


def truncate(scene: Scene) -> None:
    """Cut a file short."""
    name = scene.rng.choice((JOURNAL_FILE, JOURNAL_FILE, CHECKPOINT_FILE, "telemetry.npz", "summary.json"))
    content = scene.bytes_of(name)
    if content:
        (scene.folder / name).write_bytes(content[: scene.rng.randrange(len(content))])


def cut(scene: Scene) -> None:
    """Remove the journal's last records, and keep its checkpoint."""
    lines = bytes(scene.bytes_of(JOURNAL_FILE)).splitlines(keepends=True)
    (scene.folder / JOURNAL_FILE).write_bytes(b"".join(lines[: scene.rng.randrange(len(lines))]))


def tail(scene: Scene) -> None:
    """Something follows the journal."""
    content = bytes(scene.bytes_of(JOURNAL_FILE))
    last = content.splitlines(keepends=True)[-1]
    more = (b"\0" * 4096, scene.rng.randbytes(100), b"{}\n", last, b"\n\n", last[:-20], b'{"q":1e999}\n')
    (scene.folder / JOURNAL_FILE).write_bytes(content + scene.rng.choice(more))


def swap(scene: Scene) -> None:
    """Replace a file by that of another run or of another action."""
    name = scene.rng.choice((CHECKPOINT_FILE, CHECKPOINT_FILE, CHECKPOINT_FILE, JOURNAL_FILE))
    other = scene.other(name)
    if other is not None:
        shutil.copyfile(other, scene.folder / name)


def lose(scene: Scene) -> None:
    """Delete a file, empty it, or fill it with other content."""
    name = scene.rng.choice(_FILES)
    path = scene.folder / name
    _away(path)
    if scene.rng.random() < 0.7:
        path.write_bytes(scene.rng.choice((b"", b"\0" * 100, scene.rng.randbytes(500), b"{}", b"null\n")))


# Harm


def pickled(scene: Scene) -> None:
    """Put code that runs when it is unpickled under every name."""
    command = f"touch {scene.canary}"
    payloads = (
        b"cposix\nsystem\n(V" + command.encode() + b"\ntR.",
        b"cbuiltins\nexec\n(V__import__('os').system('" + command.encode() + b"')\ntR.",
        b"\x80\x04cbackends.saved_state\nnp\n.",
    )
    payload = scene.rng.choice(payloads)
    if scene.rng.random() < 0.4:
        kept = io.BytesIO()
        with zipfile.ZipFile(kept, "w") as packed:
            head = io.BytesIO()
            np.lib.format.write_array_header_1_0(head, {"descr": "|O", "fortran_order": False, "shape": (1,)})
            for name in ("time_s", "x_m", "obstacles"):
                packed.writestr(f"{name}.npy", head.getvalue() + payload)
        for path in (*scene.folder.rglob("*.npz"), scene.folder / "telemetry.npz"):
            path.write_bytes(kept.getvalue())
    else:
        (scene.folder / scene.rng.choice((CHECKPOINT_FILE, CHECKPOINT_FILE, JOURNAL_FILE))).write_bytes(
            payload
        )


def link(scene: Scene) -> None:
    """Let a name in the folder lead out of it."""
    name = scene.rng.choice(
        (*_FILES, *_ALSO, f"{JOURNAL_FILE}.torn-{len(scene.bytes_of(JOURNAL_FILE))}", "evidence/x.npz")
    )
    path = scene.folder / name
    targets = ("secret.txt", "folder", "nothing-there", name.split("/")[-1])
    target = scene.outside / scene.rng.choice(targets)
    if target.name in (JOURNAL_FILE, CHECKPOINT_FILE) and (scene.folder / target.name).is_file():
        shutil.copyfile(scene.folder / target.name, target)
    _away(path)
    path.parent.mkdir(exist_ok=True)
    if scene.rng.random() < 0.2 and target.is_file():
        os.link(target, path)
    else:
        path.symlink_to(target)
    if scene.rng.random() < 0.3:
        _flip(scene, JOURNAL_FILE)


def special(scene: Scene) -> None:
    """Replace a file by a pipe, a folder or a link to a device."""
    path = scene.folder / scene.rng.choice((*_FILES, *_ALSO, "control"))
    _away(path)
    kind = scene.rng.randrange(4)
    if kind == 0:
        os.mkfifo(path)
    elif kind == 1:
        (path / "inside").mkdir(parents=True)
    elif kind == 2:
        path.symlink_to(scene.rng.choice(("/dev/zero", "/dev/random", "/dev/full", "/proc/self/mem")))
    else:
        path.symlink_to(path.name)


def huge(scene: Scene) -> None:
    """Write a file of many gigabytes, or one that unpacks to them, or deeply nested lists."""
    kind = scene.rng.randrange(4)
    if kind == 0:
        with (scene.folder / scene.rng.choice((JOURNAL_FILE, CHECKPOINT_FILE))).open(
            "r+b" if kind else "ab"
        ) as file:
            file.truncate(scene.rng.choice((10**9, 10**11)))
    elif kind == 1:
        with (scene.folder / JOURNAL_FILE).open("ab") as file:
            file.write(b'{"q":' + b"[" * 100_000 + b"]" * 100_000 + b"}\n")
    elif kind == 2:
        reseal(scene.folder, lambda records: records[-1].update(deep=_deep(200)))
    elif (scene.folder / CHECKPOINT_FILE).is_file():
        forge_state(scene.folder, lambda kept: kept.update(model=_deep(40)))


def _deep(levels: int) -> Any:
    value: Any = 0
    for _ in range(levels):
        value = [value]
    return value


def forged_record(scene: Scene) -> None:
    """Something in a record is odd; the chain is whole."""

    def change(records: list[dict[str, Any]]) -> None:
        for _ in range(scene.rng.choice((1, 1, 2, 4))):
            change_somewhere(scene.rng, records[scene.rng.randrange(len(records))])

    reseal(scene.folder, change)


def forged_order(scene: Scene) -> None:
    """Remove, double or swap records, with a valid chain of checksums."""

    def change(records: list[dict[str, Any]]) -> None:
        place = scene.rng.randrange(len(records))
        match scene.rng.randrange(4):
            case 0:
                del records[place]
            case 1:
                records.insert(place, dict(records[scene.rng.randrange(len(records))]))
            case 2:
                other = scene.rng.randrange(len(records))
                records[place], records[other] = records[other], records[place]
            case _:
                records[place]["kind"] = scene.rng.choice(("START", "RESULT", "END", "ACK", "NEW", "", 5))

    reseal(scene.folder, change)


def forged_header(scene: Scene) -> None:
    """Forge a journal of another version, task, robot or backend with a valid chain of checksums."""
    keys = ("schema", "handcart", "task_path", "settings", "backend", "bench", "seed", "errors", "start")
    key = scene.rng.choice((*keys, "network", "robot_sha256", "simulated", "plan_on", "robot"))
    odd = (
        *ODD_VALUES,
        "/dev/zero",
        str(scene.outside / "folder"),
        "handcart-journal/9",
        "9.9.9",
        "pybullet",
        "can",
    )

    def change(records: list[dict[str, Any]]) -> None:
        if scene.rng.random() < 0.2:
            records[0].pop(key, None)
        else:
            records[0][key] = scene.rng.choice(odd)

    reseal(scene.folder, change)


def forged_state(scene: Scene) -> None:
    """Something in the checkpoint is odd; its checksum is right, and the journal names it."""
    if not (scene.folder / CHECKPOINT_FILE).is_file():
        return

    def change(kept: dict[str, Any]) -> None:
        for _ in range(scene.rng.choice((1, 1, 2, 5))):
            part = scene.rng.choice(("backend", "backend", "robot", "model", "result", None))
            below = kept if part is None else kept.get(part)
            change_somewhere(scene.rng, below if isinstance(below, dict | list) else kept)

    forge_state(scene.folder, change)


def forged_engine(scene: Scene) -> None:
    """Forge the engine's own part of the checkpoint."""
    if not (scene.folder / CHECKPOINT_FILE).is_file():
        return

    def change(kept: dict[str, Any]) -> None:
        engine = kept["backend"].get("engine") if isinstance(kept["backend"], dict) else None
        if engine is None:
            kept["backend"] = {"engine": {"bullet": b"BULLETd-v326", "pinned": None}}
            return
        content = bytearray(engine["bullet"])
        rng = scene.rng
        match rng.randrange(6):
            case 0:
                for _ in range(rng.choice((1, 10, 1000))):
                    content[rng.randrange(len(content))] = rng.randrange(256)
            case 1:
                del content[rng.randrange(len(content)) :]
            case 2:
                place = 12 + 24 * rng.randrange(2)
                struct.pack_into("<i", content, place + 4, rng.choice((-1, 0, 2**31 - 1, 10**6)))
            case 3:
                content[:] = content[:12] + rng.randbytes(2000)
            case 4:
                struct.pack_into(
                    "<q", content, rng.randrange(len(content) - 8), rng.choice((0, 5, -1, 2**48))
                )
            case _:
                bodies = rng.choice((0, 1, -1, 10**6)), rng.choice((-2, 0, 99)), 3
                engine["pinned"] = [*bodies, [], [], 1e9]
        engine["bullet"] = bytes(content)

    forge_state(scene.folder, change)


def damaged_evidence(scene: Scene) -> None:
    """Pictures, readings or notes beside the journal are damaged."""
    for path in [*scene.folder.rglob("*.npz"), *scene.folder.rglob("*.png"), *scene.folder.glob("*.jsonl")]:
        if path.name == JOURNAL_FILE or scene.rng.random() < 0.5:
            continue
        content = bytearray(path.read_bytes())
        match scene.rng.randrange(4):
            case 0:
                content = bytearray(b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR" + struct.pack(">II", 60000, 60000))
            case 1:
                content = content[: scene.rng.randrange(len(content) + 1)]
            case 2:
                content = bytearray(b'{"time_s": 0.0}\n{"time_s": "x"}\n[]\n1\n')
            case _:
                for _ in range(20):
                    content[scene.rng.randrange(len(content))] ^= 1 << scene.rng.randrange(8)
        path.write_bytes(content)


def calibrated(scene: Scene) -> None:
    """Write a forged calibration."""
    texts = (
        b"!!python/object/apply:os.system ['touch " + bytes(scene.canary) + b"']\n",
        b"format: handcart-calibration/1\nrobot: ../../../etc/passwd\nfound: {}\n",
        b"&a [*a]\n",
        b"a: " * 10_000,
        scene.rng.randbytes(300),
    )
    (scene.folder / "calibration.yaml").write_bytes(scene.rng.choice(texts))


FOLDER_ACCIDENTS: tuple[Attack, ...] = (
    *(nothing, flip_journal, flip_newline, flip_checkpoint, flip_checkpoint, truncate, cut, tail, swap, lose),
    damaged_evidence,
)
"""After these a run is put back where it truly was, or refused."""
FOLDER_ATTACKS: tuple[Attack, ...] = (
    *(pickled, link, link, special, huge, forged_record, forged_record, forged_order, forged_header),
    *(forged_state, forged_state, forged_engine, calibrated),
)
"""Attacks after which nothing may run, nothing outside may change, and every fault has a clear message."""


def _away(path: Path) -> None:
    if path.is_symlink() or path.is_file():
        path.unlink()
    elif path.is_dir():
        shutil.rmtree(path)
