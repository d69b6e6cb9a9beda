"""A run as MCAP, read back by the reader of those who made the format."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import orjson
import pytest
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

from handcart.evaluation.export.run_mcap import write_mcap
from handcart.networks.journal.past_run import read_run
from handcart.networks.runs.run_folder import NoRun
from tests.tools.conftest import Said


@pytest.fixture
def run(handcart: Callable[..., Said], tour: Path, tmp_path: Path) -> Path:
    """The folder of a run that is over, with a picture."""
    assert handcart("run", tour, "--runs", tmp_path / "runs", "--no-report").status == 0
    folder = tmp_path / "runs" / "tour-0"
    cv2.imwrite(str(folder / "evidence" / "001_MOVE_TO_left_side.png"), np.full((4, 6), 7, np.uint8))
    return folder


def messages(path: Path) -> dict[str, list[tuple[str, float, Any]]]:
    """By topic: schema, time and content."""
    found: dict[str, list[tuple[str, float, Any]]] = {}
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for schema, channel, message, content in reader.iter_decoded_messages():
            assert schema is not None
            found.setdefault(channel.topic, []).append((schema.name, message.log_time / 1e9, content))
    return found


def test_all_that_was_recorded_is_there_once(run: Path, tmp_path: Path) -> None:
    past, path = read_run(run), tmp_path / "run.mcap"
    counts = write_mcap(past, path)
    found = messages(path)
    assert {topic: len(each) for topic, each in found.items()} == counts
    assert {topic: {schema for schema, _, _ in each} for topic, each in found.items()} == {
        "/events": {"foxglove.Log"},
        "/joint_states": {"foxglove.JointStates"},
        "/map": {"foxglove.Grid"},
        "/pictures/left_side": {"foxglove.CompressedImage"},
        "/pose": {"foxglove.PoseInFrame"},
        "/scan": {"foxglove.LaserScan"},
        "/tf": {"foxglove.FrameTransforms"},
    }
    track = past.track
    assert track is not None
    with np.load(run / "evidence" / "end_readings.npz") as readings:
        count, ranges, joints = len(readings["time_s"]), readings["ranges_m"], readings["joints_rad"]
    assert count > 50
    assert (counts["/pose"], counts["/tf"], counts["/scan"]) == (len(track.time), len(track.time), count)
    assert counts["/events"] == len(past.records)
    poses = [(at, each.pose.position.x, each.pose.position.y) for _, at, each in found["/pose"]]
    assert np.array(poses) == pytest.approx(np.column_stack([track.time, track.pose[:, :2]]), abs=1e-9)
    assert found["/scan"][-1][2].ranges == pytest.approx(ranges[-1])
    last = found["/joint_states"][-1][2]
    assert [each.position for each in last.joints][: joints.shape[1]] == pytest.approx(joints[-1])
    assert [each.name for each in last.joints][-1] == "gripper"
    assert (
        found["/pictures/left_side"][0][2].data
        == (run / "evidence" / "001_MOVE_TO_left_side.png").read_bytes()
    )


def test_events_are_those_of_the_journal_in_words(run: Path, tmp_path: Path) -> None:
    write_mcap(read_run(run), tmp_path / "run.mcap")
    events = [each for _, _, each in messages(tmp_path / "run.mcap")["/events"]]
    assert Counter(each.name for each in events) == {"RUN": 1, "PLAN": 1, "START": 1, "RESULT": 1, "END": 1}
    assert [each.message for each in events if each.name in ("START", "RESULT")] == [
        "1. MOVE_TO: from at_home to at_shelf",
        "1. MOVE_TO: Success",
    ]


def test_what_the_run_was_is_told_in_the_file(run: Path, tmp_path: Path) -> None:
    write_mcap(read_run(run), tmp_path / "run.mcap")
    with (tmp_path / "run.mcap").open("rb") as file:
        reader = make_reader(file)
        (about,) = [each.metadata for each in reader.iter_metadata()]
        (summary,) = list(reader.iter_attachments())
    assert (about["outcome"], about["seed"], about["task"]) == ("Success", "0", "Drive to a shelf")
    assert orjson.loads(summary.data)["outcome"] == "Success"


def test_a_run_whose_task_is_gone_has_no_map_and_one_with_damaged_readings_is_told(
    run: Path, tour: Path, tmp_path: Path
) -> None:
    tour.unlink()
    assert "/map" not in write_mcap(read_run(run), tmp_path / "run.mcap")
    (run / "evidence" / "end_readings.npz").write_bytes(b"PK damaged")
    with pytest.raises(NoRun, match=r"end_readings\.npz in it holds no readings"):
        write_mcap(read_run(run), tmp_path / "run.mcap")
