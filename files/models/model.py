"""The base of all models of files: nothing unknown, nothing changed, nothing infinite."""

from pydantic import BaseModel, ConfigDict


class FileModel(BaseModel):
    """Base class of a mapping in a file; unknown keys are errors."""

    model_config = ConfigDict(
        extra="forbid", frozen=True, allow_inf_nan=False, use_attribute_docstrings=True, validate_default=True
    )
