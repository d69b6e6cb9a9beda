"""Reading the file in which a maker describes a CANopen device (EDS, DCF; CiA 306)."""

from __future__ import annotations

import configparser
import re
from collections.abc import Iterator, Mapping
from io import StringIO
from pathlib import Path
from typing import NamedTuple

from canopen.objectdictionary import ObjectDictionary, ODVariable, datatypes
from canopen.objectdictionary.eds import import_eds

from handcart.files.errors import FileError, Finding
from handcart.files.regular_file import read_regular_file

from .eds_text import as_the_library_spells, decoded

MAX_BYTES = 4 << 20
_OBJECT = re.compile(r"[0-9A-Fa-f]{4}")
_MEMBER = re.compile(r"([0-9A-Fa-f]{4})[Ss]ub([0-9A-Fa-f]+)")
_VARIABLES = (2, 7)  # object types that have a data type of their own: DOMAIN, VAR
_ALLOWED = "a number such as 10, 0x0A or 012 (octal)"
SIGNED_BITS = {
    datatypes.INTEGER8: 8,
    datatypes.INTEGER16: 16,
    datatypes.INTEGER32: 32,
    datatypes.INTEGER64: 64,
}
_NUMBERS = {
    "DeviceInfo": ("VendorNumber", "ProductNumber", "RevisionNumber", "NrOfRXPDO", "NrOfTXPDO"),
    "Comments": ("Lines",),
    "DeviceComissioning": ("NodeID", "Baudrate"),
}
_OF_OBJECTS = ("ObjectType", "DataType", "PDOMapping", "SubNumber", "NrOfEntries")


class _Entry(NamedTuple):
    value: str
    line: int
    column: int


class _Section(NamedTuple):
    name: str
    line: int
    entries: dict[str, _Entry]


def read_eds(path: Path, node: int) -> ObjectDictionary:
    """Read a maker's EDS or DCF for the node ID `node`, with the library `canopen`.

    Spellings that CiA 306 allows and the library does not are accepted (`eds_text`). Default values that
    are not numbers are ignored, as in the library.

    Raises:
        FileError: the file is missing, or the library cannot read it; the error lists each wrong place with
            the content that is allowed there.
    """
    name = str(path)
    text = as_the_library_spells(decoded(read_regular_file(path, MAX_BYTES)))
    sections = _sections(text)
    findings = list(_findings(name, sections))
    if findings:
        raise FileError(findings)
    try:
        dictionary: ObjectDictionary = import_eds(StringIO(text), node)
    except configparser.Error as error:
        raise FileError(_syntax(name, error)) from None
    except (ValueError, KeyError, AttributeError, TypeError) as error:
        wrong = f"the library can't read it: {type(error).__name__}: {error}"
        raise FileError([Finding(name, 1, 1, f"{wrong}; allowed: an EDS or DCF by CiA 306")]) from None
    if not len(dictionary):
        raise FileError([Finding(name, 1, 1, "it describes no object; allowed: sections such as [6040]")])
    _sign_defaults(dictionary)
    return dictionary


def _sign_defaults(dictionary: ObjectDictionary) -> None:
    """Give defaults of signed objects their sign: the library reads 0xFB of an INTEGER8 as 251."""
    for entry in dictionary.values():
        for variable in (entry,) if isinstance(entry, ODVariable) else entry.values():
            bits = SIGNED_BITS.get(variable.data_type or 0)
            if bits and isinstance(variable.default, int) and variable.default >> (bits - 1) == 1:
                variable.default -= 1 << bits


def missing_objects(dictionary: ObjectDictionary, needed: Mapping[int, str], name: str) -> list[Finding]:
    """Return a finding that names the needed objects that an EDS file lacks; an empty list if it has all.

    Args:
        dictionary: objects of the file.
        needed: description of each needed object, by index.
        name: name of the file in the finding.
    """
    lacking = [f"{index:04X}h ({what})" for index, what in needed.items() if index not in dictionary]
    if not lacking:
        return []
    return [Finding(name, 1, 1, f"it describes no {', no '.join(lacking)}; needed: all of them")]


def _sections(text: str) -> list[_Section]:
    """Return all sections that can be read, whatever is wrong with other lines."""
    found: list[_Section] = []
    for number, line in enumerate(text.splitlines(), 1):
        head = re.match(r"\s*\[([^\]]*)\]", line)
        if head:
            found.append(_Section(head.group(1), number, {}))
        elif found and not line.lstrip().startswith((";", "#")) and "=" in line:
            key, _, value = line.partition("=")
            value = re.split(r"(?:^|\s);", value, maxsplit=1)[0]
            column = line.index("=") + 2 + len(value) - len(value.lstrip())
            found[-1].entries[key.strip()] = _Entry(value.strip(), number, column)
    return found


def _findings(name: str, sections: list[_Section]) -> Iterator[Finding]:
    """Find entries that the library would reject without naming the place."""
    if all(section_.name != "DeviceInfo" for section_ in sections):
        yield Finding(name, 1, 1, "the section [DeviceInfo] is missing; needed by CiA 306")
    objects = {int(section_.name, 16): section_ for section_ in sections if _OBJECT.fullmatch(section_.name)}
    for section in sections:
        member = _MEMBER.fullmatch(section.name)
        is_object = bool(_OBJECT.fullmatch(section.name) or member)
        for key in _OF_OBJECTS if is_object else _NUMBERS.get(section.name, ()):
            entry = section.entries.get(key)
            if entry is not None and not _is_number(entry.value):
                wrong = f"{key} in [{section.name}] is {entry.value!r}; allowed: {_ALLOWED}"
                yield Finding(name, entry.line, entry.column, wrong)
        if is_object:
            yield from _lacking(name, section, bool(member))
        if member and int(member.group(1), 16) not in objects:
            wrong = f"[{section.name}] belongs to no object; needed: a section [{member.group(1)}]"
            yield Finding(name, section.line, 1, wrong)


def _lacking(name: str, section: _Section, is_member: bool) -> Iterator[Finding]:
    kind = section.entries.get("ObjectType")
    is_variable = is_member or kind is None or (_is_number(kind.value) and int(kind.value, 0) in _VARIABLES)
    needed = ("ParameterName", "DataType", "AccessType") if is_variable else ("ParameterName",)
    for key in needed:
        if key not in section.entries:
            yield Finding(name, section.line, 1, f"[{section.name}] has no {key}; needed: {key}=...")


def _is_number(text: str) -> bool:
    try:
        int(text, 0)
    except ValueError:
        return False
    return True


def _syntax(name: str, error: configparser.Error) -> list[Finding]:
    """Return findings for a syntax error of the library's line reader."""
    match error:
        case configparser.MissingSectionHeaderError(lineno=line):
            return [Finding(name, line, 1, "is outside any section; allowed: [SECTION] before it")]
        case configparser.ParsingError(errors=errors):
            allowed = "allowed: KEY=VALUE, [SECTION], a comment behind ;"
            return [
                Finding(name, line, 1, f"is not a line of an EDS: {text}; {allowed}") for line, text in errors
            ]
        case configparser.DuplicateSectionError(section=section, lineno=line):
            return [Finding(name, line or 1, 1, f"[{section}] is there twice; allowed: once")]
        case configparser.DuplicateOptionError(section=section, option=option, lineno=line):
            return [Finding(name, line or 1, 1, f"{option} is there twice in [{section}]; allowed: once")]
        case _:
            return [Finding(name, 1, 1, f"{error.message}; allowed: an EDS or DCF by CiA 306")]
