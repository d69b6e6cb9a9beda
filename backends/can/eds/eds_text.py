"""Spelling of EDS and DCF files (CiA 306) as the library `canopen` needs it; line numbers stay.

CiA 306 compares sections and keys without case, and has decimal, hexadecimal (0x) and octal (leading 0)
numbers. Makers also write `DeviceCommissioning` with its correct spelling, leave numbers empty, and end files
with the end-of-file character of DOS.
"""

from __future__ import annotations

import codecs
import re

SECTION_NAMES = (
    "FileInfo",
    "DeviceInfo",
    "DummyUsage",
    "Comments",
    "DeviceComissioning",
    "MandatoryObjects",
    "OptionalObjects",
    "ManufacturerObjects",
)
"""Section names as the library spells them, including its DeviceComissioning."""
NUMBER_KEYS = (
    "ObjectType",
    "DataType",
    "PDOMapping",
    "SubNumber",
    "CompactSubObj",
    "NrOfEntries",
    "VendorNumber",
    "ProductNumber",
    "RevisionNumber",
    "NrOfRXPDO",
    "NrOfTXPDO",
    "SimpleBootUpMaster",
    "SimpleBootUpSlave",
    "Granularity",
    "DynamicChannelsSupported",
    "GroupMessaging",
    "LSS_Supported",
    "Lines",
    "NodeID",
    "Baudrate",
)
"""Keys whose values are numbers; an empty value counts as a missing key."""
VALUE_KEYS = ("DefaultValue", "ParameterValue", "LowLimit", "HighLimit")
OTHER_KEYS = ("ParameterName", "AccessType", "VendorName", "ProductName", "OrderCode", "StorageLocation")
TEXT_TYPES = (0x09, 0x0A, 0x0B, 0x0F)
"""Data types whose values are text or bytes: visible, octet and Unicode string, domain."""
_SECTION = {name.lower(): name for name in (*SECTION_NAMES, "DeviceCommissioning")} | {
    "devicecommissioning": "DeviceComissioning"
}
_KEY = {name.lower(): name for name in (*NUMBER_KEYS, *VALUE_KEYS, *OTHER_KEYS)}
_OCTAL = re.compile(r"([+-]?)0([0-7]+)")
_NAMES = re.compile(r"[0-9A-F]{4}name", re.IGNORECASE)
"""Sections with the names of a compact array's members."""
_END_OF_FILE = "\x1a\x00"


def decoded(content: bytes) -> str:
    """Decode the content of an EDS file, which is UTF-8, UTF-16 with a byte order mark, or Windows-1252."""
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return content.decode("utf-16", errors="replace")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("cp1252", errors="replace")


def as_the_library_spells(text: str) -> str:
    """Return an EDS file's text with sections, keys and numbers in the spelling that `canopen` reads.

    The number of lines does not change.
    """
    lines = re.split(r"\r\n|\r|\n", text.rstrip(_END_OF_FILE))
    types = _data_types(lines)
    section, result = "", list[str]()
    for line in lines:
        head = re.match(r"(\s*\[)([^\]]*)(\].*)", line, re.DOTALL)
        section = head[2].strip() if head else section
        if _NAMES.fullmatch(section):  # the library reads only lists without gaps; handcart needs none
            result.append("")
        elif head:
            result.append(f"{head[1]}{_section(section)}{head[3]}")
        else:
            result.append(_entry(line, types.get(section.lower())))
    return "\n".join(result)


def number(text: str) -> int:
    """Parse an integer of an EDS file, which may be decimal, hexadecimal or octal (CiA 306); raise ValueError
    for other texts.
    """
    if not text.isascii() or "_" in text:  # int() reads other scripts' digits, and 1_0
        raise ValueError(f"{text!r} is no number")
    octal = _OCTAL.fullmatch(text.strip())
    return int(f"{octal[1]}0o{octal[2]}", 0) if octal else int(text, 0)


def _section(name: str) -> str:
    member = re.fullmatch(r"([0-9A-Fa-f]{4})sub([0-9A-Fa-f]+)", name, re.IGNORECASE)
    if member:
        return f"{member[1]}sub{member[2]}"
    return _SECTION.get(name.lower(), name)


def _entry(line: str, data_type: int | None) -> str:
    """Return a line KEY=VALUE in the library's spelling; an empty one where the value is empty."""
    if line.lstrip().startswith((";", "#")) or "=" not in line:
        return line
    before, _, value = line.partition("=")
    key = _KEY.get(before.strip().lower())
    if key is None:
        return line
    bare, comment = _split_comment(value)
    if key in NUMBER_KEYS and not bare:
        return ""
    if key in NUMBER_KEYS or (key in VALUE_KEYS and data_type not in TEXT_TYPES):
        bare = _rewritten(bare, always=key in NUMBER_KEYS)
    start = before[: len(before) - len(before.lstrip())]
    blank = value[: len(value) - len(value.lstrip())]
    return f"{start}{key}={blank}{bare}{comment}"


def _split_comment(value: str) -> tuple[str, str]:
    comment = re.search(r"(?:^|\s);", value)
    at = comment.start() if comment else len(value)
    return value[:at].strip(), value[at:]


def _rewritten(text: str, always: bool) -> str:
    """Return a number in decimal if it is octal, or `always`; other text as it is."""
    try:
        value = number(text)
    except ValueError:
        return text
    return str(value) if always or _OCTAL.fullmatch(text) else text


def _data_types(lines: list[str]) -> dict[str, int]:
    """Return the data type of each object, by its section in lower case."""
    section, types = "", dict[str, int]()
    for line in lines:
        if head := re.match(r"\s*\[([^\]]*)\]", line):
            section = head[1].strip().lower()
        elif entry := re.match(r"\s*datatype\s*=\s*(\w+)", line, re.IGNORECASE):
            try:
                types[section] = number(entry[1])
            except ValueError:  # the check of the file reports it with its line
                continue
    return types
