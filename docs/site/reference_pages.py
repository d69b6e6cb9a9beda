"""Generate the reference pages of the site from the program: commands, file formats, primitives, backends.

A page that is generated cannot disagree with the program. Nothing here is imported by the program.
"""

from __future__ import annotations

import inspect
import io
from collections.abc import Iterator
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any

import typer

GENERATED_NOTE = "*Generated from the program.*\n"


def write(folder: Path) -> None:
    """Write all generated pages into a folder; a page whose text is unchanged keeps its time stamp."""
    folder.mkdir(parents=True, exist_ok=True)
    pages = {"commands": commands(), "files": files(), "primitives": primitives(), "backends": backends()}
    for name, text in pages.items():
        page = folder / f"{name}.md"
        if not page.exists() or page.read_text(encoding="utf-8") != text:
            page.write_text(text, encoding="utf-8")


def commands() -> str:
    """Return a page with the usage and the options of each command of `handcart`."""
    from handcart.tools.command_line import all_commands, app

    group: Any = typer.main.get_command(app)
    parts = ["# Commands\n", GENERATED_NOTE]
    with typer.Context(group, info_name="handcart") as context:
        for name in all_commands():
            _, command, _ = group.resolve_command(context, name.split())
            parts += _command(name, command, context)
    return "\n".join(parts)


def _command(name: str, command: Any, parent: typer.Context) -> Iterator[str]:
    context = typer.Context(command, info_name=name, parent=parent)
    yield f"## {name}\n"
    yield f"{inspect.cleandoc(command.help or '')}\n"
    yield f"```text\nhandcart {name} {' '.join(command.collect_usage_pieces(context))}\n```\n"
    records = [option.get_help_record(context) for option in command.params]
    rows = [(f"`{names}`", text) for names, text in filter(None, records)]
    if rows:
        yield _table(("argument or option", "meaning"), rows)


def files() -> str:
    """Return a page with the keys of each kind of YAML file, from its model."""
    from handcart.files.models import json_schema
    from handcart.tools.checks.file_kinds import kinds, model_of

    parts = ["# File formats\n", GENERATED_NOTE]
    for kind in kinds():
        schema = json_schema.schema(model_of(kind))
        parts += [
            f"## {kind}\n",
            f"`format: handcart-{kind}/1`; `handcart schema {kind}` prints its JSON Schema.\n",
        ]
        parts += _schema_tables(schema)
    return "\n".join(parts)


def _schema_tables(schema: dict[str, Any]) -> Iterator[str]:
    """Yield the table of the root object, then one for each object that it refers to."""
    for title, part in (("", schema), *schema.get("$defs", {}).items()):
        if title:
            yield f"### {title}\n"
        if text := part.get("description"):
            yield f"{inspect.cleandoc(text)}\n"
        rows = [
            (
                f"`{key}`",
                _type(value),
                "yes" if key in part.get("required", ()) else _default(value),
                _line(value),
            )
            for key, value in part.get("properties", {}).items()
        ]
        if rows:
            yield _table(("key", "type", "required, or default", "meaning"), rows)


def _type(value: dict[str, Any]) -> str:
    if "$ref" in value:
        return value["$ref"].rsplit("/", 1)[-1]
    for joint in ("anyOf", "oneOf", "allOf"):
        if joint in value:
            return " or ".join(dict.fromkeys(_type(part) for part in value[joint]))
    if "const" in value or "enum" in value:
        return ", ".join(f"`{word}`" for word in value.get("enum", [value.get("const")]))
    if value.get("type") == "array":
        inner = value.get("items") or (value.get("prefixItems") or [{}])[0]
        return f"list of {_type(inner)}"
    if value.get("type") == "object" and isinstance(value.get("additionalProperties"), dict):
        return f"names with {_type(value['additionalProperties'])}"
    kind = value.get("type", "any")
    return str(kind) if isinstance(kind, str) else " or ".join(kind)


def _default(value: dict[str, Any]) -> str:
    return f"`{value['default']}`" if value.get("default") not in (None, {}, []) else ""


def _line(value: dict[str, Any]) -> str:
    return " ".join(value.get("description", "").split())


def primitives() -> str:
    """Return a page with what `handcart describe` prints of each primitive."""
    from handcart.primitives.registry import primitive_names

    return _described("Primitives", primitive_names())


def backends() -> str:
    """Return a page with what `handcart describe` prints of each backend."""
    from handcart.backends.registry import backend_names

    return _described("Backends", backend_names())


def _described(title: str, names: Any) -> str:
    from handcart.tools.commands.describe import describe

    parts = [f"# {title}\n", GENERATED_NOTE, "`handcart describe NAME` prints the same.\n"]
    for name in names:
        with redirect_stdout(io.StringIO()) as said:
            describe(name)
        parts.append(f"## {name}\n\n```text\n{said.getvalue().strip()}\n```\n")
    return "\n".join(parts)


def _table(head: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    lines = [head, tuple("---" for _ in head), *rows]
    return "\n".join("| " + " | ".join(_cell(cell) for cell in line) + " |" for line in lines) + "\n"


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|")
