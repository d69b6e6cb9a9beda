"""Reading an XML file (a URDF, an SRDF) within limits: no entities, nothing deep, nothing huge."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn
from xml.parsers import expat

from handcart.files.errors import FileError, Finding
from handcart.files.findings import Findings
from handcart.files.regular_file import BYTE_ORDER_MARK, decode_text, read_regular_file

MAX_BYTES = 1 << 21  # ten times the largest maker's URDF that we know
MAX_NODES = 50_000
MAX_DEPTH = 32


@dataclass(frozen=True)
class XmlTag:
    """Start tag of an XML element, with the tags of all elements that contain it."""

    name: str
    attributes: Mapping[str, str]
    parents: tuple[XmlTag, ...]
    """Parent elements, from the root down."""


Check = Callable[[XmlTag], Iterable[str]]
"""Function that yields the problems of an element, each as "problem; allowed values"."""


def read_xml_text(path: Path | str, check: Check | None = None, max_bytes: int = MAX_BYTES) -> str:
    """Return the text of an XML file in UTF-8, after checking that it is well-formed.

    Args:
        path: the file.
        check: called with each element; yields the element's problems. None: only the syntax is checked.
        max_bytes: larger files are not read.

    Raises:
        FileError: the file is missing, is not a regular file or is too large; its content is not UTF-8, not
            well-formed, nested too deeply, or has too many elements and attributes or a document type (which
            could define endless entities); or `check` yielded a problem. The error states line and column.
    """
    return checked_xml(read_regular_file(path, max_bytes), str(path), check)


def checked_xml(content: bytes, file: str, check: Check | None = None) -> str:
    """Return the content of an XML file as text, after checks of its syntax, number of elements and depth.

    Args:
        content: bytes of the file, which may begin with a byte order mark.
        file: name of the file in messages.
        check: called with each element; yields the element's problems. None: only the syntax is checked.

    Raises:
        FileError: with line and column; see `read_xml_text`.
    """
    # Robots exported by programs on Windows begin with one.
    text = decode_text(content.removeprefix(BYTE_ORDER_MARK), file, longest_line=None)
    _Walk(file, check or (lambda _: ())).through(text)
    return text


class _Walk:
    def __init__(self, file: str, check: Check) -> None:
        self._file = file
        self._check = check
        self._open: tuple[XmlTag, ...] = ()
        self._nodes = 0
        self._findings = Findings()
        self._parser = expat.ParserCreate()
        self._parser.StartElementHandler = self._start
        self._parser.EndElementHandler = self._end
        self._parser.StartDoctypeDeclHandler = self._doctype

    def through(self, text: str) -> None:
        try:
            self._parser.Parse(text, True)
        except expat.ExpatError as error:
            words = expat.errors.messages[error.code].removeprefix("not well-formed ").strip("()")
            wrong = f"the file is not well-formed: {words}; allowed: XML in UTF-8"
            raise FileError([Finding(self._file, error.lineno, error.offset + 1, wrong)]) from None
        self._findings.raise_all()

    def _start(self, name: str, attributes: dict[str, str]) -> None:
        self._nodes += 1 + len(attributes)
        if self._nodes > MAX_NODES:
            self._refuse(f"more than {MAX_NODES} elements and attributes; allowed: fewer")
        if len(self._open) >= MAX_DEPTH:
            self._refuse(f"elements nested deeper than {MAX_DEPTH}; allowed: flatter XML")
        tag = XmlTag(name, attributes, self._open)
        self._findings.add(*(self._finding(wrong) for wrong in self._check(tag)))
        self._open = (*self._open, tag)

    def _end(self, _name: str) -> None:
        self._open = self._open[:-1]

    def _doctype(self, *_: object) -> None:
        self._refuse("a document type (DOCTYPE); allowed: XML without one, and so without entities")

    def _finding(self, wrong: str) -> Finding:
        line, column = self._parser.CurrentLineNumber, self._parser.CurrentColumnNumber + 1
        return Finding(self._file, line, column, wrong)

    def _refuse(self, wrong: str) -> NoReturn:
        raise FileError([self._finding(wrong)])
