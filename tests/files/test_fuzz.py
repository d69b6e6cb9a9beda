"""Whatever the bytes: a document or a FileError, never another error (rows T3, T4, T14)."""

import json

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from files.errors import FileError
from files.yaml_document import Document, parse_document

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


@bounded
@given(st.lists(st.sampled_from(SYNTAX + WORDS + ESCAPES), max_size=60))
def test_any_scraps_of_yaml(scraps: list[str]) -> None:
    check("".join(scraps).encode())


KEYS = st.text(st.characters(codec="utf-8", categories=["L", "N", "P", "S", "Zs"]), min_size=1, max_size=8)
DATA = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(10**18), 10**18)
    | KEYS
    | st.floats(allow_nan=False, allow_infinity=False),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(KEYS, inner, max_size=4),
    max_leaves=20,
)


@bounded
@given(st.dictionaries(KEYS, DATA, min_size=1, max_size=4))
def test_json_is_read_as_json(data: dict[str, object]) -> None:
    """JSON is YAML: what it says is what is read, numbers to the last bit."""
    assert parse_document(json.dumps(data, ensure_ascii=False).encode(), "f.yaml").data == data
