"""Translation of pydantic's location of an error to a place in the file and in the schema.

pydantic's locations hold more than keys and indices: the tried member of a union, the tag of a
discriminated one, `[key]`. The schema distinguishes them, and says what would have been allowed there.
Schemas as in pydantic_core.core_schema.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from handcart.files.yaml.yaml_node import KeyPath

Schema = Mapping[str, Any]
_WRAPPERS = frozenset(
    {"default", "nullable", "model", "definitions", "custom-error"}
    | {"function-after", "function-before", "function-wrap", "json-or-python", "lax-or-strict", "chain"}
)
_ANY: Schema = {"type": "any"}


@dataclass(frozen=True)
class SchemaPlace:
    """Location of an error: the `path` in the file, and the schema of the value that belongs there.

    `parent` is the schema of the list or mapping around that value. A union without a tag allows several
    types, and pydantic reports errors for each. `unions` holds the path of each such union above the value,
    with pydantic's label of the type. `key` is true if the error is about the key, not its value.
    """

    path: KeyPath
    schema: Schema
    parent: Schema
    unions: tuple[tuple[KeyPath, str], ...] = ()
    key: bool = False


class SchemaWalk:
    """Look-up, in the schema of one pydantic model, of the values that a place in a file may have."""

    def __init__(self, schema: Schema) -> None:
        self._root = schema
        self._definitions: dict[str, Schema] = {}
        if schema["type"] == "definitions":
            self._definitions = {part["ref"]: part for part in schema["definitions"]}

    def place(self, location: tuple[str | int, ...]) -> SchemaPlace:
        """Return the place in the file, and the schema that belongs there, for the location of an error.

        Args:
            location: keys and indexes down to the value, as in pydantic's errors (`loc`).
        """
        place = SchemaPlace((), self.bare(self._root), _ANY)
        if location and location[-1] == "[key]":
            mapping = self.place(location[:-2])
            keys = self.bare(_schema(mapping.schema, "keys_schema"))
            return SchemaPlace((*mapping.path, location[-2]), keys, mapping.schema, mapping.unions, key=True)
        for item in location:
            place = self._step(place, item)
        return place

    def bare(self, schema: Schema) -> Schema:
        """Return the inner schema of a value: references resolved, defaults and custom validators removed."""
        while True:
            if schema["type"] == "definition-ref":
                schema = self._definitions.get(schema["schema_ref"], _ANY)
            elif schema["type"] in _WRAPPERS:
                schema = _inside(schema)
            else:
                return schema

    def fields(self, schema: Schema) -> dict[str, Schema]:
        """Return the schema of each key, as spelled in files, of a model; empty for other schemas."""
        if schema["type"] not in ("model-fields", "typed-dict"):
            return {}
        return {
            key: field["schema"]
            for name, field in schema["fields"].items()
            for key in _keys(field.get("validation_alias") or name)
        }

    def _step(self, place: SchemaPlace, item: str | int) -> SchemaPlace:
        schema = place.schema
        match schema["type"]:
            case "tagged-union":
                chosen = _choice(schema, item)
                return SchemaPlace(place.path, self.bare(chosen), place.parent, place.unions)
            case "union":
                chosen = self._member(schema, str(item))
                return SchemaPlace(place.path, chosen, place.parent, (*place.unions, (place.path, str(item))))
        child = self.bare(self._child(schema, item))
        return SchemaPlace((*place.path, item), child, schema, place.unions)

    def _child(self, schema: Schema, item: str | int) -> Schema:
        match schema["type"]:
            case "model-fields" | "typed-dict":
                return self.fields(schema).get(str(item), _ANY)
            case "dict":
                return _schema(schema, "values_schema")
            case "tuple" if isinstance(item, int):
                items, variadic = schema["items_schema"], schema.get("variadic_item_index")
                index = item if variadic is None else min(item, variadic)
                return _as_schema(items[index]) if index < len(items) else _ANY
            case "list" | "set" | "frozenset":
                return _schema(schema, "items_schema")
        return _ANY

    def members(self, union: Schema) -> list[Schema]:
        """Return the schemas of a union's alternatives; a valid value fits at least one of them."""
        choices: Any = union["choices"]
        listed = choices.values() if isinstance(choices, dict) else choices
        return [self.bare(choice[0] if isinstance(choice, tuple) else choice) for choice in listed]

    def _member(self, union: Schema, label: str) -> Schema:
        # pydantic labels a member with its class, its kind, or kind[what is inside].
        members = self.members(union)
        names = [(_class_name(member), member["type"]) for member in self._unreferenced(union)]
        for member, name in zip(members, names, strict=True):
            if label in (*name, member["type"]):
                return member
        kind = label.partition("[")[0]
        like = (m for m, name in zip(members, names, strict=True) if kind in (name[1], m["type"]))
        return next(like, _ANY)

    def _unreferenced(self, union: Schema) -> list[Schema]:
        choices = [choice[0] if isinstance(choice, tuple) else choice for choice in union["choices"]]
        return [
            self._definitions.get(choice["schema_ref"], _ANY)
            if choice["type"] == "definition-ref"
            else choice
            for choice in choices
        ]


def _keys(alias: Any) -> list[str]:
    """Return the keys that one field may have in a file: an alias, or one path of one key for each choice."""
    return [alias] if isinstance(alias, str) else [str(path[0]) for path in alias]


def _inside(schema: Schema) -> Schema:
    if schema["type"] == "chain":
        return _as_schema(schema["steps"][0])
    for part in ("json_schema", "strict_schema", "schema"):
        if part in schema:
            return _as_schema(schema[part])
    return _ANY


def _schema(schema: Schema, part: str) -> Schema:
    return _as_schema(schema.get(part, _ANY))


def _as_schema(schema: Any) -> Schema:
    return schema if isinstance(schema, Mapping) else _ANY


def _choice(union: Schema, tag: str | int) -> Schema:
    choices: Mapping[Any, Any] = union["choices"]
    found = choices.get(tag, _ANY)
    # A choice may be the tag of another one.
    return _as_schema(choices.get(found, _ANY) if isinstance(found, str) else found)


def _class_name(schema: Schema) -> str:
    return getattr(schema.get("cls"), "__name__", "")
