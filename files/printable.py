"""Text from files and wires made safe to show."""

import unicodedata

# Control, format (bidirectional overrides), surrogate, private; line and paragraph separators.
_HIDDEN = frozenset({"Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp"})


def printable(text: str) -> str:
    r"""Return `text` with every character that a terminal would act on written as an escape."""
    if text.isascii() and text.isprintable():
        return text
    return "".join(_escaped(c) if unicodedata.category(c) in _HIDDEN else c for c in text)


def _escaped(character: str) -> str:
    code = ord(character)
    if code < 0x100:
        return f"\\x{code:02x}"
    return f"\\u{code:04x}" if code < 0x10000 else f"\\U{code:08x}"


def clipped(text: str, longest: int = 60) -> str:
    """Return `text` cut to at most `longest` characters, with dots in place of what was cut."""
    return text if len(text) <= longest else f"{text[: longest - 3]}..."


def composed(text: str) -> str:
    """Return the text in Unicode's composed form (NFC), in which names are compared.

    A name typed on another system may have its accents as separate characters.
    """
    return text if text.isascii() else unicodedata.normalize("NFC", text)


def counted(count: int, noun: str) -> str:
    """Return a number with its noun: "1 warning", "2 warnings"."""
    return f"{count} {noun}{'' if count == 1 else 's'}"
