"""An XML file as a tree of elements with their lines, within the limits of `xml_file`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

from handcart.files.regular_file import read_regular_file
from handcart.files.xml_file import checked_xml

MAX_XML_BYTES = 1 << 21


@dataclass
class XmlElement:
    """Element of an XML file, with its line and column in the file."""

    tag: str
    attributes: Mapping[str, str]
    line: int
    column: int
    children: list[XmlElement] = field(default_factory=list)


def read_xml_tree(path: Path | str) -> XmlElement:
    """Return the root element of an XML file.

    Raises:
        FileError: the file cannot be read, is too large, or is not well-formed XML.
    """
    content = read_regular_file(path, MAX_XML_BYTES)
    return parse_xml_tree(content, str(path))


def parse_xml_tree(content: bytes, file: str) -> XmlElement:
    """Return the root element of an XML file, given its content and, for messages, its name.

    Raises:
        FileError: the content is not well-formed, or has entities or too many elements.
    """
    text = checked_xml(content, file)  # no entities, nothing deep, nothing huge
    parser, top = expat.ParserCreate(), XmlElement("", {}, 0, 0)
    opened = [top]

    def start(tag: str, attributes: dict[str, str]) -> None:
        line, column = parser.CurrentLineNumber, parser.CurrentColumnNumber + 1
        element = XmlElement(tag, attributes, line, column)
        opened[-1].children.append(element)
        opened.append(element)

    def end(_tag: str) -> None:
        opened.pop()

    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.Parse(text, True)
    return top.children[0]
