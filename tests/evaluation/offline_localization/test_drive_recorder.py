"""The log of a drive outdoors, as a run writes it."""

from __future__ import annotations

from pathlib import Path

import pytest

from handcart.evaluation.offline_localization.drive_recorder import DRIVE_LOG_FILE, DriveRecorder
from handcart.evaluation.offline_localization.logs.csv_log import read_csv_log
from handcart.networks.task.preparing import prepare
from handcart.robotics.geometry.pose2 import Pose2
from handcart.tasks.task_names import named_tasks


def test_places_far_from_the_origin_keep_their_millimetres(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    far, recorder = Pose2(12345.678, -98765.432, 0.5), DriveRecorder()
    with prepare(named_tasks()["deploy_straight"], None, {}, 1) as prepared:
        robot = prepared.robot
        monkeypatch.setattr(robot.backend, "true_base", lambda: far)
        recorder.begin(prepared, tmp_path)
        for _ in range(3):
            robot.step()
            recorder.period(robot)
        recorder.end()
    log = read_csv_log(tmp_path / DRIVE_LOG_FILE)
    assert log.reference[-1] == pytest.approx(far, abs=1e-3)
