"""A model whose values were typed as KEY=VALUE."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TypeVar

from pydantic import BaseModel

from handcart.files.errors import FileError
from handcart.files.models.loading import load_part
from handcart.files.models.settings import setting_value, split_setting
from handcart.files.yaml.yaml_document import Document
from handcart.files.yaml.yaml_node import Node

Model = TypeVar("Model", bound=BaseModel)


def typed_model(kind: type[Model], words: Sequence[str], command: str) -> Model:
    """Return a model from typed fields, each checked as in a file; a text field needs no quotes.

    Args:
        kind: class of the model.
        words: KEY=VALUE each.
        command: the text typed before them, used in messages.

    Raises:
        FileError: with all faults, each in the form in which it was typed.
    """
    try:
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
