"""Syntax errors of a YAML parser, as findings in plain words."""

from typing import Any

from handcart.files.errors import FileError, Finding

_EXPLANATIONS = (
    ("found character '\\t'", "a tab begins this line or word; allowed: spaces"),
    ("mapping values are not allowed", "a ':' where no key can stand; allowed: quotes if it is text"),
    (
        "sequence entries are not allowed",
        "a '-' where no list can stand; allowed: a list on lines of its own",
    ),
    ("could not find expected ':'", "a line without ':'; allowed: 'key: value' or '- item'"),
    ("expected <block end>", "the indentation fits none of the lines above; allowed: that of one of them"),
    ("found unexpected end of stream", "quotes are opened and never closed; allowed: closed quotes"),
    ("<stream end>", "a bracket is opened and never closed; allowed: closed brackets"),
    ("expected ',' or", "a bracket is not closed; allowed: a comma or the closing bracket"),
    ("duplicate tag handle", "a tag is declared; allowed: values without one"),
    ("undefined tag handle", "a tag; allowed: values without one"),
    (
        "found unknown escape character",
        "an unknown escape in double quotes; allowed: single quotes for plain text",
    ),
)
_MARKED_AT_THEIR_BEGINNING = ("could not find expected ':'", "found unexpected end of stream")


def syntax_error(file: str, error: Exception, latest_mark: Any) -> FileError:
    """Return a `FileError` that describes the error of a YAML parser in plain words.

    Args:
        file: name of the file in messages.
        error: exception of the parser; its own mark is the place of the finding.
        latest_mark: mark of the latest event, for an error without a mark.
    """
    problem = getattr(error, "problem", None)
    if problem is None:
        return _at(file, latest_mark, "an escape or a version that is out of range; allowed: YAML 1.2")
    mark = error.problem_mark  # type: ignore[attr-defined]
    context, context_mark = getattr(error, "context", None), getattr(error, "context_mark", None)
    if context_mark is not None and any(sign in problem for sign in _MARKED_AT_THEIR_BEGINNING):
        mark = context_mark
    words = next((said for sign, said in _EXPLANATIONS if sign in problem), None)
    if words is None:
        words = f"invalid YAML ({' '.join(filter(None, (context, problem)))}); allowed: YAML 1.2"
    return _at(file, mark, words)


def _at(file: str, mark: Any, message: str) -> FileError:
    line, column = (mark.line + 1, mark.column + 1) if mark is not None else (1, 1)
    return FileError([Finding(file, line, column, message)])
