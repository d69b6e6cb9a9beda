"""Write constraints.txt: the versions of all packages that `.[dev]` brings, as they are installed here.

    python scripts/constraints.py

Run it after the tests passed. `pip install -e '.[dev]' -c constraints.txt` then reproduces the environment.
"""

from __future__ import annotations

import tomllib
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

REPOSITORY_ROOT = Path(__file__).resolve().parents[1]
FILE_HEADER = "# Written by scripts/constraints.py: versions that passed the tests (Python 3.11, Linux).\n"


def main() -> None:
    """Write the file beside pyproject.toml."""
    project = tomllib.loads((REPOSITORY_ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = project["optional-dependencies"]
    pending = [
        Requirement(text)
        for text in (*project["dependencies"], *(line for part in extras.values() for line in part))
    ]
    versions: dict[str, str] = {}
    seen: set[str] = set()
    while pending:
        requirement = pending.pop()
        name = canonicalize_name(requirement.name)
        if name == project["name"] or f"{name}{sorted(requirement.extras)}" in seen:
            continue
        seen.add(f"{name}{sorted(requirement.extras)}")
        try:
            found = distribution(name)
        except PackageNotFoundError:
            continue
        versions[name] = found.version
        pending += [
            part
            for part in map(Requirement, found.requires or ())
            if part.marker is None
            or any(part.marker.evaluate({"extra": extra}) for extra in (*requirement.extras, ""))
        ]
    lines = "".join(f"{name}=={version}\n" for name, version in sorted(versions.items()))
    (REPOSITORY_ROOT / "constraints.txt").write_text(FILE_HEADER + lines, encoding="utf-8")


if __name__ == "__main__":
    main()
