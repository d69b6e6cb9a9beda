"""Expanding a xacro file into a URDF, with the optional library `xacrodoc`."""

from __future__ import annotations

import contextlib
import io
from pathlib import Path

from handcart.files.errors import FileError, Finding, UnsafePath
from handcart.files.extras import lack

XACRO_SUFFIX = ".xacro"


def is_xacro(file: Path) -> bool:
    """Return whether a file is a xacro file, by its suffix."""
    return file.suffix.lower() == XACRO_SUFFIX


def expanded(file: Path) -> str:
    """Return the URDF into which xacro expands a file; meshes that are found are named by absolute paths.

    xacro evaluates Python expressions in the file, with few functions. Therefore only files that the user has
    named are expanded.

    Raises:
        FileError: `xacrodoc` is not installed, or xacro rejects the file.
    """
    from handcart.backends.urdf.mesh_path import is_mesh, mesh_path
    from handcart.robotics.kinematics.urdf_assembly import with_mesh_files

    def found(name: str) -> str:
        try:
            path = mesh_path(name, file, file.parent)
        except UnsafePath:
            return name
        return str(path) if is_mesh(path) else name

    return with_mesh_files(_run_xacro(file), found)


def _run_xacro(file: Path) -> str:
    if wrong := lack("a xacro file", "xacro"):
        raise FileError([Finding(str(file), 1, 1, f"{wrong}; or write a URDF: xacro FILE > robot.urdf")])
    import xacrodoc
    from xacro import substitution_args

    substitution_args._eval_find = lambda package: str(_package_folder(package, file))
    try:
        with contextlib.redirect_stderr(io.StringIO()), contextlib.redirect_stdout(io.StringIO()):
            document = xacrodoc.XacroDoc.from_file(str(file), walk_up=False, resolve_packages=False)
            return str(document.to_urdf_string())
    except (Exception, SystemExit) as error:  # whatever an expression of the file raises
        words = " ".join(str(error).split())[:300] or type(error).__name__
        raise FileError([Finding(str(file), 1, 1, f"xacro can't expand it: {words}")]) from None


def _package_folder(name: str, file: Path) -> Path:
    """Return the folder of the ROS package to which `$(find NAME)` in a xacro file refers.

    It is a folder of this name around the file or next to such a folder, or an installed package.
    """
    from handcart.backends.urdf.packages import package_folders

    for folder in file.resolve().parents:
        if folder.name == name:
            return folder
        if (folder / name).is_dir():
            return folder / name
    found = next(package_folders(name), None)
    if found is None:
        raise LookupError(f"unknown package {name!r}")
    return found
