"""`handcart adopt`: write calibration values into a robot's file."""

from __future__ import annotations

import difflib
import os
import shutil
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from handcart.networks.runs.calibration import Calibration


def adopt(
    run: Annotated[Path, typer.Argument(help="the run's folder, or its calibration.yaml")],
    robot: Annotated[
        str | None, typer.Option(help="the robot's YAML file, or a shipped robot (default: the run's)")
    ] = None,
    write: Annotated[bool, typer.Option("--write", help="change the robot's file")] = False,
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", help="write the changed file there instead, with its URDFs"),
    ] = None,
) -> None:
    """Print which values of the robot's file a run has calibrated differently, or write them into the file.

    Comments and order of the file are kept.
    """
    from handcart.backends.description.robot_names import robot_path
    from handcart.backends.loading.robot_loading import load_robot
    from handcart.tools.terminal.writing import write_text

    found = _calibration(run)
    name = robot or found.robot
    load_robot(name)
    file = robot_path(name)
    before = file.read_text(encoding="utf-8")
    after = _changed(before, found)
    _check(after, file)
    lines = before.splitlines(keepends=True), after.splitlines(keepends=True)
    print("".join(difflib.unified_diff(*lines, str(file), f"{file}, calibrated")), end="")
    for words in _deviations(found):
        print(words)
    if before == after:
        print(f"{file} has these values already")
    elif output is not None:
        _write_copy(output, after, file)
        print(f"written to {output}")
    elif write:
        _check_writable(file)
        write_text(file, after)
        print(f"written to {file}")
    else:
        print(f"nothing is changed yet; --write changes {file}, -o FILE writes a copy")


def _calibration(run: Path) -> Calibration:
    from handcart.files.errors import InputError
    from handcart.files.models.loading import load
    from handcart.networks.run_files.run_folder import check_folder
    from handcart.networks.runs.calibration import CALIBRATION_FILE, Calibration, calibration_path

    if run.is_dir():
        check_folder(run)
    path = calibration_path(run)
    if not path.is_file():
        raise InputError(
            f"{run}: it has no {CALIBRATION_FILE}; "
            "allowed: the folder of a run that calibrated something to its end"
        )
    return load(path, Calibration)


def _changed(text: str, found: Calibration) -> str:
    from handcart.tools.terminal.yaml_editing import edited, flow_list, put

    def change(data: Any) -> None:
        for key, item in found.found.items():
            put(data, key, flow_list(item.value) if isinstance(item.value, tuple) else item.value)

    return edited(text, change)


def _check(text: str, file: Path) -> None:
    """Check that the new text is a valid robot's file; raises `FileError`."""
    import tempfile

    from handcart.backends.loading.robot_model import model_for
    from handcart.files.errors import FileError, Finding
    from handcart.files.models.loading import load_document
    from handcart.files.yaml.yaml_document import read_document

    with tempfile.TemporaryDirectory() as folder:
        trial = Path(folder) / file.name
        trial.write_text(text, encoding="utf-8")
        try:
            document = read_document(trial)
            load_document(document, model_for(document))
        except FileError as error:
            raise FileError(
                Finding(f"{file}, calibrated", finding.line, finding.column, finding.message)
                for finding in error.findings
            ) from None


def _deviations(found: Calibration) -> list[str]:
    """Return the found values with their standard deviations, in words."""
    width = max(len(key) for key in found.found)
    words = [f"found by the backend {found.backend}; standard deviations:"]
    for key, item in found.found.items():
        sigmas = item.sigma if isinstance(item.sigma, tuple) else (item.sigma,)
        words.append(f"  {key:{width}}  {', '.join(f'{sigma:g}' for sigma in sigmas)}")
    return words


def _check_writable(file: Path) -> None:
    from handcart.tools.terminal.writing import NotWritable

    if not (os.access(file, os.W_OK) and os.access(file.parent, os.W_OK)):
        raise NotWritable(file, "it is read-only", "-o FILE for a copy of your own")


def _write_copy(output: Path, text: str, file: Path) -> None:
    """Write the changed file elsewhere, with the URDFs beside it that it names."""
    from handcart.backends.loading.robot_loading import load_robot
    from handcart.files.inside import resolve_inside
    from handcart.tools.terminal.writing import NotWritable, check_folder, write_text

    if output.suffix not in (".yaml", ".yml"):
        raise NotWritable(output, f"unknown suffix {output.suffix!r} of a robot's file", "*.yaml")
    check_folder(output.parent)
    spec = load_robot(str(file))
    for name in (spec.urdf, *(part.urdf for part in spec.parts)):
        if name.startswith("package://"):
            continue
        source, target = resolve_inside(file.parent, name), output.parent / name
        target.parent.mkdir(parents=True, exist_ok=True)
        if not target.exists():
            shutil.copyfile(source, target)
    write_text(output, text)
