"""Speeds of stacking: finding a landmark, rendering a picture, a trial of five blocks.

python -m benchmarks.blocks.stacking_speed [TRIALS]
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import cv2

from handcart.evaluation.trials.rig import RigFiles, build_rig
from handcart.evaluation.trials.running import run_task
from handcart.networks.runs.run_options import RunOptions
from handcart.primitives.blocks.fixate import Fixate
from handcart.primitives.outcomes.outcome import Success
from handcart.robotics.perception.landmarks.landmark_finder import find_landmarks

TASK_FOLDER = Path(__file__).parent.parent.parent / "tasks" / "stack_blocks"


def least(work: Callable[[], object], times: int = 50) -> float:
    """Return the least CPU time of a call, in [ms]."""
    taken = []
    for _ in range(times):
        before = time.process_time()
        work()
        taken.append(time.process_time() - before)
    return 1e3 * min(taken)


def main() -> None:
    """Print the table."""
    cv2.setNumThreads(1)
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("trials", nargs="?", type=int, default=3)
    trials = words.parse_args().trials
    files = RigFiles(
        TASK_FOLDER / "unload_world.yaml",
        TASK_FOLDER / "map.yaml",
        TASK_FOLDER / "places.yaml",
        {"building": TASK_FOLDER / "building.yaml"},
        "stacking",
    )
    with build_rig(files, robot="toyama/h1") as rig:
        assert isinstance(rig.do(Fixate(landmark="stacking")), Success)
        image, camera = rig.robot.camera.image(), rig.robot.camera.model

        def picture() -> object:
            rig.backend.step()
            return rig.robot.camera.image()

        step = least(rig.backend.step)
        found = least(lambda: find_landmarks(image, camera))
        print(f"{'a landmark found in a picture of 640 x 480':48}{found:8.2f} ms")
        print(f"{'the picture rendered, in full':48}{least(picture) - step:8.2f} ms")
    for seed in range(trials):
        with tempfile.TemporaryDirectory() as runs:
            before = time.process_time()
            summary, _ = run_task(
                TASK_FOLDER / "unload.yaml",
                Path(runs),
                RunOptions(settings={"robot": "toyama/h1"}, seed=seed),
            )
            cpu = time.process_time() - before
        ratio = summary["sim_time_s"] / cpu
        text = f"a trial of five blocks, seed {seed}: {summary['sim_time_s']:.0f} s in {cpu:.2f} s of CPU"
        print(f"{text:48}{ratio:8.1f} times real time")


if __name__ == "__main__":
    main()
