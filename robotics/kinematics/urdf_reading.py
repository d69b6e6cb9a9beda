"""Reading of URDFs whose elements know their position in the file."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache
from typing import Any, NamedTuple
from xml.etree import ElementTree
from xml.parsers import expat

_NOT_WELL_FORMED = "the URDF is not well-formed"


class UrdfFault(NamedTuple):
    """Fault in the text of a URDF, as a message with its line and column, which count from 1."""

    line: int
    column: int
    message: str
    """Message "problem; allowed values", with the name of the link or joint."""
    mild: bool = False
    """True if the URDF is usable nevertheless."""


class UrdfFaults(ValueError):
    """Error of a text that is not a valid URDF, with all faults found in it."""

    def __init__(self, faults: Iterable[UrdfFault]) -> None:
        self.faults = tuple(faults)
        super().__init__("; ".join(f"line {fault.line}: {fault.message}" for fault in self.faults))


class UrdfElement(ElementTree.Element):
    """An XML element with line and column of its tag in the text; both are 0 for an element made by a
    program.
    """

    line: int = 0
    column: int = 0

    def fault(self, message: str) -> UrdfFault:
        """Return a fault of the URDF at the line and column of this element, with a message for people."""
        return UrdfFault(self.line, self.column, message)


def read_urdf(text: str) -> UrdfElement:
    """Return the URDF's root element.

    Raises:
        UrdfFaults: the text is not well-formed XML, declares entities, or its root is not a `robot`.
    """
    robot = read_xml(text)
    if robot.tag != "robot":
        raise UrdfFaults([robot.fault(f"the URDF's root is <{robot.tag}>; allowed: <robot>")])
    return robot


@lru_cache(maxsize=8)
def known_urdf(text: str) -> UrdfElement:
    """Return the root element of a URDF; the same text gives the same object, so callers must not
    change it.
    """
    return read_urdf(text)


def read_xml(text: str) -> UrdfElement:
    """Return the root element of any XML; raises `UrdfFaults` where it is not well-formed or declares
    entities.
    """
    reader = _Reader()
    try:
        reader.parser.Parse(text, True)
    except expat.ExpatError as error:
        what = expat.ErrorString(error.code)
        fault = UrdfFault(error.lineno, error.offset + 1, f"{_NOT_WELL_FORMED}: {what}")
        raise UrdfFaults([fault]) from error
    except (ValueError, UnicodeEncodeError) as error:
        if isinstance(error, UrdfFaults):
            raise
        raise UrdfFaults([UrdfFault(1, 1, f"{_NOT_WELL_FORMED}: {error}")]) from error
    root: UrdfElement = reader.builder.close()  # type: ignore[assignment]
    return root


class _Reader:
    """Builder of a tree of elements that know their places."""

    def __init__(self) -> None:
        self.builder = ElementTree.TreeBuilder(element_factory=UrdfElement)
        self.parser = expat.ParserCreate()
        self.parser.buffer_text = True
        self.parser.StartElementHandler = self._start
        self.parser.EndElementHandler = self.builder.end
        self.parser.CharacterDataHandler = self.builder.data
        self.parser.EntityDeclHandler = self._entity

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        element: Any = self.builder.start(tag, attributes)
        element.line = self.parser.CurrentLineNumber
        element.column = self.parser.CurrentColumnNumber + 1

    def _entity(self, name: str, *_: object) -> None:
        line, column = self.parser.CurrentLineNumber, self.parser.CurrentColumnNumber + 1
        wrong = f"declares the entity {name[:40]!r}; allowed: XML without entities of its own"
        raise UrdfFaults([UrdfFault(line, column, wrong)])
