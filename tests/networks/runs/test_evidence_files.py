"""Files that an action's evidence leaves in the run's folder."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import cv2
import numpy as np
import pytest

from handcart.networks.events.events import Ended
from handcart.networks.graph.network import Action
from handcart.networks.runs import evidence_files
from handcart.networks.runs.evidence_files import EvidenceFiles
from handcart.primitives.outcomes.calibrated import Calibrated
from handcart.primitives.outcomes.evidence import Evidence
from handcart.primitives.outcomes.outcome import Outcome, Success, fail_if_restored
from handcart.primitives.outcomes.residual import read_residuals

FOUND = {"camera.calibrated.focal_px": Calibrated(600.0, 0.5)}
FAIL = fail_if_restored("it stalled", False, read_residuals({}, {}))


def ended(outcome: Outcome, evidence: Evidence) -> Ended:
    primitive: Any = SimpleNamespace(evidence=evidence)
    action = Action("a", "b", None)
    return Ended(1.0, 3, action, primitive, outcome, {})


def seen() -> Evidence:
    picture = np.arange(120, dtype=np.uint8).reshape(10, 12)
    points = np.array([[1.0, 2.0], [3.0, 4.0]])
    return Evidence(pictures={"front": picture, "back": picture + 1}, points={"scan": points})


@pytest.fixture
def kept() -> list[Mapping[str, Calibrated]]:
    return []


@pytest.fixture
def files(tmp_path: Path, kept: list[Mapping[str, Calibrated]]) -> EvidenceFiles:
    return EvidenceFiles(tmp_path, kept.append)


def test_evidence_files_hold_pictures_and_points(tmp_path: Path, files: EvidenceFiles) -> None:
    evidence = seen()
    files.event(ended(FAIL, evidence))
    folder = tmp_path / "evidence"
    names = ["003_SKIP_Fail.npz", "003_SKIP_Fail_back.png", "003_SKIP_Fail_front.png"]
    assert sorted(path.name for path in folder.iterdir()) == names
    for key, picture in evidence.pictures.items():
        read = cv2.imread(str(folder / f"003_SKIP_Fail_{key}.png"), cv2.IMREAD_UNCHANGED)
        assert read is not None
        assert np.array_equal(read, picture)
    with np.load(folder / names[0]) as points:
        assert points["scan"].tolist() == [[1.0, 2.0], [3.0, 4.0]]


def test_evidence_files_are_named_without_a_success(tmp_path: Path, files: EvidenceFiles) -> None:
    files.event(ended(Success({}), seen()))
    assert (tmp_path / "evidence" / "003_SKIP_front.png").exists()


def test_evidence_files_of_nothing_leave_no_folder(tmp_path: Path, files: EvidenceFiles) -> None:
    files.event(ended(Success({}), Evidence()))
    assert list(tmp_path.iterdir()) == []


def test_evidence_files_keep_calibration_of_successes_alone(
    files: EvidenceFiles, kept: list[Mapping[str, Calibrated]]
) -> None:
    files.event(ended(FAIL, Evidence(calibrated=FOUND)))
    assert kept == []
    files.event(ended(Success({}), Evidence(calibrated=FOUND)))
    assert kept == [FOUND]


def test_evidence_files_stop_at_a_full_disk(
    tmp_path: Path, files: EvidenceFiles, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(evidence_files, "write_whole", full)
    files.event(ended(FAIL, seen()))
    assert files.lost == "No space left on device"
    monkeypatch.undo()
    files.event(ended(FAIL, seen()))
    assert list((tmp_path / "evidence").iterdir()) == []
