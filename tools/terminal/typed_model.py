"""A model whose values were typed as KEY=VALUE."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TypeVar

from pydantic import BaseModel

from handcart.files.errors import FileError
from handcart.files.models.loading import load_part
from handcart.files.models.settings import setting_value, split_setting, split_settings
from handcart.files.yaml.yaml_document import Document
from handcart.files.yaml.yaml_node import Node

Model = TypeVar("Model", bound=BaseModel)


def typed_model(kind: type[Model], words: Sequence[str], command: str) -> Model:
    """Return a model (checked data, as of a file) from fields that were typed as arguments of a command.

    Each field is checked as in a file; a text needs no quotes.

    Args:
        kind: class of the model.
        words: fields, `KEY=VALUE` each.
        command: the text typed before the fields, used in messages.

    Raises:
        FileError: fields are invalid; the error contains all faults, each in the form in which the field was
            typed.
    """
    try:
        split_settings(words)
        content = dict(_value(kind, word) for word in words)
        return load_part(Document(command, b"", Node(content, command, 0, 0, 0, 0)), (), kind)
    except FileError as error:
        findings = (replace(finding, file=finding.file.removeprefix("--set ")) for finding in error.findings)
        raise FileError(findings) from None


def _value(kind: type[BaseModel], word: str) -> tuple[str, Node]:
    key, value = split_setting(word)
    field = kind.model_fields.get(key)
    is_text = field is not None and field.annotation is str and value[:1] not in ("'", '"')
    return key, Node(value, f"--set {key}={value}", 0, 0, 0, 0) if is_text else setting_value(key, value)
