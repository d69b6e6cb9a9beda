"""The journal (rows D1 to D5, D10, D11, D14)."""

import os
import stat
from pathlib import Path

import pytest

from handcart.networks.journal.journal import Journal, RunAlive, check_not_alive
from handcart.networks.journal.journal_record import JournalError, read_journal
from handcart.networks.operator.asking import NotAlive, ask


def written(path: Path, count: int = 4) -> bytes:
    with Journal(path, clock=lambda: 1.7e9) as journal:
        for number in range(count):
            journal.append("STEP", 0.05 * number, {"n": number, "words": "naïve\n", "xs": [1.0, None]})
    return path.read_bytes()


def test_read_back(tmp_path: Path) -> None:
    path = tmp_path / "j.jsonl"
    written(path)
    contents = read_journal(path)
    assert contents.torn_at is None
    assert [record["n"] for record in contents.records] == [0, 1, 2, 3]
    assert contents.records[1]["p"] == contents.records[0]["h"]
    assert stat.S_IMODE(path.stat().st_mode) == 0o600


def test_wall_clock_is_written_to_the_microsecond(tmp_path: Path) -> None:
    times = [1.7e9 + 0.1234567 * number for number in range(200)] + [0.0, 2.5, 4.1e9 + 0.9999996]
    clock = iter(times)
    with Journal(tmp_path / "j.jsonl", clock=lambda: next(clock)) as journal:
        for _ in times:
            journal.append("STEP", 0.0, {})
    found = [record["wall"]["unix_s"] for record in read_journal(tmp_path / "j.jsonl").records]
    assert found == pytest.approx(times, rel=0.0, abs=0.75e-6), "a float of today has steps of 0.24 us"
    assert all(len(repr(time_s).partition(".")[2]) <= 6 for time_s in found)


def test_times_are_written_to_the_microsecond(tmp_path: Path) -> None:
    """Also where several records have the same time."""
    times = [0.0, 0.05, 0.05, 0.1234564, 0.1234566, 0.05, 1e5 + 0.0000014]
    with Journal(tmp_path / "j.jsonl") as journal:
        for time_s in times:
            journal.append("STEP", time_s, {})
    found = [record["t"] for record in read_journal(tmp_path / "j.jsonl").records]
    assert found == [0.0, 0.05, 0.05, 0.123456, 0.123457, 0.05, 100000.000001]


def test_each_record_is_written_at_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    real, calls = os.write, []

    def note(file: int, line: bytes) -> int:
        calls.append(line)
        return real(file, line)

    monkeypatch.setattr(os, "write", note)
    whole = written(tmp_path / "j.jsonl")
    assert calls == whole.splitlines(keepends=True)


def test_truncated_at_any_byte(tmp_path: Path) -> None:
    """D1: complete records are there, the torn tail is reported."""
    whole = written(tmp_path / "j.jsonl", 3)
    ends = [number for number, byte in enumerate(whole) if byte == 10]
    torn = tmp_path / "torn.jsonl"
    for length in range(len(whole)):
        torn.write_bytes(whole[:length])
        contents = read_journal(torn)
        assert len(contents.records) == sum(end < length for end in ends)
        complete = length == 0 or length - 1 in ends
        assert (contents.torn_at is None) == complete


def test_a_journal_larger_than_any_run_makes_it_is_refused(tmp_path: Path) -> None:
    """D2: the memory for it isn't there; asking a run that is over reads it as well."""
    path = tmp_path / "journal.jsonl"
    written(path, 3)
    os.truncate(path, 10**11)
    with pytest.raises(JournalError, match="more than 134217728 bytes"):
        read_journal(path)
    with pytest.raises(NotAlive, match="no journal can be read there"):
        ask(tmp_path, {"do": "status"}, 1.0)


@pytest.mark.slow
def test_any_flipped_bit(tmp_path: Path) -> None:
    """D2, D3: refused in the middle, the newline before the last record too; torn in the last record."""
    whole = written(tmp_path / "j.jsonl", 3)
    last = whole[:-1].rindex(b"\n") + 1
    bad = tmp_path / "bad.jsonl"
    for place in range(len(whole)):
        for bit in range(8):
            damaged = bytearray(whole)
            damaged[place] ^= 1 << bit
            bad.write_bytes(damaged)
            if place < last:
                with pytest.raises(JournalError, match=r"record \d at byte \d+ isn't what was written"):
                    read_journal(bad)
            else:
                assert read_journal(bad).torn_at is not None


@pytest.mark.parametrize("byte", [0, 0x0B, 0x8A, 0x20])
def test_a_newline_before_the_last_record_is_damage(tmp_path: Path, byte: int) -> None:
    """D2: it hides two records, of which one was whole."""
    whole = bytearray(written(tmp_path / "j.jsonl", 3))
    whole[whole[:-1].rindex(b"\n")] = byte
    (tmp_path / "bad.jsonl").write_bytes(whole)
    with pytest.raises(JournalError, match="record 1 at byte"):
        read_journal(tmp_path / "bad.jsonl")


@pytest.mark.parametrize("byte", [0, 0x0B, 0x8A, 0x20])
def test_a_damaged_last_newline_is_a_torn_record(tmp_path: Path, byte: int) -> None:
    """D3: nothing is hidden by it, whatever a crash left behind it as zeros."""
    whole = bytearray(written(tmp_path / "j.jsonl", 3))
    last = whole[:-1].rindex(b"\n") + 1
    whole[-1] = byte
    for tail in (b"", b"\0" * 5):
        (tmp_path / "bad.jsonl").write_bytes(whole + tail)
        contents = read_journal(tmp_path / "bad.jsonl")
        assert (len(contents.records), contents.torn_at) == (2, last)


@pytest.mark.parametrize("tail", [b"\0" * 4096, b"garbage\nmore\n", b"{}\n", b"[]\n", b"1\n", None])
def test_tails(tmp_path: Path, tail: bytes | None) -> None:
    """D4: None means the last record once more."""
    path = tmp_path / "j.jsonl"
    whole = written(path)
    path.write_bytes(whole + (tail if tail is not None else whole.splitlines(keepends=True)[-1]))
    contents = read_journal(path)
    assert (len(contents.records), contents.torn_at) == (4, len(whole))


@pytest.mark.parametrize("doubled", [0, 1, 2])
def test_a_doubled_record_that_others_follow_is_refused(tmp_path: Path, doubled: int) -> None:
    """D2: if it counted as torn, it would hide the records after it, the last one too."""
    lines = written(tmp_path / "j.jsonl").splitlines(keepends=True)
    lines.insert(doubled, lines[doubled])
    (tmp_path / "j.jsonl").write_bytes(b"".join(lines))
    wrong = f"record {doubled + 1} at byte .* isn't what was written: a whole record {doubled} is there"
    with pytest.raises(JournalError, match=wrong):
        read_journal(tmp_path / "j.jsonl")


def test_a_last_record_that_does_not_follow_is_refused(tmp_path: Path) -> None:
    """D2: whole and of the right number, but not written after the one before it."""
    lines = written(tmp_path / "j.jsonl").splitlines(keepends=True)
    with Journal(tmp_path / "other.jsonl", clock=lambda: 0.0) as other:
        for number in range(4):
            other.append("STEP", 9.0, {"n": number})
    lines[3] = (tmp_path / "other.jsonl").read_bytes().splitlines(keepends=True)[3]
    (tmp_path / "j.jsonl").write_bytes(b"".join(lines))
    with pytest.raises(JournalError, match=r"record 3 at byte .*: it doesn't follow the record before it"):
        read_journal(tmp_path / "j.jsonl")


def test_edited_or_removed_record(tmp_path: Path) -> None:
    path = tmp_path / "j.jsonl"
    lines = written(path).splitlines(keepends=True)
    path.write_bytes(b"".join([lines[0], *lines[2:]]))
    with pytest.raises(JournalError, match="record 1"):
        read_journal(path)
    path.write_bytes(b"".join([lines[0], lines[1].replace(b'"n":1', b'"n":7'), *lines[2:]]))
    with pytest.raises(JournalError, match="record 1"):
        read_journal(path)


def test_never_written_over(tmp_path: Path) -> None:
    path = tmp_path / "j.jsonl"
    written(path)
    with pytest.raises(JournalError) as error:
        Journal(path)
    assert error.value.exit_status == 5


def test_links_are_not_followed(tmp_path: Path) -> None:
    """D14."""
    (tmp_path / "link").symlink_to(tmp_path / "target")
    with pytest.raises(JournalError):
        Journal(tmp_path / "link")
    assert not (tmp_path / "target").exists()


def test_no_folder(tmp_path: Path) -> None:
    """D10."""
    with pytest.raises(JournalError, match="can't be created"):
        Journal(tmp_path / "none" / "j.jsonl")


def test_disk_full_poisons(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """D5, D7: one more try, then nothing more."""
    path = tmp_path / "j.jsonl"
    journal = Journal(path)
    journal.append("ONE", 0.0, {})
    before = path.read_bytes()
    calls = []

    def short(file: int, line: bytes) -> int:
        calls.append(line)
        return real(file, line[:5])

    real = os.write
    monkeypatch.setattr(os, "write", short)
    with pytest.raises(JournalError, match="No space left"):
        journal.append("TWO", 0.0, {})
    monkeypatch.setattr(os, "write", real)
    assert len(calls) == 2
    assert path.read_bytes() == before
    with pytest.raises(JournalError):
        journal.append("THREE", 0.0, {})
    journal.close()
    journal.close()


def test_short_write_is_tried_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "j.jsonl"
    real, calls = os.write, []

    def once_short(file: int, line: bytes) -> int:
        calls.append(line)
        return real(file, line[:5] if len(calls) == 1 else line)

    with Journal(path) as journal:
        monkeypatch.setattr(os, "write", once_short)
        journal.append("ONE", 0.0, {})
    assert len(read_journal(path).records) == 1


def test_failed_sync_poisons(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """D8: never tried again."""
    calls = []

    def failing(file: int) -> None:
        calls.append(file)
        raise OSError(5, "Input/output error")

    with Journal(tmp_path / "j.jsonl", sync="always") as journal:
        monkeypatch.setattr(os, "fdatasync", failing)
        for _ in range(2):
            with pytest.raises(JournalError, match="Input/output"):
                journal.append("ONE", 0.0, {})
    assert len(calls) == 1


def test_replaced_file(tmp_path: Path) -> None:
    """D11."""
    path = tmp_path / "j.jsonl"
    with Journal(path) as journal:
        journal.append("ONE", 0.0, {})
        path.rename(tmp_path / "away")
        path.write_bytes(b"")
        with pytest.raises(JournalError, match="replaced"):
            journal.append("TWO", 0.0, {})


def test_replaced_file_is_found_by_the_record_that_follows(tmp_path: Path) -> None:
    path = tmp_path / "j.jsonl"
    with Journal(path) as journal:
        path.rename(tmp_path / "away")
        path.write_bytes(b"")
        journal.append("RESULT", 0.0, {}, is_followed=True)
        with pytest.raises(JournalError, match="replaced"):
            journal.append("START", 0.0, {})


def test_what_is_no_json(tmp_path: Path) -> None:
    with Journal(tmp_path / "j.jsonl") as journal, pytest.raises(JournalError, match="not valid JSON"):
        journal.append("ONE", 0.0, {"thing": object()})


def test_going_on_holds_the_lock(tmp_path: Path) -> None:
    """K11: two processes never write one journal."""
    path = tmp_path / "j.jsonl"
    written(path)
    contents = read_journal(path)
    with Journal.go_on(path, contents):
        with pytest.raises(RunAlive, match="is alive"):
            Journal.go_on(path, contents)
        with pytest.raises(RunAlive):
            check_not_alive(tmp_path, path.name)
    check_not_alive(tmp_path, path.name)
    Journal.go_on(path, contents).close()


def test_going_on_with_what_has_changed_since(tmp_path: Path) -> None:
    path = tmp_path / "j.jsonl"
    written(path)
    before = read_journal(path)
    with Journal.go_on(path, before) as journal:
        journal.append("MORE", 1.0, {})
    with pytest.raises(JournalError, match="has changed since it was read"):
        Journal.go_on(path, before)


def test_going_on_with_what_is_shorter_than_it_was_read(tmp_path: Path) -> None:
    path = tmp_path / "j.jsonl"
    lines = written(path).splitlines(keepends=True)
    before = read_journal(path)
    path.write_bytes(b"".join(lines[:-1]))
    with pytest.raises(JournalError, match="has changed since it was read"):
        Journal.go_on(path, before)
    assert path.read_bytes() == b"".join(lines[:-1])


def test_going_on_follows_no_link(tmp_path: Path) -> None:
    """D14."""
    path = tmp_path / "j.jsonl"
    written(path)
    contents = read_journal(path)
    path.rename(tmp_path / "away")
    path.symlink_to(tmp_path / "away")
    with pytest.raises(JournalError, match="can't be opened"):
        Journal.go_on(path, contents)


def test_torn_tail_is_kept_aside_and_links_are_not_followed(tmp_path: Path) -> None:
    """D1, D14: not even where the tail's copy goes."""
    path = tmp_path / "j.jsonl"
    whole = written(path)
    path.write_bytes(whole + b'{"q":9')
    contents = read_journal(path)
    (tmp_path / "keep").write_bytes(b"mine")
    torn = path.with_name(f"{path.name}.torn-{len(whole)}")
    torn.symlink_to(tmp_path / "keep")
    Journal.go_on(path, contents).close()
    assert (tmp_path / "keep").read_bytes() == b"mine"
    assert (torn.read_bytes(), path.read_bytes()) == (b'{"q":9', whole)


def test_what_is_cut_off_and_the_folder_are_brought_to_the_disk(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """D13: a journal that is new, or shorter, is so after a power cut too."""
    real = os.fsync
    synced: list[int] = []

    def sync(file: int) -> None:
        synced.append(os.fstat(file).st_ino)
        real(file)

    monkeypatch.setattr(os, "fsync", sync)
    path = tmp_path / "j.jsonl"
    whole = written(path)
    assert tmp_path.stat().st_ino in synced
    synced.clear()
    path.write_bytes(whole + b"torn")
    Journal.go_on(path, read_journal(path)).close()
    assert path.stat().st_ino in synced


def test_a_short_write_after_going_on_is_cut_back_to_what_was_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """D7"""
    path, real = tmp_path / "j.jsonl", os.write
    whole = written(path)
    with Journal.go_on(path, read_journal(path)) as journal:
        monkeypatch.setattr(os, "write", lambda file, line: real(file, line[:5]))
        with pytest.raises(JournalError, match="No space left"):
            journal.append("MORE", 1.0, {})
        monkeypatch.setattr(os, "write", real)
    assert path.read_bytes() == whole


def test_a_sound_record_of_another_journal_breaks_the_chain(tmp_path: Path) -> None:
    """D2: its own checksum is right, and so is its number."""
    lines = written(tmp_path / "j.jsonl").splitlines(keepends=True)
    with Journal(tmp_path / "other.jsonl", clock=lambda: 0.0) as other:
        for number in range(2):
            other.append("STEP", 9.0, {"n": number})
    foreign = (tmp_path / "other.jsonl").read_bytes().splitlines(keepends=True)[1]
    (tmp_path / "j.jsonl").write_bytes(b"".join([lines[0], foreign, *lines[2:]]))
    with pytest.raises(JournalError, match="record 1"):
        read_journal(tmp_path / "j.jsonl")
