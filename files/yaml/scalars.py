"""Values of unquoted words in a YAML file: the core schema of YAML 1.2, without ambiguous words.

Source: YAML 1.2.2, section 10.3.2; https://yaml.org/type/ for the meaning of the rest in version 1.1.
"""

import math
import re

Scalar = None | bool | int | float | str

_CONSTANTS: dict[str, Scalar] = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL")),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
}
_INTEGER = re.compile(r"[-+]?(0|[1-9][0-9]*)", re.ASCII)
_HEXADECIMAL = re.compile(r"0x[0-9a-fA-F]+")
_OCTAL = re.compile(r"0o[0-7]+")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
_NOT_FINITE = re.compile(r"[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)")
_LONGEST_NUMBER = 40

_SOME = "a number to some readers, text to others"
# `y` and `n` are missing: no reader in use takes them for booleans, and `y` is an axis.
_AMBIGUOUS = (
    (re.compile(r"(?i:yes|no|on|off)"), "true or false to some readers, text to others", "true, false"),
    (re.compile(r"[-+]?[0-9][0-9_]*(:[0-5]?[0-9])+(\.[0-9_]*)?"), "a number to base 60 to some readers", ""),
    (re.compile(r"[-+]?0[0-9_]+"), "an octal number to some readers, a decimal to others", "no leading 0"),
    (re.compile(r"[-+]?([0-9][0-9_]*(\.[0-9_]*)?|\.[0-9][0-9_]*)([eE][-+]?[0-9]+)?"), _SOME, "no _"),
    (re.compile(r"[-+]?(0b[01_]+|0x[0-9a-fA-F_]+|0o[0-7_]+)"), _SOME, ""),
    (re.compile(r"[0-9]{4}-[0-9]{1,2}-[0-9]{1,2}([Tt \t].*)?"), "a date to some readers, text to others", ""),
    (re.compile(r"<<|="), "a special key to some readers, text to others", ""),
)


class UnclearScalar(ValueError):
    """Error: an unquoted word or number in a YAML file has no clear meaning, such as `NaN`.

    The message says what is wrong and what is allowed.
    """


def resolve_plain(text: str) -> Scalar:
    """Return the value of the unquoted word `text`; anything but a constant or a number is text.

    Raises:
        UnclearScalar: readers of YAML disagree on the word, or a number is not finite or too long.
    """
    if text in _CONSTANTS:
        return _CONSTANTS[text]
    if text[0] not in "0123456789+-.yYnNoO<=_":
        return text
    number = _number(text)
    if number is not None:
        return number
    for pattern, trouble, instead in _AMBIGUOUS:
        if pattern.fullmatch(text):
            also = f", or {instead}" if instead else ""
            raise UnclearScalar(f"{text!r} is {trouble}; allowed: in quotes if it is text{also}")
    return text


def _number(text: str) -> int | float | None:
    if _NOT_FINITE.fullmatch(text):
        raise UnclearScalar(f"{text} is not a finite number; allowed: finite numbers")
    kinds = ((_INTEGER, 10), (_HEXADECIMAL, 16), (_OCTAL, 8))
    base = next((base for kind, base in kinds if kind.fullmatch(text)), None)
    # A leading 0 is octal to YAML 1.1 only where there is neither point nor exponent.
    is_float = base is None and _FLOAT.fullmatch(text) and re.search(r"[.eE]", text)
    if base is None and not is_float:
        return None
    if len(text) > _LONGEST_NUMBER:
        raise UnclearScalar(
            f"a number of {len(text)} characters; allowed: at most {_LONGEST_NUMBER}, or quotes if it is text"
        )
    if base is not None:
        return int(text, 0) if base != 10 else int(text)
    value = float(text)
    if not math.isfinite(value):
        raise UnclearScalar(f"{text} is too large for a number; allowed: finite numbers")
    return value
