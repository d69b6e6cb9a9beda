"""Checks that the libraries needed by handcart are installed, and settings that keep them quiet."""

from __future__ import annotations

import os
import re
import sys
import warnings
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

from handcart.files.errors import InputError
from handcart.files.extras import EXTRA_MODULES, extra_of, is_there

IMPORT_NAMES = {
    "opencv-python-headless": "cv2",
    "pin": "pinocchio",
    "python-fcl": "fcl",
    "python-can": "can",
    "pyserial": "serial",
    "pillow": "PIL",
    "py-trees": "py_trees",
    "arro3-core": "arro3.core",
    "arro3-io": "arro3.io",
    "foxglove-sdk": "foxglove",
    "pyyaml": "yaml",
    "ruamel-yaml": "ruamel.yaml",
}
"""Import names of libraries whose package has another name."""
_SILENT = {
    "OPENCV_LOG_LEVEL": "SILENT",  # its C++ code prints each picture that it cannot read to stderr
    "OPENCV_FFMPEG_LOGLEVEL": "-8",  # as does the encoder of videos
    "PYTHONWARNINGS": "ignore",  # in processes that are begun by this one
}
"""Environment variables that silence the messages of libraries to programmers."""
_REQUIRED = re.compile(
    r'Requires-Dist: ([\w.-]+)(?:\[[\w,]*\])?([<>=!~\d.,]*)(?:;.*extra == "(\w+)")?$', re.MULTILINE
)


class NoLibrary(InputError):
    """Error: a library that handcart needs is missing, too old, or cannot be imported.

    The exit status is 2 (row K13 of docs/reference/faults.md).
    """

    def __init__(self, wrong: Iterable[str], install: Iterable[str]) -> None:
        line = " ".join(f"'{text}'" for text in install)
        super().__init__(f"{'; '.join(wrong)}; to install: {sys.executable} -m pip install {line}")

    @classmethod
    def of(cls, error: Exception) -> NoLibrary | None:
        """Return the error for a failed import of a library; None for another error, or a missing module of
        handcart.
        """
        if not isinstance(error, ImportError):
            return None
        root = (error.name or "").partition(".")[0]
        if root == "handcart":
            return None
        extra = extra_of(error)
        if extra is not None:
            return cls([f"the library {root} can't be imported: {error}"], [f"handcart[{extra}]"])
        found = {_module(requirement.name).partition(".")[0]: requirement for requirement in required()}
        install = str(found[root]) if root in found else root or "handcart"
        return cls([f"the library {root or '?'} can't be imported: {error}"], [install])


class Requirement(NamedTuple):
    """Library that the installation of handcart requires, with the allowed versions."""

    name: str
    versions: str
    """Version specifier, such as `>=2.0,<3`."""
    extra: str = ""
    """Extra of handcart that requires it; empty: it is always required."""

    def __str__(self) -> str:
        return self.name + self.versions


def check_libraries() -> None:
    """Check that all required libraries are installed in allowed versions.

    Only the names of folders are read, which takes 1 ms.

    Raises:
        NoLibrary: a library is missing, too old or too new; the error names all of them.
    """
    installed, wrong, install = dict(_installed()), [], []
    for requirement in required():
        version = installed.get(_plain(requirement.name))
        if version is None and (requirement.extra or is_there(_module(requirement.name))):
            continue  # asked for where it is needed; or from a distribution of another name
        if version is None:
            wrong.append(f"the library {requirement.name} is missing")
        elif not _fits(version, requirement.versions):
            wrong.append(f"the library {requirement.name} is {version}; needed: {requirement.versions}")
        else:
            continue
        install.append(str(requirement))
    if wrong:
        raise NoLibrary(wrong, install)


def required() -> list[Requirement]:
    """Return the libraries that handcart's installed package requires; empty if handcart is not installed."""
    for folder in sys.path:
        for found in Path(folder or ".").glob("handcart-*.dist-info/METADATA"):
            head = found.read_text(encoding="utf-8").partition("\n\n")[0]
            every = (Requirement(*match) for match in _REQUIRED.findall(head))
            return [
                requirement
                for requirement in every
                if not requirement.extra or requirement.extra in EXTRA_MODULES
            ]
    return []


def _installed() -> Iterator[tuple[str, str]]:
    for folder in reversed(sys.path):  # reversed, because the first folder on the path counts
        try:
            names = os.listdir(folder or ".")
        except OSError:
            continue
        for item in names:
            if item.endswith((".dist-info", ".egg-info")):
                name, _, version = item.rpartition(".")[0].partition("-")
                yield _plain(name), version.partition("-")[0]


def _plain(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def _module(name: str) -> str:
    return IMPORT_NAMES.get(_plain(name), _plain(name).replace("-", "_"))


def _fits(version: str, wanted: str) -> bool:
    has = _numbers(version)
    for part in filter(None, wanted.split(",")):
        how, than = re.match(r"([<>=!~]+)(.*)", part).groups()  # type: ignore[union-attr]
        least = _numbers(than)
        if (how == ">=" and has < least) or (how == "<" and has >= least):
            return False
    return True


def _numbers(version: str) -> tuple[int, ...]:
    found = re.match(r"(?:\d+!)?(\d+(?:\.\d+)*)", version)
    numbers = [int(part) for part in found.group(1).split(".")] if found else []
    while numbers and not numbers[-1]:
        numbers.pop()  # 2.0 is 2
    return tuple(numbers)


def quiet_libraries() -> None:
    """Switch off warnings and messages of libraries; has to be called before any of them is imported.

    Settings by environment variables or by `python -W` have precedence.
    """
    chosen = bool(sys.warnoptions)
    for name, value in _SILENT.items():
        if not (chosen and name == "PYTHONWARNINGS"):
            os.environ.setdefault(name, value)
    if not chosen:
        warnings.simplefilter("ignore")
