"""JSON Schemas of the files for completion and checks in editors."""

from typing import Any

from pydantic import BaseModel, TypeAdapter

SCHEMA_DIALECT = "https://json-schema.org/draft/2020-12/schema"


def schema(model: type[BaseModel] | TypeAdapter[Any], title: str | None = None) -> dict[str, Any]:
    """Return the JSON Schema of a kind of file.

    Descriptions are the docstrings of the classes and those under their fields.

    Args:
        model: type of the file's content.
        title: title of the schema (default: the name of the class).
    """
    adapter: TypeAdapter[Any] = model if isinstance(model, TypeAdapter) else TypeAdapter(model)
    body = adapter.json_schema(mode="validation", by_alias=True)
    name = title or body.pop("title", None) or "handcart"
    return {
        "$schema": SCHEMA_DIALECT,
        "title": name,
        **{key: part for key, part in body.items() if key != "title"},
    }
