"""Makers' EDS and DCF files, with the quirks that they have."""

from __future__ import annotations

import random
from pathlib import Path
from typing import Any

import pytest

from benchmarks.damage.mutated_eds import checked, mutated_eds, robot_with_eds
from handcart.backends.can.eds.eds_file import missing_objects, read_eds
from handcart.files.errors import FileError

OWN = Path(__file__).resolve().parents[4] / "backends" / "can" / "drives" / "drive.eds"
HEAD = """\
; made up for this test
[FileInfo]
FileName=small.eds

[DeviceInfo]
VendorName=Nobody
VendorNumber=0x9A
BaudRate_500=1
"""
WORD = """
[6040]
ParameterName=Controlword
ObjectType=0x7
DataType=0x0006
AccessType=rww
PDOMapping=1
"""


def eds(folder: Path, text: str, encoding: str = "utf-8") -> Path:
    path = folder / "small.eds"
    path.write_bytes(text.encode(encoding))
    return path


def refused(folder: Path, text: str) -> list[str]:
    path = eds(folder, text)
    with pytest.raises(FileError) as error:
        read_eds(path, 5)
    return [str(finding).removeprefix(f"{path}:") for finding in error.value.findings]


def test_quirks_that_are_taken(tmp_path: Path) -> None:
    """Windows-1252, a byte order mark, no object type, spaces in formulas, limits and defaults left empty."""
    text = (
        HEAD.replace("Nobody", "Müller Größe")
        + WORD
        + """
[100B]
ParameterName=Node ID
DataType=0x0005
AccessType=ro
LowLimit=
HighLimit=
DefaultValue=$NODEID

[1014]
ParameterName=COB-ID emergency   ; as usual
DataType=7
AccessType=RO
DefaultValue=$NodeID + 0x80

[1018]
ParameterName=Identity
ObjectType=9
SubNumber=2
[1018Sub1]
ParameterName=Vendor
DataType=0x0007
AccessType=ro
DefaultValue=0x9A
ParameterValue=
"""
    )
    for encoding in ("utf-8", "utf-8-sig", "cp1252"):
        read: Any = read_eds(eds(tmp_path, text, encoding), 5)
        assert read[0x6040].data_type == 6
        assert read[0x1014].default == 0x85
        assert read[0x100B].default is None
        assert read[0x1018][1].default == 0x9A
        assert read.device_information.vendor_name == "Müller Größe"


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (
            "[6041]\nParameterName=Statusword\nAccessType=ro\n",
            "16:1: [6041] has no DataType; needed: DataType=...",
        ),
        (
            "[6041]\nParameterName=Statusword\nDataType=\nAccessType=ro\n",
            "16:1: [6041] has no DataType; needed: DataType=...",
        ),
        (
            "[6041]\nParameterName=Statusword\nDataType= 0x6h\nAccessType=ro\n",
            "18:11: DataType in [6041] is '0x6h'; allowed: a number such as 10",
        ),
        (
            "[6083sub1]\nParameterName=A\nDataType=7\nAccessType=rw\n",
            "16:1: [6083sub1] belongs to no object; ",
        ),
        ("[6040]\nParameterName=Again\n", "16:1: [6040] has no AccessType"),
        ("this is no line\n", "16:1: is not a line of an EDS: 'this is no line\\n'"),
    ],
)
def test_what_the_library_chokes_on_is_told_with_its_place(tmp_path: Path, wrong: str, message: str) -> None:
    assert message in refused(tmp_path, HEAD + WORD + wrong)[0]


def test_all_of_it_at_once(tmp_path: Path) -> None:
    text = (HEAD + WORD).replace("0x9A", "009").replace("0x0006", "word").replace("ParameterName", "Name")
    assert [item.split(" ")[0] for item in refused(tmp_path, text)] == ["7:14:", "10:1:", "13:10:"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (HEAD + WORD + WORD, "17:1: [6040] is there twice; allowed: once"),
        (HEAD + WORD + "AccessType=rw\n", "16:1: AccessType is there twice in [6040]; allowed: once"),
        ("ParameterName=A\n" + HEAD, "1:1: is outside any section; allowed: [SECTION] before it"),
        (HEAD, "1:1: it describes no object; allowed: sections such as [6040]"),
        ("", "1:1: the section [DeviceInfo] is missing; needed by CiA 306"),
    ],
)
def test_syntax(tmp_path: Path, text: str, message: str) -> None:
    assert refused(tmp_path, text) == [message]


def test_what_a_drive_needs(tmp_path: Path) -> None:
    read = read_eds(eds(tmp_path, HEAD + WORD), 5)
    (finding,) = missing_objects(read, {0x6040: "controlword", 0x6041: "statusword"}, "small.eds")
    assert str(finding) == "small.eds:1:1: it describes no 6041h (statusword); needed: all of them"
    assert missing_objects(read_eds(OWN, 5), {0x6040: "controlword", 0x6041: "statusword"}, "drive.eds") == []


@pytest.mark.slow
def test_damaged_files_are_refused_in_words(tmp_path: Path) -> None:
    """T14: 200 files, each with a few bytes changed: read, or refused with a place; never a traceback."""
    rng, whole = random.Random(8), OWN.read_bytes()
    ends = {"read": 0, "refused": 0}
    for _ in range(200):
        damaged = bytearray(whole[: 4000 + rng.randrange(len(whole))])
        for _ in range(rng.randint(1, 3)):
            damaged[rng.randrange(len(damaged))] = rng.choice(b"=[];\n\x00\xff0x9aZ ")
        path = tmp_path / "damaged.eds"
        path.write_bytes(bytes(damaged))
        try:
            read_eds(path, 5)
            ends["read"] += 1
        except FileError as error:
            assert all(finding.line >= 1 and finding.column >= 1 for finding in error.findings)
            ends["refused"] += 1
    assert min(ends.values()) > 10


def test_no_file(tmp_path: Path) -> None:
    """T1: missing, a folder."""
    for path in (tmp_path / "missing.eds", tmp_path):
        with pytest.raises(FileError):
            read_eds(path, 5)


def test_spellings_of_the_standard_are_read(tmp_path: Path) -> None:
    """Octal numbers, keys and sections in any case, empty numbers, both spellings, the end of a DOS file."""
    text = (HEAD + WORD).replace("0x9A", "012").replace("[DeviceInfo]", "[deviceinfo]")
    text = text.replace("ParameterName", "parametername").replace("PDOMapping=1", "PDOMAPPING=")
    text += "DefaultValue=017\n[DeviceCommissioning]\nNodeID=012\nBaudrate=0x1F4\n\x1a"
    dictionary: Any = read_eds(eds(tmp_path, text), 5)
    assert dictionary.device_information.vendor_number == 10
    assert dictionary.bitrate == 500_000
    assert dictionary[0x6040].name == "Controlword"
    assert dictionary[0x6040].default == 15
    assert not dictionary[0x6040].pdo_mappable


@pytest.mark.parametrize("encoding", ["utf-16", "utf-8-sig", "cp1252"])
@pytest.mark.parametrize("ends", ["\r\n", "\r", "\n"])
def test_encodings_and_line_ends_are_read(tmp_path: Path, encoding: str, ends: str) -> None:
    dictionary: Any = read_eds(eds(tmp_path, (HEAD + WORD).replace("\n", ends), encoding), 5)
    assert dictionary[0x6040].data_type == 6


def test_text_that_looks_octal_stays_text(tmp_path: Path) -> None:
    text = HEAD + "[1009]\nParameterName=Version\nDataType=9\nAccessType=ro\nDefaultValue=0123\n"
    dictionary: Any = read_eds(eds(tmp_path, text), 5)
    assert dictionary[0x1009].default == "0123"


def test_names_of_some_members_of_a_compact_array_are_read(tmp_path: Path) -> None:
    array = (
        "[2310]\nParameterName=A\nObjectType=8\nDataType=6\nAccessType=rw\nCompactSubObj=3\nDefaultValue=7\n"
    )
    names = "[2310Name]\nNrOfEntries=1\n2=second\n"
    dictionary: Any = read_eds(eds(tmp_path, HEAD + array + names + WORD), 5)
    assert dictionary[0x2310][3].default == 7
    assert dictionary[0x6040].data_type == 6


def test_default_of_a_signed_object_has_its_sign(tmp_path: Path) -> None:
    text = HEAD + "[2102]\nParameterName=S\nDataType=2\nAccessType=rw\nDefaultValue=0xFB\n"
    dictionary: Any = read_eds(eds(tmp_path, text), 5)
    assert dictionary[0x2102].default == -5


@pytest.mark.slow
def test_mutated_eds_gives_no_traceback(tmp_path: Path) -> None:
    robot = robot_with_eds(tmp_path)
    for seed in range(12):
        content, words = mutated_eds(seed)
        (tmp_path / "maker.eds").write_bytes(content)
        status, err = checked(robot)
        assert status in (0, 2), (words, err)
