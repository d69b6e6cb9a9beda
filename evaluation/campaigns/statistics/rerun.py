"""Command that runs one trial of a campaign again."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Mapping
from typing import Any


def rerun(said: Mapping[str, Any], seed: int) -> str:
    """Return the shell command that runs one trial of a campaign again.

    Args:
        said: command-line arguments of the campaign, by name, as its folder keeps them.
        seed: seed of the trial.
    """
    return shlex.join(_words(said, seed))


def _words(said: Mapping[str, Any], seed: int) -> Iterator[str]:
    varied, walks = said.get("vary_file"), said.get("level", "run") != "run"
    alone = not (varied or walks or said["generate"] or said.get("faults"))
    yield from ("handcart", "run" if alone else "campaign", said["task"])
    if alone:
        yield from ("--seed", str(seed))
    elif varied:  # variants are distributed over all requested seeds
        yield from ("--first", str(said["first"]), "--trials", str(said["trials"]), "--vary", varied)
        yield from ("--shard", f"{seed - said['first'] + 1}/{said['trials']}", "--out", f"again-{seed}")
    else:
        yield from ("--trials", "1", "--first", str(seed))
    if walks:
        yield from ("--level", said["level"])
    for item in said.get("learned_from", ()):
        yield from ("--learned-from", item)
    for item in said["generate"]:
        yield from ("--generate", item)
    if said.get("faults"):
        yield from ("--faults", said["faults"])
    for key, value in said["settings"].items():
        yield from ("--set", f"{key}={value}")
    if said.get("backend"):
        yield from ("--backend", said["backend"])
