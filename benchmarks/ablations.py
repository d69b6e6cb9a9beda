"""What each part of return_book is good for: success with it switched off, in generated libraries.

python -m benchmarks.ablations [TRIALS]
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

from rich.console import Console
from rich.progress import track

from backends.robot_file import ROBOTS
from evaluation.campaign import Report, Setting, run_campaign

TASK = Path(__file__).parent.parent / "tasks" / "return_book" / "task.yaml"


def without_scans(folder: Path) -> str:
    """A copy of the robot that goes by its wheels alone; its path."""
    for path in (ROBOTS / "librarian").glob("*.urdf"):
        (folder / path.name).write_bytes(path.read_bytes())
    text = (ROBOTS / "librarian" / "robot.yaml").read_text(encoding="utf-8")
    assert "localiser: scan" in text
    (folder / "robot.yaml").write_text(
        text.replace("localiser: scan", "localiser: odometry"), encoding="utf-8"
    )
    return str(folder / "robot.yaml")


def main() -> None:
    """Print the table."""
    trials = int(sys.argv[1]) if len(sys.argv) > 1 else 20
    with tempfile.TemporaryDirectory() as folder:
        rows = {
            "everything on": {},
            "scan correction off": {"robot": without_scans(Path(folder))},
            "visual correction of the hand off": {"correct": "false"},
            "fusing of views off": {"fuse": "false"},
            "misplacement logic off": {"misplacement": "false"},
        }
        print(f"{'':36}{'Success':>9}{'Wilson 95 %':>16}   most frequent other end")
        for name, settings in rows.items():
            setting = Setting(TASK, None, settings, {"misplaced": True}, Path(folder) / "runs")
            running = run_campaign(setting, range(trials), 2)
            report = Report(tuple(track(running, name, trials, console=Console(stderr=True))))
            low, high = report.wilson
            others = [text for text, _ in report.outcomes.most_common() if text != "Success"]
            share = f"{100 * low:.0f} to {100 * high:.0f} %"
            print(f"{name:36}{report.successes:>5} / {trials}{share:>16}   {(others or [''])[0][:110]}")
            if report.untrue:
                print(f"{'':36}{len(report.untrue)} outcomes untrue: {report.untrue[0].untrue[0][:90]}")


if __name__ == "__main__":
    main()
