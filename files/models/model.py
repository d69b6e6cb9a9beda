"""The base of all models of files: nothing unknown, nothing changed, nothing infinite."""

from pydantic import BaseModel, ConfigDict


class FileModel(BaseModel):
    """Mapping in a file.

    Unknown keys are refused, values are frozen and finite; the docstring under a field in the class is its
    description in the JSON Schema. Units are in the names of the fields: `width_mm`.
    """

    model_config = ConfigDict(
        extra="forbid", frozen=True, allow_inf_nan=False, use_attribute_docstrings=True, validate_default=True
    )
