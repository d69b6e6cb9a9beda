"""Measure the value of each part of return_book: success without it, in generated libraries.

python -m benchmarks.books.ablations [TRIALS]
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

from rich.console import Console
from rich.progress import track

from handcart.backends.description.robot_names import SHIPPED_FOLDER
from handcart.evaluation.books.library_files import Libraries
from handcart.evaluation.campaigns.campaign import run_campaign
from handcart.evaluation.campaigns.campaign_setting import CampaignSetting
from handcart.evaluation.campaigns.statistics.campaign_report import CampaignReport

TASK_FILE = Path(__file__).parent.parent.parent / "tasks" / "return_book" / "task.yaml"


NO_SUSPENSION_MODEL = {
    "swing_yaw_mrad: 0.0": "swing_yaw_mrad: -0.8",
    "swing_yaw_sigma_mrad: 0.0": "swing_yaw_sigma_mrad: 0.4",
}
"""A base that gives when the arm has swung, as Hatano (2000) measured it."""
WHEELS_ALONE = {"localizer: scan": "localizer: odometry"}


def robot(folder: Path, name: str, changes: dict[str, str]) -> str:
    """Return a copy of the robot with other lines in its file; the copy's path."""
    (folder / "librarian.urdf").write_bytes((SHIPPED_FOLDER / "librarian" / "librarian.urdf").read_bytes())
    text = (SHIPPED_FOLDER / "librarian" / "robot.yaml").read_text(encoding="utf-8")
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)
    (folder / f"{name}.yaml").write_text(text, encoding="utf-8")
    return str(folder / f"{name}.yaml")


def main() -> None:
    """Print the table."""
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("trials", nargs="?", type=int, default=20)
    trials = words.parse_args().trials
    with tempfile.TemporaryDirectory() as folder:
        gives = robot(Path(folder), "gives", NO_SUSPENSION_MODEL)
        rows = {
            "everything on": {},
            "scan correction off": {"robot": robot(Path(folder), "wheels", WHEELS_ALONE)},
            "visual correction of the hand off": {"correct": "false"},
            "a base that gives": {"robot": gives},
            "the same, visual correction off": {"robot": gives, "correct": "false"},
            "fusing of views off": {"fuse": "false"},
            "misplacement logic off": {"misplacement": "false"},
        }
        print(f"{'':36}{'Success':>9}{'Wilson 95 %':>16}{'edge 95 %':>12}   most frequent other end")
        for name, settings in rows.items():
            setting = CampaignSetting(
                TASK_FILE, None, settings, Libraries(misplaced=True), Path(folder) / "runs"
            )
            running = run_campaign(setting, range(trials), 2)
            report = CampaignReport(tuple(track(running, name, trials, console=Console(stderr=True))))
            low, high = report.wilson
            others = [text for text, _ in report.outcomes.most_common() if text != "Success"]
            share = f"{100 * low:.0f} to {100 * high:.0f} %"
            edges = report.spreads().get("edge_mm")
            edge = f"{edges.most_95:.2f} mm" if edges else "-"
            other = others[0][:100] if others else ""
            print(f"{name:36}{report.successes:>5} / {trials}{share:>16}{edge:>12}   {other}")
            if report.untrue:
                print(f"{'':36}{len(report.untrue)} outcomes untrue: {report.untrue[0].untrue[0][:90]}")


if __name__ == "__main__":
    main()
