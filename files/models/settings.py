"""Values given on the command line, `--set KEY=VALUE`, read by the rules of the files."""

import re
from collections.abc import Iterable, Mapping

from handcart.files.errors import FileError, Finding
from handcart.files.findings import Findings
from handcart.files.printable import composed
from handcart.files.regular_file import decode_text
from handcart.files.suggest import suggest
from handcart.files.yaml.scalars import Scalar, UnclearScalar, resolve_plain
from handcart.files.yaml.yaml_document import Document, parse_document
from handcart.files.yaml.yaml_node import KeyPath, Node

_OTHER_BASE = re.compile(r"0[xX][0-9a-fA-F]+|0[oO][0-7]+")
SETTINGS_SECTION: KeyPath = ("parameters",)
"""Section of a task file with the keys that can be set."""


def split_setting(text: str) -> tuple[str, str]:
    """Return key and value of `KEY=VALUE`; raise `FileError` if the key or `=` is missing."""
    key, equals, value = text.partition("=")
    if not equals or not key.strip():
        raise FileError([Finding(f"--set {text}", 0, 0, "no value is given; allowed: KEY=VALUE")])
    return key.strip(), value.strip()


def split_settings(words: Iterable[str]) -> dict[str, str]:
    """Return the values by the keys of several `KEY=VALUE`.

    Raises:
        FileError: a key or `=` is missing, or a key has two values, of which one would silently win.
    """
    found: dict[str, str] = {}
    for text in words:
        key, value = split_setting(text)
        if found.setdefault(key, value) != value:
            wrong = f"{key!r} is also given as {found[key]!r}; allowed: one value"
            raise FileError([Finding(f"--set {key}={value}", 0, 0, wrong)])
    return found


def setting_value(key: str, text: str) -> Node:
    """Parse `text`, given for `key` on the command line, as a YAML value.

    An unquoted word becomes a constant, a number or text, as in a file; lists, mappings and quoted text are
    parsed as in a file, too. Later findings about the value are reported as `--set KEY=VALUE: ...`.

    Raises:
        FileError: the text is not valid YAML, or a word whose meaning is unclear.
    """
    name = f"--set {key}={text}"
    try:
        given = text.encode(errors="surrogateescape")
        is_flow = text[:1] in ("[", "{", "'", '"')
        content = (
            _without_lines(parse_document(given, name).root).content
            if is_flow
            else _resolve_word(composed(decode_text(given, name)))
        )
    except UnclearScalar as unclear:
        raise FileError([Finding(name, 0, 0, str(unclear))]) from None
    except FileError as error:
        raise FileError(Finding(name, 0, 0, found.message) for found in error.findings) from None
    return Node(content, name, 0, 0, 0, 0)


def _resolve_word(text: str) -> Scalar:
    """Return the value of an unquoted word; a number must be decimal, because 0x10 may be meant as text or as
    10.
    """
    if _OTHER_BASE.fullmatch(text):
        wrong = f"{text!r} is a number to base {16 if text[1] in 'xX' else 8}"
        raise UnclearScalar(f"{wrong}; allowed: {int(text, 0)}, or in quotes if it is text")
    return resolve_plain(text)


def _without_lines(node: Node) -> Node:
    content = node.content
    if isinstance(content, dict):
        content = {key: _without_lines(child) for key, child in content.items()}
    elif isinstance(content, list):
        content = [_without_lines(child) for child in content]
    return Node(content, node.file, 0, 0, 0, 0)


def with_settings(
    document: Document, settings: Mapping[str, str], section: KeyPath = SETTINGS_SECTION
) -> Document:
    """Return `document` with changed values of its `section`; only existing keys can be set.

    Args:
        document: document to change.
        settings: unparsed values by key.
        section: key path of the section.

    Raises:
        FileError: with every finding in any of the values.
    """
    findings = Findings()
    declared, there = document.root.deepest(section)
    known = declared.content if there and isinstance(declared.content, dict) else {}
    for key, text in settings.items():
        if key not in known:
            wrong = f"unknown parameter {key!r}{suggest(key, known)}"
            findings.add(Finding(f"--set {key}={text}", 0, 0, wrong))
            continue
        try:
            document = document.with_value((*section, key), setting_value(key, text))
        except FileError as error:
            findings.take(error)
    findings.raise_all()
    return document
