"""pydantic's errors as findings: at their line and column, in the words of files."""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any, get_args

from pydantic import TypeAdapter, ValidationError
from pydantic_core.core_schema import ErrorType

from handcart.files.errors import Finding
from handcart.files.models.schema_walk import SchemaPlace, SchemaWalk
from handcart.files.models.schema_words import described, names_of, shown
from handcart.files.suggest import nearest, suggest
from handcart.files.yaml.yaml_document import Document
from handcart.files.yaml.yaml_node import KeyPath

# The value has not even the kind that this member of a union takes.
_OTHER_KIND = frozenset(
    {"string_type", "int_type", "int_from_float", "float_type", "bool_type", "none_required", "model_type"}
    | {"list_type", "tuple_type", "set_type", "frozen_set_type", "dict_type", "model_attributes_type"}
)
_PYDANTICS_OWN = frozenset(get_args(ErrorType))
_BOUNDS = ("ge", "gt", "le", "lt", "multiple_of", "min_length", "max_length", "pattern")


def findings_of(
    error: ValidationError, adapter: TypeAdapter[Any], document: Document, at: KeyPath = ()
) -> list[Finding]:
    """Return pydantic's errors in a part of a file as findings.

    Args:
        error: error with all problems of the part.
        adapter: type that the part was validated by.
        document: the file, for the places of the findings.
        at: key path of the part in the file.
    """
    walk = SchemaWalk(adapter.core_schema)
    raw = [item for item in error.errors(include_url=False) if not _counts_only_valid_items(item)]
    placed = [(walk.place(item["loc"]), item) for item in raw]
    return [_Wording(walk, document, at).finding(place, item) for place, item in _meant(placed)]


def _counts_only_valid_items(error: Any) -> bool:
    """Return whether a value is too short only without its invalid items, each of which has its own error."""
    value = error["input"]
    is_short = error["type"] == "too_short" and isinstance(value, list | dict)
    return is_short and len(value) >= error["ctx"]["min_length"]


_Placed = tuple[SchemaPlace, Any]


def _meant(errors: list[_Placed], depth: int = 0) -> Iterable[_Placed]:
    """Yield the errors that belong to the union members that the value was most likely meant to be.

    Args:
        errors: errors of one value.
        depth: number of the unions around it whose members are decided.
    """
    tried: dict[KeyPath, dict[str, list[_Placed]]] = {}
    for placed in errors:
        for path, label in placed[0].unions[depth : depth + 1]:
            tried.setdefault(path, {}).setdefault(label, []).append(placed)
    yield from (placed for placed in errors if len(placed[0].unions) <= depth)
    for path, members in tried.items():
        within = [found for found in members.values() if not _other_kind(path, found)]
        near = [list(_meant(found, depth + 1)) for found in within]
        if near:
            yield from min(near, key=len)
        else:
            yield _none_of(path, [found[0] for found in members.values()])


def _other_kind(path: KeyPath, errors: list[_Placed]) -> bool:
    return any(place.path == path and _is_other_kind(item) for place, item in errors)


def _is_other_kind(error: Any) -> bool:
    """Return whether an error means another kind of value, such as a list instead of one of several words."""
    structured = error["type"] in ("literal_error", "enum") and isinstance(error["input"], dict | list)
    return error["type"] in _OTHER_KIND or structured


def _none_of(path: KeyPath, errors: list[_Placed]) -> _Placed:
    choices = [place.schema for place, _ in errors]
    return SchemaPlace(path, {"type": "union", "choices": choices}, errors[0][0].parent), errors[0][1]


class _Wording:
    """Converter of pydantic's errors into findings in words."""

    def __init__(self, walk: SchemaWalk, document: Document, at: KeyPath) -> None:
        self._walk = walk
        self._document = document
        self._at = at

    def finding(self, place: SchemaPlace, error: Any) -> Finding:
        path = (*self._at, *place.path)
        match error["type"]:
            case "missing":
                if misspelled := self._misspelled(place):
                    return misspelled
                return self._document.finding(path[:-1], self._missing(place))
            case "extra_forbidden":
                return self._document.finding(path, self._unknown(place), at_key=True)
            case "union_tag_not_found" | "union_tag_invalid":
                return self._kind(place, path, error["input"])
            case "value_error" | "assertion_error":
                words = f"{_name(path)}: {error['ctx']['error']}"
                return self._document.finding(path, words, at_key=place.key)
        return self._document.finding(path, self._unfit(place, path, error), at_key=place.key)

    def _missing(self, place: SchemaPlace) -> str:
        missing = place.path[-1]
        if isinstance(missing, int):
            allowed = described(self._walk, place.parent)
            return f"{_name(place.path[:-1])} is too short; allowed: {allowed}"
        one_of = "one of " if names_of(place.schema) else ""
        needed = one_of + described(self._walk, place.schema, missing)
        return f"the key {missing!r} is missing; needed: {needed or 'a value'}"

    def _misspelled(self, place: SchemaPlace) -> Finding | None:
        """Return the finding on an unknown key that is spelled like the missing one; None without one."""
        above = (*self._at, *place.path[:-1])
        node, there = self._document.root.deepest(above)
        fields = self._walk.fields(place.parent)
        if not there or not isinstance(node.content, dict):
            return None
        for key in node.content:
            if key not in fields and nearest(key, fields) == place.path[-1]:
                unknown = replace(place, path=(*place.path[:-1], key))
                return self._document.finding((*above, key), self._unknown(unknown), at_key=True)
        return None

    def _unknown(self, place: SchemaPlace) -> str:
        fields = self._walk.fields(place.parent)
        if place.path[-1] in fields:
            return f"the key {place.path[-1]!r} is another name of one that is given; allowed: one of them"
        return f"unknown key {place.path[-1]!r}{suggest(str(place.path[-1]), fields)}"

    def _kind(self, place: SchemaPlace, path: KeyPath, value: Any) -> Finding:
        key, kinds = place.schema["discriminator"], [str(kind) for kind in place.schema["choices"]]
        if not isinstance(key, str) or not isinstance(value, dict):
            return self._document.finding(path, f"{_name(path)} has no known kind{suggest('', kinds)}")
        if key not in value:
            return self._document.finding(path, f"the key {key!r} is missing{suggest('', kinds)}")
        unknown = f"{key} is {shown(value[key])}{suggest(str(value[key]), kinds)}"
        return self._document.finding((*path, key), unknown)

    def _unfit(self, place: SchemaPlace, path: KeyPath, error: Any) -> str:
        value, words = error["input"], names_of(place.schema)
        allowed = described(self._walk, place.schema, _key(path))
        if error["type"] not in _PYDANTICS_OWN:
            return f"{_name(path)}: {error['msg']}"
        if not allowed or not _says_bound(allowed, error.get("ctx", {})):
            wanted = error["msg"].removeprefix("Input should be ")
            return f"{_name(path)} is {shown(value)}; allowed: {wanted[:1].lower()}{wanted[1:]}"
        if place.key:
            return f"the key {path[-1]!r} does not fit; allowed: {allowed}"
        near = nearest(value, words) if isinstance(value, str) else None
        hint = f"did you mean {near!r}? " if near is not None else ""
        if allowed.startswith("text") and isinstance(value, int | float):
            allowed = allowed.replace("text", "text in quotes", 1)
        return f"{_name(path)} is {shown(value)}; {hint}allowed: {allowed}"


def _says_bound(allowed: str, context: Mapping[str, Any]) -> bool:
    """Return whether a description names the broken bound; one set around a validator is not named."""
    broken = (context[bound] for bound in _BOUNDS if bound in context)
    return all((f"{b:.12g}" if isinstance(b, int | float) else str(b)) in allowed for b in broken)


def _key(path: KeyPath) -> str:
    """Return the innermost key of a path: the one that names the unit of a list's items."""
    return next((step for step in reversed(path) if isinstance(step, str)), "")


def _name(path: KeyPath) -> str:
    """Return the name of the value at `path` for messages: `width_mm`, `corner_m[1]`, `item 2`."""
    indices = ""
    for step in reversed(path):
        if isinstance(step, str):
            return f"{step}{indices}"
        indices = f"[{step}]{indices}"
    return f"item {indices}" if indices else "the file"
