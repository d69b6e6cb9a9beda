"""Logs of CAN frames by other recorders."""

from __future__ import annotations

from pathlib import Path

import can
import pytest

from handcart.backends.can.bus.frame_log import FRAME_NAMES_FILE
from handcart.backends.can.bus.frame_names import FrameNames
from handcart.evaluation.viewing.explanation.bus_log import LOG_SUFFIXES, UnreadableLog, read_log
from handcart.evaluation.viewing.explanation.frames_around import frames_around

FRAMES = [
    can.Message(
        timestamp=0.5 * number,
        arbitration_id=can_id,
        data=bytes.fromhex(data),
        is_extended_id=False,
        channel=1,
    )
    for number, (can_id, data) in enumerate(
        [(0x701, "05"), (0x080, ""), (0x081, "1086010000000000"), (0x701, "7f"), (0x000, "8001")]
    )
]


@pytest.mark.parametrize("kind", LOG_SUFFIXES)
def test_what_python_can_writes_is_read(tmp_path: Path, kind: str) -> None:
    path = tmp_path / f"bus{kind}"
    with can.Logger(path) as writer:
        for frame in FRAMES:
            writer(frame)
    read = read_log(path)
    assert [message.arbitration_id for message in read] == [message.arbitration_id for message in FRAMES]
    assert [bytes(message.data) for message in read] == [bytes(message.data) for message in FRAMES]
    (tmp_path / FRAME_NAMES_FILE).write_text(
        FrameNames(time="unix", nodes={1: "the left drive"}, pdos={}).model_dump_json(), encoding="utf-8"
    )
    excerpt = frames_around(path, tmp_path, float("inf"))
    assert excerpt.frames == len(FRAMES)
    assert "the left drive" in {line.description.who for line in excerpt.lines}
    assert any("error 8610h" in line.description.words for line in excerpt.lines)


def test_a_log_that_is_too_long_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """D6: it would fill the memory."""
    monkeypatch.setattr("handcart.evaluation.viewing.explanation.bus_log.MAX_FRAMES", 10)
    path = tmp_path / "bus.log"
    path.write_text("(0.000000) can 080#\n" * 11, encoding="ascii")
    with pytest.raises(UnreadableLog, match="it has more than 10 frames"):
        read_log(path)
    path.write_text("(0.000000) can 080#\n" * 10, encoding="ascii")
    assert len(read_log(path)) == 10


@pytest.mark.parametrize("kind", LOG_SUFFIXES)
def test_what_is_none_is_told(tmp_path: Path, kind: str) -> None:
    """T1 T14: missing, a folder, another kind, nonsense."""
    path = tmp_path / f"bus{kind}"
    with pytest.raises(UnreadableLog, match=r"the file does not exist; allowed: \.asc, \.blf"):
        read_log(path)
    path.mkdir()
    with pytest.raises(UnreadableLog):
        read_log(path)
    path.rmdir()
    path.write_bytes(bytes(range(256)) * 40)
    try:
        read = read_log(path)
    except UnreadableLog as error:
        assert error.exit_status == 2
    else:
        assert read == []  # comments and garbage that the library passes over
    with pytest.raises(UnreadableLog, match=r"its suffix is '\.txt'"):
        read_log(tmp_path / "bus.txt")
