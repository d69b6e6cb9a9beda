"""Whatever the bytes: a document or a FileError, never another error (rows T3, T4, T14)."""

import json
from pathlib import Path
from unittest.mock import patch

import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from handcart.files.errors import FileError
from handcart.files.printable import composed
from handcart.files.yaml.yaml_document import Document, fast_events, parse_document

ROOT = Path(__file__).resolve().parents[2]
SHIPPED = [
    path.read_text(encoding="utf-8")
    for room in ("tasks", "backends/robots")
    for path in sorted((ROOT / room).rglob("*.yaml"))
    if path.stat().st_size < 3000
]

SYNTAX = [
    "[",
    "]",
    "{",
    "}",
    "- ",
    "? ",
    ": ",
    "&a ",
    "*a",
    "!t ",
    "!!",
    "|",
    ">-",
    "|9",
    "'",
    '"',
    "\\",
    "#",
]
WORDS = [
    "%YAML 1.2",
    "%TAG ! x",
    "---",
    "...",
    "\n",
    "\n  ",
    "\t",
    " ",
    ",",
    "<<",
    "a",
    "1e-3",
    "NO",
    ".inf",
    "é",
]
ESCAPES = ['"\\x', '"\\U', "\\ud800", "0", "f", "\r", "\u2028", "\u0085", "\ufeff", "@", "`", "%", "\0"]

bounded = settings(
    max_examples=300,
    deadline=None,
    database=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.too_slow],
)


def check(content: bytes) -> None:
    try:
        document = parse_document(content, "f.yaml")
    except FileError as error:
        assert error.findings
        assert all(finding.line >= 1 and finding.column >= 1 for finding in error.findings)
        assert str(error).replace("\n", "").isprintable()
    else:
        assert isinstance(document, Document)
        json.dumps(document.data, allow_nan=False).encode()


@bounded
@given(st.binary(max_size=200))
def test_any_bytes(content: bytes) -> None:
    check(content)


@bounded
@given(st.text(max_size=200))
def test_any_text(text: str) -> None:
    check(text.encode(errors="surrogatepass"))


@pytest.mark.slow
@bounded
@given(st.lists(st.sampled_from(SYNTAX + WORDS + ESCAPES), max_size=60))
def test_any_scraps_of_yaml(scraps: list[str]) -> None:
    check("".join(scraps).encode())


KEYS = st.text(
    st.characters(codec="utf-8", categories=["L", "N", "P", "S", "Zs"]), min_size=1, max_size=8
).map(composed)
DATA = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(10**18), 10**18)
    | KEYS
    | st.floats(allow_nan=False, allow_infinity=False),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(KEYS, inner, max_size=4),
    max_leaves=20,
)


@pytest.mark.slow
@bounded
@given(st.dictionaries(KEYS, DATA, min_size=1, max_size=4))
def test_json_is_read_as_json(data: dict[str, object]) -> None:
    """JSON is YAML: its values are read unchanged, numbers to the last bit, text in composed form."""
    assert parse_document(json.dumps(data, ensure_ascii=False).encode(), "f.yaml").data == data


def said(content: bytes) -> object:
    try:
        return parse_document(content, "f.yaml").data
    except FileError:
        return FileError


@pytest.mark.slow
@settings(bounded, max_examples=100)
@given(
    st.sampled_from(SHIPPED),
    st.lists(st.tuples(st.integers(0), st.integers(0, 4), st.sampled_from(SYNTAX + WORDS)), max_size=3),
)
def test_both_parsers_read_the_same(text: str, edits: list[tuple[int, int, str]]) -> None:
    """The fast parser replaces the slow one wherever both agree."""
    for at, dropped, put in edits:
        at %= len(text) + 1
        text = text[:at] + put + text[at + dropped :]
    with patch("handcart.files.yaml.yaml_document.fast_events", return_value=None):
        exact = said(text.encode())
    assert said(text.encode()) == exact


@pytest.mark.skipif(not hasattr(yaml, "CLoader"), reason="PyYAML was built without libyaml here")
def test_libyaml_reads_what_is_plain() -> None:
    """Every number of the task files would take 30 times as long otherwise."""
    assert fast_events("a: [1, 2]  # é\n") is not None
    assert all(fast_events(f"a: {sign}\n") is None for sign in "\t\r\x85\u2028\ufeff&*!%?")
