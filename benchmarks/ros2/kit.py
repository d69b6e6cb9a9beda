"""Run the conformance kit over the bench of ROS 2 topics, in one process: `python -m benchmarks.ros2.kit`.

Commands and readings pass through the messages of ROS, without its middleware. Printed is one row: checks
that hold, violations after injected faults, liars that were caught. `--actions` moves arm and fingers by
goals of actions instead of topics. The whole row costs some twenty minutes of CPU time. Status 1 if a check
failed, a fault was followed by a violation, fewer than 300 were injected, or a liar was missed. Ctrl-C prints
the row of the jobs that have ended, status 130.
"""

from __future__ import annotations

import argparse
import shutil
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory

import yaml

from benchmarks.cut_off import CUT_OFF_STATUS, CutOff
from handcart.backends.loading.robot_loading import load_robot
from handcart.evaluation.conformance.kit import QUICK_PARTS, KitSetting, report_of, run_kit
from handcart.evaluation.conformance.report import KitReport, Result

MIN_FAULTS = 300
ACTION = "arm_controller/follow_joint_trajectory"
HAND = {"action": "gripper_controller/gripper_cmd"}


def main() -> None:
    """Print the row, and below it what was found."""
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("--parts", nargs="+", choices=QUICK_PARTS, default=list(QUICK_PARTS))
    words.add_argument("--robot", default="librarian")
    words.add_argument("--bench", default="kinematic", help="simulated backend behind the topics")
    words.add_argument("--actions", action="store_true", help="arm and fingers take goals of actions")
    words.add_argument("--instants", type=int, help="of each primitive's run at which faults are injected")
    words.add_argument("--jobs", type=int, default=1, help="processes side by side")
    asked = words.parse_args()
    begun, of_all = time.monotonic(), 0

    def tell(done: int, count: int) -> None:
        nonlocal of_all
        passed, of_all = time.monotonic() - begun, count
        print(f"\r{done} of {count} jobs done after {passed:.0f} s", end="", file=sys.stderr, flush=True)

    print("loading", end="", file=sys.stderr, flush=True)
    results: dict[int, Result] = {}
    with TemporaryDirectory(prefix="kit-") as folder:
        robot = robot_by_actions(asked.robot, Path(folder)) if asked.actions else asked.robot
        parts, instants = tuple(asked.parts), asked.instants
        setting = KitSetting("ros2", robot, True, parts, instants=instants, simulated=asked.bench)
        with CutOff() as cut:
            run_kit(setting, asked.jobs, tell, results)
        report = report_of(setting, results)
    print(file=sys.stderr)
    print(f"{row_of(report, asked.parts)}{cut.words(len(results), of_all)}", flush=True)
    for line in findings_of(report):
        print(f"    {line}", flush=True)
    if cut.came:
        sys.exit(CUT_OFF_STATUS)
    few = "faults" in asked.parts and report.injected < MIN_FAULTS
    if few:
        print(f"    {report.injected} faults are fewer than {MIN_FAULTS}")
    sys.exit(0 if report.ok and not few else 1)


def row_of(report: KitReport, parts: list[str]) -> str:
    """Return the row of a report."""
    wrong = sum(not check.ok for check in report.checks)
    found = {
        "checks": f"{len(report.checks)} checks, {wrong} wrong",
        "faults": f"{report.injected} faults, {len(report.violations)} violations",
        "mutants": f"{len(report.planted) - len(report.missed)} of {len(report.planted)} liars caught",
    }
    broken = [f"{len(report.broken)} parts broken"] if report.broken else []
    return "kit through ROS 2: " + "; ".join([*(found[part] for part in parts), *broken])


def findings_of(report: KitReport) -> list[str]:
    """Return what is wrong, in words."""
    return [
        *(f"check {check.name}: {'; '.join(check.wrong)}" for check in report.checks if not check.ok),
        *(str(violation) for violation in report.violations),
        *(f"{item.name} was missed" for item in report.missed),
        *(f"{item.name}: {item.reason.strip().splitlines()[-1]}" for item in report.broken),
    ]


def robot_by_actions(name: str, folder: Path) -> str:
    """Write a copy of a robot's files whose arm and fingers take goals, and return its path."""
    robot = load_robot(name)
    copy = shutil.copytree(robot.folder, folder / "robot")
    file = next(copy.glob("robot.y*ml"))
    content = yaml.safe_load(file.read_text(encoding="utf-8"))
    arm = {"arm": {"actions": {ACTION: list(robot.arm.joints)}}} if robot.arm is not None else {}
    content["ros2"] = {**arm, **({"gripper": HAND} if robot.gripper is not None else {})}
    file.write_text(yaml.safe_dump(content), encoding="utf-8")
    return str(file)


if __name__ == "__main__":
    main()
