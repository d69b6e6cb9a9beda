"""`handcart map` on small logs: files, messages, and refused logs."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import numpy as np
import pytest

from benchmarks.driving.worlds.box_ranges import box_ranges
from handcart.evaluation.mapping.csv_scans import HEADER_MARK, POSE_COLUMNS, read_csv_scans
from handcart.evaluation.trials.running import run_task
from handcart.files.maps.map_file import load_map
from handcart.networks.runs.run_options import RunOptions
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.mapping.box_walls import surface_distances
from handcart.robotics.navigation.mapping.map_comparison import compare_maps
from handcart.robotics.navigation.mapping.scan_log import ScanLog
from handcart.tools.main import main

from .drives import small_drive, small_floor

ROOT = Path(__file__).parents[3]
HEADER = "---\nformat: handcart-scans/1\nlidar: {first_deg: -90, last_deg: 90, reach_m: 10}\n---\n"
TITLES = "time_s,x_m,y_m,heading_rad,r0,r1,r2\n"


def status(*words: str) -> int:
    with pytest.raises(SystemExit) as end:
        main(["map", *words])
    assert isinstance(end.value.code, int)
    return end.value.code


def scans_csv(log: ScanLog) -> str:
    """Return a log as the text of a CSV file."""
    lidar = {
        "first_deg": math.degrees(log.angles[0]),
        "last_deg": math.degrees(log.angles[-1]),
        "reach_m": log.reach,
        "x_m": log.mount.x,
        "y_m": log.mount.y,
        "heading_deg": math.degrees(log.mount.theta),
    }
    lines = [HEADER_MARK, "format: handcart-scans/1", "lidar:"]
    lines += [f"  {key}: {value!r}" for key, value in lidar.items()]
    lines += [HEADER_MARK, ",".join([*POSE_COLUMNS, *(f"r{k}" for k in range(log.ranges.shape[1]))])]
    for time, pose, ranges in zip(log.times, log.odometry, log.ranges, strict=True):
        cells = [f"{time:.6f}", *(f"{value:.6f}" for value in pose)]
        cells += ["" if math.isnan(value) else f"{value:.4f}" for value in ranges.tolist()]
        lines.append(",".join(cells))
    return "\n".join(lines) + "\n"


def written(log: ScanLog, path: Path) -> Path:
    path.write_text(scans_csv(log), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def mapped(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of the map of the small drive."""
    folder = tmp_path_factory.mktemp("mapped")
    assert (
        status(str(written(small_drive().log, folder / "drive.csv")), "-o", str(folder / "map"), "--json")
        == 0
    )
    return folder / "map"


@pytest.mark.slow
def test_map_walls_lie_at_the_true_walls(mapped: Path) -> None:
    grid, warning = load_map(mapped / "map.yaml")
    assert warning is None
    start = Pose2(*small_drive().truth[0])
    walls = start.apply(grid.to_point(np.argwhere(grid.occupied)))
    away = surface_distances(walls, small_floor().boxes)
    assert len(walls) > 500
    assert np.median(away) < 0.03
    assert np.quantile(away, 0.95) < 0.05


@pytest.mark.slow
def test_trajectory_is_true_within_its_covariance(mapped: Path) -> None:
    rows = np.loadtxt(mapped / "trajectory.csv", delimiter=",", skiprows=1)
    truth, start = small_drive().truth, Pose2(*small_drive().truth[0])
    index = np.searchsorted(small_drive().log.times, rows[:, 0] - 1e-6)
    true = np.array([Pose2(*pose).relative_to(start) for pose in truth[index].tolist()])
    off = rows[1:, 1:3] - true[1:, :2]
    spread = rows[1:][:, [4, 5, 5, 6]].reshape(-1, 2, 2)
    squared = np.einsum("ni,nij,nj->n", off, np.linalg.inv(spread), off)
    assert np.quantile(squared, 0.95) < 9.2  # 99 % of two degrees of freedom
    assert np.hypot(*off.T).max() < 0.06
    odometry = small_drive().log.odometry[index][1:, :2] - true[1:, :2]
    assert np.hypot(*odometry.T).max() > 0.1


@pytest.mark.slow
def test_summary_counts_the_loop_closures(mapped: Path) -> None:
    found = json.loads((mapped / "summary.json").read_text())
    loops = np.loadtxt(mapped / "loops.csv", delimiter=",", skiprows=1)
    assert found["loop_closures"]["accepted"] == len(loops) > 10
    assert (loops[:, 1] > loops[:, 0]).all()
    assert found["loop_closures"]["inliers"] > 0.8
    assert 0.0 < found["position_sigma_m"]["max"] < 0.1
    assert "<svg" in (mapped / "map.svg").read_text()


def test_log_without_a_loop_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log = small_drive().log
    straight = log._replace(times=log.times[:60], odometry=log.odometry[:60], ranges=log.ranges[:60])
    assert status(str(written(straight, tmp_path / "a.csv")), "-o", str(tmp_path / "map")) == 0
    said, progress = capsys.readouterr()
    assert "no loop closure found" in said
    assert "matching scans ..." in progress


def test_two_rooms_alike_are_not_taken_for_one(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Two equal rooms at the ends of a corridor, with odometry that drifts."""
    walls = [(5.0, -1.55, 0.0, 16.0, 0.1), (5.0, 1.55, 0.0, 16.0, 0.1)]
    walls += [(-3.05, 0.0, 0.0, 0.1, 3.2), (13.05, 0.0, 0.0, 0.1, 3.2)]
    walls += [(x, y, 0.0, 0.3, 0.6) for x in (0.0, 10.0) for y in (-1.2, 1.2)]
    angles = np.radians(np.arange(-180.0, 180.0, 2.0))
    xs = np.arange(0.0, 10.0, 0.2)
    rng = np.random.default_rng(0)
    ranges = np.array([box_ranges(walls, Pose2(x, 0.0, 0.0), angles) for x in xs])
    ranges += rng.normal(0.0, 0.01, ranges.shape)
    ranges[ranges > 4.0] = np.inf
    odometry = np.column_stack([xs, np.zeros((len(xs), 2))])
    log = ScanLog(
        0.5 * np.arange(len(xs), dtype=np.float64), odometry, angles, ranges, Pose2(0.0, 0.0, 0.0), 4.0
    )
    assert status(str(written(log, tmp_path / "a.csv")), "-o", str(tmp_path / "map")) == 0
    assert "no loop closure found" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("", r"a\.csv:1:1: no log of scans: it does not begin with a header"),
        (HEADER, r"a\.csv:5:1: titles  \.\.\.; needed: time_s, x_m, y_m, heading_rad"),
        (HEADER + TITLES, r"a\.csv:5:1: no scans; needed: at least two rows"),
        (HEADER + TITLES + "0,0,0,0,1,2\n", r"a\.csv:6:1: 6 cells; needed: 7"),
        (HEADER + TITLES + "0,0,0,0,1,2,x\n", r"a\.csv:6:13: no number: 'x'; allowed: a number, inf"),
        (HEADER + TITLES + "0,0,,0,1,2,3\n", r"a\.csv:6:5: no number: ''; allowed: a number"),
        (HEADER + TITLES + "1,0,0,0,1,2,3\n1,0,0,0,1,2,3\n", r"a\.csv:7:1: time does not increase"),
        (HEADER + TITLES + "0,0,0,0,,,\n1,0,0,0,,,\n", r"a\.csv: no beam of any scan hit anything"),
        (HEADER + TITLES + "0,0,0,0,1,2,3\n1,90,0,0,1,2,3\n", r"a\.csv: the odometry jumps by 90\.0 m"),
        (HEADER + TITLES + '0,0,0,0,"' + "1,2\n" * 60_000, r"a\.csv:\d+:1: invalid CSV: field larger than"),
        (HEADER.replace("reach_m", "reech_m") + TITLES, r"a\.csv:3:\d+: .*reech_m.*did you mean 'reach_m'"),
        (HEADER.replace("90, r", "-95, r") + TITLES, r"a\.csv:3:\d+: last_deg is -95; allowed: more than"),
    ],
)
def test_bad_csv_is_refused_at_its_place(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], content: str, said: str
) -> None:
    (tmp_path / "a.csv").write_text(content)
    assert status(str(tmp_path / "a.csv"), "-o", str(tmp_path / "map")) == 2
    error = capsys.readouterr().err
    assert re.search(said, error), error
    assert "Traceback" not in error
    assert not (tmp_path / "map").exists()


@pytest.mark.parametrize("beams", [3, 6000])
def test_scans_of_any_number_of_beams_are_read(tmp_path: Path, beams: int) -> None:
    titles = ",".join(["time_s,x_m,y_m,heading_rad", *(f"r{k}" for k in range(beams))])
    rows = [",".join([f"{time},0,0,0", *["1.234"] * beams]) for time in (0, 1)]
    (tmp_path / "a.csv").write_text("\n".join([HEADER + titles, *rows]))
    assert read_csv_scans(tmp_path / "a.csv").ranges.tolist() == [[1.234] * beams] * 2


def test_missing_log_and_unknown_kind_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert status(str(tmp_path / "none.csv"), "-o", str(tmp_path / "map")) == 2
    assert "none.csv:1:1: the file does not exist" in capsys.readouterr().err
    (tmp_path / "a.jpg").write_bytes(b"")
    assert status(str(tmp_path / "a.jpg"), "-o", str(tmp_path / "map")) == 2
    assert "no kind of log is named '.jpg'; allowed:" in capsys.readouterr().err


@pytest.mark.slow
def test_run_folder_is_mapped_and_said_as_the_page_has_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The page's sample, but for its numbers and the reasons that a run may not have."""
    options = RunOptions(settings={"robot": "cart", "tour": "[meeting_room, kitchen]"}, playback=True)
    summary, code = run_task(ROOT / "tasks" / "drive_map" / "task.yaml", tmp_path / "runs", options)
    assert code == 0
    capsys.readouterr()
    assert status(str(summary["run_dir"]), "-o", str(tmp_path / "again")) == 0
    page = (ROOT / "docs" / "how_to" / "map.md").read_text(encoding="utf-8")
    sample = page[page.index("note: a run records") :].split("```", 1)[0]
    said = capsys.readouterr().out.replace(str(tmp_path) + "/", "")
    assert words_of(said)[:2] == words_of(sample)[:2]
    assert words_of(said)[-2:] == words_of(sample)[-2:]
    shown = load_map(ROOT / "tasks" / "drive_map" / "map.yaml")[0]
    found = compare_maps(load_map(tmp_path / "again" / "map.yaml")[0], shown)
    median, _, missing = found.figures(found.first)
    assert median < 0.04
    assert missing < 0.02


def words_of(text: str) -> list[str]:
    """Return the lines of a text without their numbers."""
    return [re.sub(r"[0-9.]+", "#", line) for line in text.strip().splitlines()]
