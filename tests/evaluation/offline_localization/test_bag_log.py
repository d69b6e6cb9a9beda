"""ROS bags with faults: damaged files, unknown types, invalid stamps."""

from __future__ import annotations

import math
from pathlib import Path
from typing import IO

import numpy as np
import pytest

pytest.importorskip("rosbags", reason="bags are read by the extra `bags`")

from benchmarks.damage.bag_files import START_TIME_S, TOPIC_TYPES, small_drive, write_bag
from benchmarks.damage.mutated_bags import is_silent, mutated_bag, played
from handcart.evaluation.offline_localization.bags.bag_log import read_bag_log
from handcart.evaluation.offline_localization.logs.drive_log import DriveLog
from handcart.files.errors import FileError

DRIVE = small_drive(duration=20.0)


@pytest.fixture(scope="module")
def bags(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A whole bag in each format."""
    folder = tmp_path_factory.mktemp("bags")
    return {
        "SQLITE3": write_bag(folder / "sqlite", DRIVE, "SQLITE3"),
        "MCAP": write_bag(folder / "mcap", DRIVE, "MCAP"),
        "ROS1": write_bag(folder / "drive.bag", DRIVE, "ROS1"),
    }


def storage_of(bag: Path) -> Path:
    """The file with the messages."""
    return bag if bag.is_file() else next(path for path in bag.iterdir() if path.suffix != ".yaml")


def copied(bag: Path, folder: Path, share: float = 1.0, metadata: bool = True) -> Path:
    """A copy of a bag, cut off after a share of its bytes."""
    content = storage_of(bag).read_bytes()
    folder.mkdir(exist_ok=True)
    (folder / storage_of(bag).name).write_bytes(content[: int(share * len(content))])
    if metadata and bag.is_dir():
        (folder / "metadata.yaml").write_bytes((bag / "metadata.yaml").read_bytes())
    return folder


def refusal(path: Path, stamps: str = "header") -> str:
    with pytest.raises(FileError) as caught:
        read_bag_log(path, stamps=stamps)  # type: ignore[arg-type]
    return "\n".join(str(finding.message) for finding in caught.value.findings)


def same(one: DriveLog, other: DriveLog) -> bool:
    return all(
        np.array_equal(getattr(one, name), getattr(other, name), equal_nan=True)
        for name in ("times", "rates", "wheels", "fixes", "sigmas")
    )


@pytest.mark.parametrize("storage", ["SQLITE3", "MCAP", "ROS1"])
def test_a_whole_bag_is_read_without_a_note(bags: dict[str, Path], storage: str) -> None:
    log = read_bag_log(bags[storage], "/truth")
    assert log.notes == ()
    assert np.isfinite(log.fixes[:, 0]).sum() == len(DRIVE.fix_rows)
    assert np.nansum(log.wheels[:, 0]) == pytest.approx(DRIVE.times[-1], abs=0.2)
    turns = log.odometry_turns
    assert turns is not None
    assert np.nanmax(np.abs(turns)) == pytest.approx(0.15, abs=0.01)


@pytest.mark.parametrize("storage", ["SQLITE3", "MCAP"])
def test_a_storage_file_alone_reads_as_its_folder_does(
    bags: dict[str, Path], storage: str, tmp_path: Path
) -> None:
    whole = read_bag_log(bags[storage])
    alone = read_bag_log(storage_of(bags[storage]))
    without = read_bag_log(copied(bags[storage], tmp_path / "bag", metadata=False))
    assert same(whole, alone)
    assert same(whole, without)
    assert "has no metadata.yaml" in without.notes[0]


@pytest.mark.parametrize("storage", ["SQLITE3", "ROS1"])
def test_a_bag_cut_off_is_read_up_to_there(bags: dict[str, Path], storage: str, tmp_path: Path) -> None:
    whole = read_bag_log(bags[storage])
    log = read_bag_log(copied(bags[storage], tmp_path / "bag", share=0.85))
    assert any("damaged or cut off" in note for note in log.notes)
    count = len(log.times)
    assert 0.3 * len(whole.times) < count < len(whole.times)
    sure = count - 10  # SQLite may lose single rows on the last pages
    np.testing.assert_allclose(log.times[:sure], whole.times[:sure], atol=1e-6)
    np.testing.assert_array_equal(log.rates[:sure], whole.rates[:sure])


@pytest.mark.slow
def test_a_cut_mcap_is_read_up_to_its_last_chunk(tmp_path: Path) -> None:
    bag = write_bag(tmp_path / "bag", small_drive(duration=60.0), "MCAP")
    whole, log = read_bag_log(bag), read_bag_log(copied(bag, tmp_path / "cut", share=0.85))
    assert any("damaged or cut off" in note for note in log.notes)
    assert 0.3 * len(whole.times) < len(log.times) < len(whole.times)
    np.testing.assert_array_equal(log.rates, whole.rates[: len(log.times)])


def test_a_folder_without_a_bag_says_what_it_needs(tmp_path: Path) -> None:
    assert "no .mcap, .db3 or .bag file in the folder" in refusal(tmp_path)


def test_stamps_that_are_zero_offer_the_receive_time(tmp_path: Path) -> None:
    bag = write_bag(tmp_path / "bag", DRIVE, stamp=lambda topic, time: 0.0)
    assert "/imu: all stamps are zero (400 messages)" in refusal(bag)
    assert "--stamps receive" in refusal(bag)
    log = read_bag_log(bag, stamps="receive")
    assert log.times[-1] == pytest.approx(DRIVE.times[-1], abs=0.01)
    assert "played by the times at which the messages were recorded" in log.notes[0]


def test_a_clock_that_falls_back_is_refused_with_its_time(tmp_path: Path) -> None:
    bag = write_bag(
        tmp_path / "bag", DRIVE, stamp=lambda topic, time: START_TIME_S + time - 20.0 * (time > 9.99)
    )
    assert "/odom: stamps jump by -20.0 s after 10.0 s" in refusal(bag)


def test_a_receiver_on_gps_time_is_another_clock(tmp_path: Path) -> None:
    bag = write_bag(
        tmp_path / "bag", DRIVE, stamp=lambda topic, time: START_TIME_S + time + 18.0 * (topic == "/fix")
    )
    assert "18.00 s older" in refusal(bag)


def test_a_topic_of_another_type_is_refused(tmp_path: Path) -> None:
    topics = TOPIC_TYPES | {"/imu": TOPIC_TYPES["/odom"], "/odom": TOPIC_TYPES["/imu"]}
    assert "messages can't be read as" in refusal(write_bag(tmp_path / "bag", DRIVE, topics=topics))


def test_readings_beyond_any_vehicle_are_left_out(tmp_path: Path) -> None:
    rates = DRIVE.rates.copy()
    rates[100:110] = 1e9
    log = read_bag_log(write_bag(tmp_path / "bag", DRIVE._replace(rates=rates)))
    assert "/imu: 10 of 400 readings are beyond any vehicle's" in log.notes[0]
    assert np.nanmax(np.abs(log.rates)) < 1.0
    rates[:] = 1e9
    assert "needed: SI units" in refusal(write_bag(tmp_path / "all", DRIVE._replace(rates=rates)))


def test_a_bag_without_an_imu_turns_as_the_twist_says(tmp_path: Path) -> None:
    topics = {topic: kind for topic, kind in TOPIC_TYPES.items() if topic != "/imu"}
    log = read_bag_log(write_bag(tmp_path / "bag", DRIVE, topics=topics))
    assert log.steered
    assert np.abs(log.rates[:, 2]).max() == pytest.approx(0.15, abs=0.01)
    assert "turns as Odometry's twist says" in log.notes[0]


@pytest.mark.slow
def test_a_variance_of_zero_is_no_accuracy(tmp_path: Path, bags: dict[str, Path]) -> None:
    for variance in (0.0, 1e-12):
        log = read_bag_log(write_bag(tmp_path / str(variance), DRIVE._replace(variance=variance)))
        assert np.isnan(log.sigmas).all()
    stated = read_bag_log(bags["MCAP"]).sigmas
    assert np.nanmedian(stated) == pytest.approx(math.sqrt(DRIVE.variance))


@pytest.mark.slow
def test_mutated_bags_are_played_or_refused_in_words(tmp_path: Path) -> None:
    """`benchmarks.damage.mutated_bags` plays 200."""
    for seed in range(12):
        path, words = mutated_bag(tmp_path / str(seed), seed)
        status, out, err = played(path)
        assert status in (0, 2), f"{words}: {err}"
        assert "Traceback" not in err
        assert not is_silent(status, out), words


@pytest.mark.slow
@pytest.mark.parametrize("mode", ["FILE", "MESSAGE"])
@pytest.mark.parametrize("storage", ["SQLITE3", "MCAP"])
def test_a_compressed_bag_reads_as_a_plain_one(
    bags: dict[str, Path], storage: str, mode: str, tmp_path: Path
) -> None:
    packed = write_bag(tmp_path / "packed", DRIVE, storage, compression=mode)
    plain = read_bag_log(bags[storage])
    assert storage_of(packed).suffix == (".zstd" if mode == "FILE" else storage_of(bags[storage]).suffix)
    assert same(read_bag_log(packed), plain)
    assert same(read_bag_log(storage_of(packed)), plain)
    (packed / "metadata.yaml").unlink()
    assert same(read_bag_log(packed), plain)


def test_a_compressed_bag_cut_off_is_read_up_to_there(tmp_path: Path) -> None:
    file = storage_of(write_bag(tmp_path / "packed", DRIVE, "SQLITE3", compression="FILE"))
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
    log = read_bag_log(file)
    assert 1.0 < log.times[-1] < 0.8 * DRIVE.times[-1]
    assert any("cut off" in note for note in log.notes)


@pytest.mark.parametrize("compression", ["LZ4", "ZSTD"])
def test_an_mcap_with_compressed_chunks_is_read(
    bags: dict[str, Path], compression: str, tmp_path: Path
) -> None:
    chunked = tmp_path / "chunked.mcap"
    with storage_of(bags["MCAP"]).open("rb") as source, chunked.open("wb") as sink:
        _copy_mcap(source, sink, compression)
    assert same(read_bag_log(chunked), read_bag_log(bags["MCAP"]))


def _copy_mcap(source: IO[bytes], sink: IO[bytes], compression: str) -> None:
    """Write all messages again, in chunks that are compressed."""
    from mcap.reader import make_reader
    from mcap.writer import CompressionType, Writer

    writer, channels = Writer(sink, compression=CompressionType[compression]), dict[int, int]()
    writer.start("ros2", "test")
    for schema, channel, message in make_reader(source).iter_messages():
        if channel.id not in channels:
            assert schema is not None
            number = writer.register_schema(schema.name, schema.encoding, schema.data)
            channels[channel.id] = writer.register_channel(channel.topic, channel.message_encoding, number)
        writer.add_message(channels[channel.id], message.log_time, message.data, message.publish_time)
    writer.finish()  # type: ignore[no-untyped-call]
