"""Description in words of the values that a schema allows: "a number from 15 to 45 mm"."""

from typing import Any

from handcart.files.models.schema_walk import Schema, SchemaWalk
from handcart.files.models.units import unit_of
from handcart.files.printable import clipped
from handcart.files.suggest import listed

_KINDS = {
    "str": "text",
    "bool": "true or false",
    "none": "nothing",
    "list": "a list",
    "tuple": "a list",
    "set": "a list",
    "frozenset": "a list",
    "dict": "a mapping",
    "model-fields": "a mapping",
    "typed-dict": "a mapping",
}


def shown(value: object) -> str:
    """Return a short description of a value for messages, on one line, such as "a list of 3"."""
    match value:
        case None:
            return "empty"
        case bool():
            return str(value).lower()
        case int() | float():
            return str(value)
        case str():
            return repr(clipped(value))
        case dict():
            return "a mapping"
        case list():
            return f"a list of {len(value)}"
    return clipped(repr(value))


def described(walk: SchemaWalk, schema: Schema, key: str = "") -> str:
    """Return a description in words of the values that a schema allows; "" if any value is allowed.

    Args:
        walk: lookup of referenced schemas in the model that contains the schema.
        schema: schema of the value.
        key: key of the value in the file, whose ending names the unit.
    """
    match schema["type"]:
        case "int" | "float" | "decimal":
            return _number(schema, unit_of(key))
        case "literal" | "enum":
            return listed(names_of(schema))
        case "union":
            return " or ".join(filter(None, (described(walk, m, key) for m in walk.members(schema))))
        case "tagged-union":
            by = schema["discriminator"]
            named = f" with {by}: {listed(map(str, schema['choices']))}" if isinstance(by, str) else ""
            return f"a mapping{named}"
        case "model-fields" | "typed-dict":
            keys = walk.fields(schema)
            return f"a mapping with the {'key' if len(keys) == 1 else 'keys'} {listed(keys)}"
        case "str":
            return _text(schema)
        case "list" | "set" | "frozenset" | "tuple" | "dict" as kind:
            return _KINDS[kind] + _count(schema)
    return _KINDS.get(schema["type"], "")


def names_of(schema: Schema) -> list[str]:
    """Return the words that a literal or an enumeration allows, as spelled in a file."""
    if schema["type"] == "enum":
        return [_word(member.value) for member in schema["members"]]
    if schema["type"] == "literal":
        return [_word(value) for value in schema["expected"]]
    return []


def _word(value: object) -> str:
    return value if isinstance(value, str) else shown(getattr(value, "value", value))


def _number(schema: Schema, unit: str) -> str:
    kind = "a whole number" if schema["type"] == "int" else "a number"
    bounds = {
        bound: f"{schema[bound]:.12g}" for bound in ("ge", "gt", "le", "lt") if schema.get(bound) is not None
    }
    if "ge" in bounds and "le" in bounds:
        span = f"from {bounds['ge']} to {bounds['le']}"
    else:
        words = {"ge": "at least", "gt": "above", "le": "at most", "lt": "below"}
        span = " and ".join(f"{words[bound]} {value}" for bound, value in bounds.items())
    return " ".join(filter(None, (kind, span, unit and (unit if span else f"in {unit}"))))


def _text(schema: Schema) -> str:
    pattern = schema.get("pattern")
    like = f" like {getattr(pattern, 'pattern', pattern)}" if pattern else ""
    return f"text{like}{_span(schema, 'characters')}"


def _count(schema: Schema) -> str:
    if schema["type"] == "tuple" and schema.get("variadic_item_index") is None:
        return f" of {len(schema['items_schema'])}"
    return _span(schema, "entries")


def _span(schema: Schema, of: str) -> str:
    least: Any = schema.get("min_length")
    most: Any = schema.get("max_length")
    if least is None and most is None:
        return ""
    if least == most:
        return f" of {least} {of}"
    low = f"at least {least}" if least is not None else ""
    high = f"at most {most}" if most is not None else ""
    return f" of {' and '.join(filter(None, (low, high)))} {of}"
