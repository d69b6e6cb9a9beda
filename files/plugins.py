"""Plugins of other packages, found by their entry points."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping
from functools import lru_cache
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from handcart.files.errors import InputError
from handcart.files.printable import printable

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint


def entry_points_of(group: str) -> list[EntryPoint]:
    """Return the entry points of a group in the installed packages, sorted by name.

    The standard library's `importlib.metadata` reads the entry points of every package, and importing it
    takes longer than all of `handcart --help`. The module is therefore imported only if an installed package
    has this group.
    """
    if not any(_may_have(folder or ".", f"[{group}]") for folder in sys.path):
        return []
    from importlib.metadata import entry_points

    return sorted(entry_points(group=group), key=lambda entry_point: entry_point.name)


class BrokenPlugin(InputError):
    """Error of another package's plugin that cannot be used."""

    def __init__(self, what: str, wrong: str) -> None:
        how = "allowed: to fix the package, or to uninstall it"
        super().__init__(printable(f"{what} can't be used: {wrong}; {how}"))


def paths_of(group: str, own: Mapping[str, str]) -> dict[str, str]:
    """Return import paths by name: those of an entry-point group of installed packages, and the shipped ones.

    Args:
        group: name of the entry-point group.
        own: shipped names with their import paths, which entry points cannot replace.
    """
    return {point.name: point.value for point in entry_points_of(group)} | dict(own)


def check_name(name: str, group: str, own: Mapping[str, str]) -> None:
    """Refuse a name that an entry point shares with a shipped one, or with another entry point.

    The meaning of such a name is ambiguous; a shipped one is never replaced silently.

    Args:
        name: the name.
        group: name of the entry-point group.
        own: shipped names with their import paths.

    Raises:
        BrokenPlugin: several different objects have this name.
    """
    points = [point for point in entry_points_of(group) if point.name == name]
    others = [f"{point.value}{package_of(point)}" for point in points if point.value != own.get(name)]
    if len({*others, *([own[name]] if name in own else [])}) > 1:
        both = [own[name], *others] if name in own else others
        raise BrokenPlugin(f"the name {name!r} in {group}", f"{' and '.join(both)} have it")


def package_of(point: EntryPoint) -> str:
    """Return the text " of the package NAME" to be put after an entry point's name; empty if the package is
    unknown.
    """
    return f" of the package {point.dist.name}" if point.dist else ""


def import_plugin(path: str, what: str) -> Any:
    """Return the object at an import path "module:name".

    Args:
        path: the import path.
        what: kind and name of the plugin in messages.

    Raises:
        ModuleNotFoundError: the module, or one that it imports, is not installed.
        BrokenPlugin: a module of another package raised an error; errors of shipped modules pass through.
    """
    module, _, name = path.partition(":")
    try:
        return getattr(import_module(module), name)
    except ModuleNotFoundError:
        raise
    except (Exception, SystemExit) as error:
        if module.startswith("handcart."):  # a library of ours is broken: that is not a plug-in's fault
            raise
        raise BrokenPlugin(f"{what} ({path})", error_words(error)) from None


def error_words(error: BaseException) -> str:
    """Return an error that was raised while a package was imported, as one line of text."""
    if isinstance(error, SystemExit):
        return f"it ends the process when it is imported (SystemExit: {error.code})"
    return f"{type(error).__name__}: {error}".split("\n")[0]


def plugin_folders(group: str) -> dict[str, Path]:
    """Return the folders of the packages that an entry-point group names, by entry-point name.

    The value of each entry point is the name of a package. The package is located without being imported;
    its parent packages are imported. A package that cannot be located is skipped; `broken_plugin_folders`
    reports it.
    """
    found = ((point.name, _package_folder(point)) for point in entry_points_of(group))
    return {name: folder for name, folder in found if folder is not None}


def broken_plugin_folders(group: str) -> list[str]:
    """Return a message for each entry point of a group whose package cannot be located."""
    return [
        f"the entry point {point.name!r} of {group} names the package {point.value!r}, which cannot be found"
        for point in entry_points_of(group)
        if _package_folder(point) is None
    ]


def _package_folder(point: EntryPoint) -> Path | None:
    from importlib.util import find_spec

    try:
        spec = find_spec(point.value)
    except (ImportError, ValueError, AttributeError):
        return None
    places = list(spec.submodule_search_locations or ()) if spec else []
    return Path(places[0]) if places else None


def _may_have(folder: str, section: str) -> bool:
    """Return whether an entry of Python's path may hold a package with that section; True for archives."""
    try:
        infos = _infos_in(folder, os.stat(folder).st_mtime_ns)
        return any(section in _entry_points_text(info) for info in infos)
    except NotADirectoryError:
        return True
    except OSError:
        return False


@lru_cache(maxsize=256)
def _infos_in(folder: str, changed: int) -> tuple[str, ...]:
    """Return the entry-point files that packages in a folder may have; listed again after a change.

    Args:
        folder: an entry of Python's path.
        changed: time of the folder's last change, in [ns].

    Raises:
        OSError: it is not a folder, or cannot be read.
    """
    infos = (
        name
        for name in os.listdir(folder)
        if name.endswith((".dist-info", ".egg-info")) or name == "EGG-INFO"
    )
    return tuple(os.path.join(folder, name, "entry_points.txt") for name in infos)


def _entry_points_text(path: str) -> str:
    """Return the declarations of a package, empty if it has none; read again after the file has changed.

    A development install rewrites the file in its place, which leaves the folder's time as it is.
    """
    try:
        found = os.stat(path)
    except OSError:
        return ""
    return _text(path, found.st_mtime_ns, found.st_size)


@lru_cache(maxsize=1024)
def _text(path: str, changed: int, size: int) -> str:
    """Return the text of a file; `changed` in [ns] and `size` in [bytes] distinguish its versions."""
    try:
        return Path(path).read_text(encoding="utf-8", errors="replace")
    except OSError:
        return ""
