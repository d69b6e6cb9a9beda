"""Names of users as words of YAML that is written as text."""

from __future__ import annotations

import json
import re

from .scalars import UnclearScalar, resolve_plain

_PLAIN = re.compile(r"[A-Za-z0-9_./][A-Za-z0-9_./-]*( [A-Za-z0-9_./-]+)*")
_NOT_PRINTABLE = re.compile("[\x7f-\x9f\u2028\u2029\ufeff]")  # in YAML; JSON keeps them as they are


def yaml_word(text: str) -> str:
    """Return a text as one word of YAML: unquoted if every reader takes it for this text, otherwise in double
    quotes.
    """
    if _PLAIN.fullmatch(text) and _is_read_as_text(text):
        return text
    return _NOT_PRINTABLE.sub(lambda found: f"\\u{ord(found[0]):04x}", json.dumps(text, ensure_ascii=False))


def _is_read_as_text(word: str) -> bool:
    """Return whether an unquoted word is read as text by every reader, and not as a number, truth or date."""
    try:
        return resolve_plain(word) == word
    except UnclearScalar:
        return False
