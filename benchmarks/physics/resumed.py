"""Test that a restored MuJoCo world continues alike: `python -m benchmarks.physics.resumed [TASK]`.

A run of a task, `return_book` by default, keeps the whole state of its backend every `EVERY` periods.
Another backend is set to each of these states, gets the commands of the run, and must be in the state of
the run `LATER` periods after: engine and ground truth equal to the last bit. Exit status 1 if one isn't.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path
from typing import Any

from handcart.backends.backend import Backend
from handcart.backends.mujoco.mujoco_backend import MujocoBackend
from handcart.backends.saved_state import pack, unpack
from handcart.evaluation.trials.running import run_task
from handcart.networks.runs.run_options import RunOptions

TASK_FILE = Path(__file__).resolve().parents[2] / "tasks" / "return_book" / "task.yaml"
EVERY, LATER = 110, 60
COMMANDED_PARTS = ("_base", "_arm", "_gripper")


class Kept:
    """States of a run by the period that they precede, and the commands of each period."""

    def __init__(self) -> None:
        self.backend: MujocoBackend | None = None
        self.whole: dict[int, bytes] = {}
        self.later: dict[int, bytes] = {}
        self.commands: list[list[Any]] = []

    def around(self, backend: Backend) -> Backend:
        """Have a backend keep it as it steps."""
        assert isinstance(backend, MujocoBackend)
        self.backend, step = backend, backend.step

        def keeping() -> None:
            number = len(self.commands)
            if number % EVERY == 0:
                self.whole[number] = pack(backend.state())
            if number >= LATER and (number - LATER) % EVERY == 0:
                self.later[number - LATER] = world_of(backend)
            parts = [getattr(backend, name) for name in COMMANDED_PARTS]
            self.commands.append([None if part is None else part._command for part in parts])
            step()

        backend.step = keeping  # type: ignore[method-assign]
        return backend


def world_of(backend: MujocoBackend) -> bytes:
    """Return all that there is of the world; not what was read of it and when."""
    state = backend.state()
    return pack({name: state[name] for name in ("engine", "scene")})


def goes_on(kept: Kept, begins: int) -> bool:
    """Return True if another backend reaches the state of the run."""
    assert kept.backend is not None
    again = MujocoBackend(kept.backend._robot, kept.backend._world_file, kept.backend._seed)
    again.set_state(unpack(kept.whole[begins]))
    for commands in kept.commands[begins : begins + LATER]:
        for name, command in zip(COMMANDED_PARTS, commands, strict=True):
            if command is not None:
                getattr(again, name)._command = command
        again.step()
    same = world_of(again) == kept.later[begins]
    again.close()
    return same


def main() -> None:
    """Print how many do."""
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("task", nargs="?", type=Path, default=TASK_FILE)
    task, kept = words.parse_args().task, Kept()
    with tempfile.TemporaryDirectory() as folder:
        options = RunOptions(backend="mujoco", around=kept.around, draw=False, report=False, playback=False)
        summary, _ = run_task(task, Path(folder), options)
    print(f"{summary['outcome']} after {len(kept.commands)} periods")
    same = {begins: goes_on(kept, begins) for begins in kept.later}
    print(f"equal to the last bit {LATER} periods later: {sum(same.values())} of {len(same)} instants")
    different = [begins for begins, equal in same.items() if not equal]
    if different:
        sys.exit(f"different from periods {', '.join(map(str, different))} on")


if __name__ == "__main__":
    main()
