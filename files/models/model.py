"""The base of all models of files: nothing unknown, nothing changed, nothing infinite."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from pydantic import BaseModel, ConfigDict

if TYPE_CHECKING:
    from handcart.files.errors import Finding
    from handcart.files.yaml.yaml_document import Document


class FileModel(BaseModel):
    """Base class of a mapping in a file; unknown keys are errors."""

    model_config = ConfigDict(
        extra="forbid", frozen=True, allow_inf_nan=False, use_attribute_docstrings=True, validate_default=True
    )

    def contradictions(self, document: Document) -> Iterator[Finding]:
        """Yield the contradictions between parts of a whole file; asked once each part is valid.

        Args:
            document: the file, which knows the lines of its values.
        """
        return iter(())
