"""A run as MCAP, read back by the reader of those who made the format."""

from __future__ import annotations

import shutil
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import orjson
import pytest
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

from handcart.evaluation.viewing.playback.playback import Playback
from handcart.tools.main import main
from tests.tools.conftest import LIBRARY, TOUR, Said

SCHEMAS = {
    "/camera": "CompressedImage",
    "/events": "Log",
    "/joint_states": "JointStates",
    "/map": "Grid",
    "/particles": "PosesInFrame",
    "/pose": "PoseInFrame",
    "/scan": "LaserScan",
    "/scenery": "SceneUpdate",
    "/tf": "FrameTransforms",
    "/things": "SceneUpdate",
    "/truth": "PoseInFrame",
}


@pytest.fixture(scope="module")
def ran(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a run that is over."""
    folder = tmp_path_factory.mktemp("tour")
    for name in ("world.yaml", "map.yaml", "map.png", "places.yaml", "catalogue.yaml"):
        (folder / name).write_bytes((LIBRARY / name).read_bytes())
    (folder / "tour.yaml").write_text(TOUR, encoding="utf-8")
    with pytest.raises(SystemExit) as end:
        main(["run", str(folder / "tour.yaml"), "--runs", str(folder / "runs"), "--no-report"])
    assert not end.value.code
    return folder / "runs" / "tour-0"


@pytest.fixture
def run(ran: Path, tmp_path: Path) -> Path:
    """A copy of it."""
    return Path(shutil.copytree(ran, tmp_path / "runs" / ran.name, ignore=shutil.ignore_patterns("control*")))


def messages(path: Path) -> dict[str, list[tuple[str, float, Any]]]:
    """Return schema, time and content of the messages, by topic."""
    found: dict[str, list[tuple[str, float, Any]]] = {}
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for schema, channel, message, content in reader.iter_decoded_messages():
            assert schema is not None
            found.setdefault(channel.topic, []).append((schema.name, message.log_time / 1e9, content))
    return found


def counts(recorded: Playback) -> dict[str, int]:
    """Return the expected number of messages of a run, by topic."""
    rows, moves = recorded.rows, sum(len(thing.time) for thing in recorded.things.values())
    each_row = dict.fromkeys(("/pose", "/tf", "/truth", "/joint_states"), len(rows.time))
    rest = {"/scan": len(rows.scan_time), "/things": moves, "/scenery": len(recorded.scenery.solids)}
    rest |= {"/particles": len(rows.cloud_time), "/camera": len(rows.picture_time)}
    found = {"/map": 1, "/events": len(recorded.run.records), **each_row, **rest}
    return {topic: count for topic, count in found.items() if count}


@pytest.mark.slow
def test_all_that_was_recorded_is_there_once(
    handcart: Callable[..., Said], run: Path, tmp_path: Path
) -> None:
    path, recorded = tmp_path / "run.mcap", Playback.read(run)
    said = handcart("export", run, "-o", path)
    expected = counts(recorded)
    assert (
        said.out == f"written: {path}, " + ", ".join(f"{expected[at]} {at}" for at in sorted(expected)) + "\n"
    )
    found, rows = messages(path), recorded.rows
    assert {topic: len(item) for topic, item in found.items()} == expected
    for topic, item in found.items():
        assert {schema for schema, _, _ in item} == {f"foxglove.{SCHEMAS[topic]}"}
    assert len(rows.time) > 200
    poses = [(at, item.pose.position.x, item.pose.position.y) for _, at, item in found["/pose"]]
    assert np.array(poses) == pytest.approx(np.column_stack([rows.time, rows.pose[:, :2]]), abs=1e-9)
    true = [item.pose.orientation.w for _, _, item in found["/truth"]]
    assert true == pytest.approx(rows.truth[:, 3])
    moved = found["/tf"][-1][2].transforms[0]
    assert (moved.parent_frame_id, moved.child_frame_id) == ("map", "base")
    assert (moved.translation.x, moved.translation.y) == pytest.approx(rows.pose[-1, :2])
    assert found["/scan"][-1][2].ranges == pytest.approx(recorded.ranges(-1))
    robot = recorded.scenery.robot
    joints = {joint.name: joint.position for joint in found["/joint_states"][-1][2].joints}
    assert [joints[name] for name in robot.joints] == pytest.approx(rows.joints[-1])
    assert joints["left_finger"] == joints["right_finger"] == pytest.approx(rows.width[-1] / 2)


@pytest.mark.slow
def test_what_stood_around_stands_where_it_stood(
    handcart: Callable[..., Said], run: Path, tmp_path: Path
) -> None:
    handcart("export", run, "-o", tmp_path / "run.mcap")
    found, recorded = messages(tmp_path / "run.mcap"), Playback.read(run)
    drawn = {item.entities[0].id: item.entities[0].cubes[0] for _, _, item in found["/scenery"]}
    pillar = next(solid for solid in recorded.scenery.solids if solid.name == "pillar")
    assert (drawn["pillar"].pose.position.x, drawn["pillar"].size.z) == pytest.approx((pillar.pose[0], 2.0))
    (grid,) = (item for _, _, item in found["/map"])
    cells = np.frombuffer(grid.data, np.int8).reshape(-1, grid.column_count)
    x, y = pillar.pose[0] - grid.pose.position.x, pillar.pose[1] - grid.pose.position.y
    row, column, near = (round(item / grid.cell_size.x) for item in (y, x, 0.3))
    around = slice(column - near, column + near)
    assert 100 in cells[row - near : row + near, around]
    assert 100 not in cells[len(cells) - row - near : len(cells) - row + near, around]


@pytest.mark.slow
def test_events_are_in_words_and_what_the_run_was_is_told(
    handcart: Callable[..., Said], run: Path, tmp_path: Path
) -> None:
    handcart("export", run, "-o", tmp_path / "run.mcap")
    events = [item for _, _, item in messages(tmp_path / "run.mcap")["/events"]]
    assert Counter(event.name for event in events) == {"RUN": 1, "PLAN": 1, "START": 1, "RESULT": 1, "END": 1}
    assert [event.message for event in events if event.name in ("START", "RESULT")] == [
        "1. MOVE_TO: from at_home to at_shelf",
        "1. MOVE_TO: Success",
    ]
    with (tmp_path / "run.mcap").open("rb") as file:
        reader = make_reader(file)
        (about,) = [item.metadata for item in reader.iter_metadata()]
        attached = {attachment.name: attachment.data for attachment in reader.iter_attachments()}
    assert (about["outcome"], about["seed"], about["task"]) == ("Success", "0", "Drive to a shelf")
    assert orjson.loads(attached["summary.json"])["outcome"] == "Success"
    assert attached["robot.urdf"].decode() == Playback.read(run).scenery.robot.urdf


@pytest.mark.slow
def test_a_run_that_was_not_recorded_is_told(
    handcart: Callable[..., Said], tour: Path, tmp_path: Path
) -> None:
    said = handcart("campaign", tour, "--trials", "1", "--jobs", "1", "--runs", tmp_path / "runs")
    assert said.status == 0
    said = handcart("export", tmp_path / "runs" / "tour-0", "-o", tmp_path / "run.mcap")
    assert (said.status, "`handcart run` with the same task and seed records it" in said.err) == (2, True)
    assert not (tmp_path / "run.mcap").exists()
