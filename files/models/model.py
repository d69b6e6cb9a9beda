"""The base of all models of files: nothing unknown, nothing changed, nothing infinite."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel, ConfigDict, GetJsonSchemaHandler

from .field_docstrings import field_docstrings

if TYPE_CHECKING:
    from handcart.files.errors import Finding
    from handcart.files.yaml.yaml_document import Document


class FileModel(BaseModel):
    """Base class of pydantic models for mappings in YAML files; unknown keys are errors."""

    model_config = ConfigDict(
        extra="forbid", frozen=True, allow_inf_nan=False, defer_build=True, validate_default=True
    )

    def contradictions(self, document: Document) -> Iterator[Finding]:
        """Yield the contradictions between parts of a whole file; called once each part is valid.

        Args:
            document: the file, which knows the lines of its values.
        """
        return iter(())

    @classmethod
    def __get_pydantic_json_schema__(cls, core_schema: Any, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """Return the JSON Schema, with the docstrings below the fields as descriptions."""
        found = handler(core_schema)
        properties = handler.resolve_ref_schema(found).get("properties", {})
        for name, text in field_docstrings(cls).items():
            key = cls.model_fields[name].alias or name
            if key in properties:
                properties[key].setdefault("description", text)
        return found
