"""Every frame in a candump log, bounded; frames in words."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import can
import pytest
from can.io.canutils import CanutilsLogReader

from handcart.backends.can.bus.frame_log import FRAME_NAMES_FILE, MARK_MARGIN_S, MAX_PARTS, FrameLog
from handcart.backends.can.bus.frame_names import FrameNames, PdoField, PdoNames
from handcart.backends.can.bus.frame_words import FrameWords

FIELDS = (
    PdoField(index=0x6041, subindex=0, name="Statusword", bits=16, signed=False),
    PdoField(index=0x6064, subindex=0, name="Position actual value", bits=32, signed=True),
)
NAMED = FrameNames(
    time="robot",
    nodes={1: "the left drive"},
    pdos={0x181: PdoNames(node=1, what="TPDO1", fields=FIELDS)},
)

Make = Callable[..., FrameLog]


def frame(cob_id: int, data: str = "", **more: object) -> can.Message:
    return can.Message(arbitration_id=cob_id, data=bytes.fromhex(data), is_extended_id=False, **more)  # type: ignore[arg-type]


@pytest.fixture
def make_log(clock: Any) -> Iterator[Callable[..., FrameLog]]:
    """Makes logs, and closes them."""
    made: list[FrameLog] = []

    def make(part: int = 2**20) -> FrameLog:
        made.append(FrameLog("cart", clock, lambda: NAMED, part))
        return made[-1]

    yield make
    for log in made:
        log.close()


def read(path: Path) -> list[can.Message]:
    with CanutilsLogReader(path) as reader:
        return list(reader)


def test_all_frames_are_kept_with_those_before_the_folder(tmp_path: Path, clock: Any, make_log: Make) -> None:
    log = make_log()
    log.note(frame(0x601, "4000100000000000"), sent=True)
    log.open(tmp_path)
    clock.now = 0.05
    log.note(frame(0x181, "3702feffffff", timestamp=1.7e9), sent=False)  # another clock's stamp
    log.note(frame(0x181, "3702feffffff", timestamp=0.04), sent=False)
    log.close()
    first, second, third = read(tmp_path / "frames_000.log")
    assert (first.arbitration_id, first.is_rx, first.timestamp) == (0x601, False, 0.0)
    assert (second.data.hex(), second.is_rx, second.timestamp) == ("3702feffffff", True, 0.05)
    assert third.timestamp == 0.04  # its own clock's
    assert FrameNames.model_validate_json((tmp_path / FRAME_NAMES_FILE).read_bytes()) == NAMED


def test_it_doesnt_touch_what_it_notes(tmp_path: Path, clock: Any, make_log: Make) -> None:
    log, one = make_log(), frame(0x80, timestamp=1.7e9)
    log.note(one, sent=True)
    assert (one.timestamp, one.is_rx) == (1.7e9, True)


def test_it_is_bounded(tmp_path: Path, clock: Any, make_log: Make) -> None:
    log = make_log(part=200)
    log.open(tmp_path)
    for number in range(200):
        clock.now = 0.01 * number
        log.note(frame(number), sent=True)
    log.close()
    files = sorted(path.name for path in tmp_path.glob("frames_*.log"))
    assert len(files) == MAX_PARTS
    assert files[0] == "frames_000.log"  # how the drives were set up
    assert read(tmp_path / files[-2])[-1].arbitration_id >= 190
    assert all((tmp_path / file).stat().st_size < 300 for file in files)


def test_a_resumed_run_keeps_the_frames_before_the_crash(tmp_path: Path, clock: Any, make_log: Make) -> None:
    """It has the folder of the run that broke off, and wrote over its first file."""
    for cob_id in (0x181, 0x182, 0x183):
        log = make_log()
        log.open(tmp_path)
        log.note(frame(cob_id), sent=False)
        log.close()
    parts = [tmp_path / f"frames_{number:03d}.log" for number in range(3)]
    assert [[one.arbitration_id for one in read(part)] for part in parts] == [[0x181], [0x182], [0x183]]


def test_the_seconds_around_a_mark(tmp_path: Path, clock: Any, make_log: Make) -> None:
    log = make_log()
    log.open(tmp_path)
    for number in range(100):
        clock.now = 0.1 * number
        log.note(frame(number), sent=True)
        if number == 50:
            log.mark()
            log.note(frame(0x7FF), sent=False)
    log.keep(tmp_path / "evidence" / "003_MOVE_TO_Fail")
    ids = [item.arbitration_id for item in read(tmp_path / "evidence" / "003_MOVE_TO_Fail_frames.log")]
    around = round(MARK_MARGIN_S / 0.1)
    assert ids[: around + 1] == list(range(50 - around, 51))
    assert ids[-around - 1 :] == list(range(99 - around, 100))
    assert len(ids) == len(set(ids))


def test_the_seconds_are_stamped_with_the_robots_time(tmp_path: Path, clock: Any, make_log: Make) -> None:
    """After a pause, or with a clock that counts from 1970, the excerpt has the journal's times."""
    log = make_log()
    clock.now = 1.7e9
    log.note(frame(1), sent=True)
    log.look(12.5)
    clock.now += 0.25
    log.note(frame(2), sent=True)
    log.keep(tmp_path / "end")
    assert [item.timestamp for item in read(tmp_path / "end_frames.log")] == pytest.approx([12.5, 12.75])


def test_a_mark_and_what_follows_at_once_overlap_by_nothing(
    tmp_path: Path, clock: Any, make_log: Make
) -> None:
    log = make_log()
    log.note(frame(1), sent=True)
    log.mark()
    log.note(frame(2), sent=True)
    log.keep(tmp_path / "end")
    assert [item.arbitration_id for item in read(tmp_path / "end_frames.log")] == [1, 2]


def test_a_folder_that_takes_nothing_stops_nobody(tmp_path: Path, clock: Any, make_log: Make) -> None:
    """D6: a disk that takes no more costs the log, not the run."""
    log = make_log()
    log.open(tmp_path / "missing")
    log.note(frame(1), sent=True)
    log.keep(tmp_path / "missing" / "evidence" / "end")
    log.look(0.0)
    log.close()
    assert log.lost == "No such file or directory"


@pytest.mark.parametrize(
    ("cob_id", "data", "who", "what", "words"),
    [
        (0x181, "3702feffffff", "the left drive", "TPDO1", "OPERATION ENABLED, position actual value -2"),
        (0x181, "3702", "the left drive", "TPDO1", "2 bytes; needed: 6"),
        (0x081, "1186010000000000", "the left drive", "EMCY", "error 8611h, following error, register 01h"),
        (0x000, "0101", "the left drive", "NMT", "start"),
        (0x000, "8100", "all", "NMT", "reset node"),
        (0x701, "00", "the left drive", "heartbeat", "boot-up"),
        (0x702, "05", "node 2", "heartbeat", "OPERATIONAL"),
        (0x601, "2b1710003200", "the left drive", "SDO", "of 6 bytes"),
        (0x601, "2b17100032000000", "the left drive", "SDO", "write 1017h:0 50 (32h)"),
        (0x581, "6017100000000000", "the left drive", "SDO", "written 1017h:0"),
        (0x601, "4000100000000000", "the left drive", "SDO", "read 1000h:0"),
        (0x581, "4300100092010200", "the left drive", "SDO", "is 1000h:0 131474 (20192h)"),
        (0x581, "8017100000000906", "the left drive", "SDO", "1017h:0 aborted, code 06090000h"),
        (0x080, "", "all", "SYNC", ""),
        (0x333, "0102", "unknown", "frame", "333h 0102"),
    ],
)
def test_frames_in_words(cob_id: int, data: str, who: str, what: str, words: str) -> None:
    described = FrameWords(NAMED).describe(frame(cob_id, data))
    assert (described.who, described.what, described.words) == (who, what, words)


def test_frames_that_are_none_of_ours_are_told() -> None:
    """C20: error frames, extended and remote ones."""
    words = FrameWords(NAMED)
    assert words.describe(can.Message(is_error_frame=True)).what == "error frame"
    assert words.describe(can.Message(arbitration_id=0x181, is_extended_id=True)).who == "unknown"
    assert words.describe(frame(0x181, is_remote_frame=True)).words == "remote 181h"


def test_a_frame_that_waited_in_the_interface_is_kept(tmp_path: Path, clock: Any, make_log: Make) -> None:
    """The first frame, or all, may be older than a mark looks back, as after a pause of the program."""
    log = make_log()
    log.open(tmp_path)
    clock.now = 30.0
    for stamp in (30.0 - 2 * MARK_MARGIN_S, 30.0):
        log.note(frame(0x181, "3702feffffff", timestamp=stamp), sent=False)
    log.close()
    assert [item.timestamp for item in read(tmp_path / "frames_000.log")] == [30.0 - 2 * MARK_MARGIN_S, 30.0]
