"""S-expressions with their lines, as PDDL is written in."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

from handcart.files.errors import FileError, Finding
from handcart.files.regular_file import decode_text, read_regular_file

MAX_PDDL_BYTES = 1 << 20
MAX_TOKENS = 100_000
MAX_NESTING = 60
_TOKEN = re.compile(r";[^\n]*|[()]|[^\s();]+")


@dataclass
class Expression:
    """S-expression, as in PDDL, which is a word or a list of expressions, with its place in the file."""

    line: int
    column: int
    word: str = ""
    """The word in lower case; "" for a list."""
    parts: list[Expression] = field(default_factory=list)

    @property
    def head(self) -> str:
        """First word of a list; "" for an empty list, or for a list that begins with another list."""
        return self.parts[0].word if self.parts else ""

    def __str__(self) -> str:
        return self.word or f"({' '.join(map(str, self.parts))})"


def read_expressions(path: Path | str) -> list[Expression]:
    """Return the S-expressions of a file; raise `FileError` if brackets do not match."""
    text = decode_text(read_regular_file(path, MAX_PDDL_BYTES), str(path), longest_line=None)
    top = Expression(0, 0)
    opened, line, begin, last = [top], 1, 0, 0
    for count, token in enumerate(_TOKEN.finditer(text)):
        line += text.count("\n", last, token.start())
        last = token.start()
        begin = text.rfind("\n", 0, last) + 1
        here = line, last - begin + 1
        if count > MAX_TOKENS or len(opened) > MAX_NESTING:
            raise _refused(path, here, "the file is too long, or nested too deeply; allowed: a smaller one")
        if token[0].startswith(";"):
            continue
        if token[0] == ")":
            opened.pop()
            if not opened:
                raise _refused(path, here, "a bracket closes that none opened; allowed: matching brackets")
            continue
        expression = Expression(*here, "" if token[0] == "(" else token[0].lower())
        opened[-1].parts.append(expression)
        if token[0] == "(":
            opened.append(expression)
    if len(opened) > 1:
        here = opened[-1].line, opened[-1].column
        raise _refused(path, here, "a bracket is not closed; allowed: matching brackets")
    return top.parts


def _refused(path: Path | str, here: tuple[int, int], wrong: str) -> FileError:
    return FileError([Finding(str(path), *here, wrong)])
