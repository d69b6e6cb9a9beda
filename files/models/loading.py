"""Loading of a typed value from a YAML file, with all findings reported at once."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, Generic, TypeVar, cast

from pydantic import TypeAdapter, ValidationError

from handcart.files.errors import FileError, Finding
from handcart.files.findings import Findings
from handcart.files.models.model import FileModel
from handcart.files.models.model_findings import findings_of
from handcart.files.models.settings import with_settings
from handcart.files.yaml.yaml_document import Document, read_document
from handcart.files.yaml.yaml_node import KeyPath

FileModelT = TypeVar("FileModelT")


@dataclass(frozen=True)
class Loaded(Generic[FileModelT]):
    """Checked content of a file, with the document from which later checks take the lines of their
    findings.
    """

    value: FileModelT
    document: Document

    def finding(self, path: KeyPath, message: str, *, at_key: bool = False) -> Finding:
        """Return a finding at a value of the file.

        Args:
            path: key path of the value.
            message: "what is wrong; what is allowed".
            at_key: True for the place of the value's key instead.
        """
        return self.document.finding(path, message, at_key=at_key)

    def refuse(self, path: KeyPath, message: str, *, at_key: bool = False) -> FileError:
        """Return an error with one finding, for the caller to raise; `handcart.files.findings.Findings`
        collects several.

        Args:
            path: key path of the value.
            message: "what is wrong; what is allowed".
            at_key: True to report the place of the key instead of that of its value.
        """
        return FileError([self.finding(path, message, at_key=at_key)])


def load(
    path: Path | str,
    model: type[FileModelT] | TypeAdapter[FileModelT],
    overrides: Mapping[str, str] | None = None,
    context: object = None,
) -> FileModelT:
    """Return the value of type `model` in the YAML file `path`.

    Args:
        path: the file.
        model: type of the value.
        overrides: unparsed values of `--set KEY=VALUE` by key of the file's section `parameters`; checked
            like values in the file. None: no value is changed.
        context: passed to the validators of the model (`info.context`).

    Raises:
        FileError: with every finding.
    """
    return load_document(with_settings(read_document(path), overrides or {}), model, context).value


def load_document(
    document: Document, model: type[FileModelT] | TypeAdapter[FileModelT], context: object = None
) -> Loaded[FileModelT]:
    """Return the content of a document as a typed value, together with the document.

    Args:
        document: the file, already read.
        model: type of the value, a class or a TypeAdapter.
        context: passed to the validators of the model (`info.context`).

    Raises:
        FileError: the document does not fit the type; the error contains every problem found.
    """
    value = load_part(document, (), model, context)
    if isinstance(value, FileModel) and (found := list(value.contradictions(document))):
        raise FileError(found)
    return Loaded(value, document)


def load_part(
    document: Document,
    path: KeyPath,
    model: type[FileModelT] | TypeAdapter[FileModelT],
    context: object = None,
) -> FileModelT:
    """Return a part of a document as a typed value.

    It is used for parts whose type depends on another part of the file, such as the parameters of a
    primitive. Values are not converted: text is not a number, true is not 1, 1.0 is not a whole number.

    Args:
        document: the file.
        path: key path of the part.
        model: type of the value, a class or a TypeAdapter.
        context: passed to the validators of the model (`info.context`).

    Raises:
        FileError: the part is missing or invalid; with every finding.
    """
    adapter: TypeAdapter[FileModelT] = model if isinstance(model, TypeAdapter) else _adapter(cast(Any, model))
    node, there = document.root.deepest(path)
    if not there:
        raise FileError([document.finding(path, f"the key {path[-1]!r} is missing; needed: a value")])
    try:
        # Strict validation of JSON suits a file: no type passes for another, but lists become tuples
        # and words become members of enumerations.
        return adapter.validate_json(json.dumps(node.plain()), strict=True, context=context)
    except ValidationError as error:
        raise FileError(findings_of(error, adapter, document, path)) from None


@lru_cache(maxsize=256)
def _adapter(model: Any) -> TypeAdapter[Any]:
    """Return the validator of a type, cached: the types of files build theirs on first use, which is slow."""
    return TypeAdapter(model)


def collect(findings: Findings, document: Document, path: KeyPath, model: Any, context: object = None) -> Any:
    """Validate the part of a document at `path`, and return it as a value of type `model`.

    All errors of the part are added to `findings`.

    The result is None after an error.
    """
    try:
        return load_part(document, path, model, context)
    except FileError as error:
        findings.take(error)
        return None
