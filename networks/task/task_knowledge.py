"""Prior knowledge from a task's files, each read once."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from handcart.files.errors import FileError, UnsafePath
from handcart.files.findings import Findings
from handcart.files.models.loading import Loaded
from handcart.files.yaml.yaml_document import Document
from handcart.files.yaml.yaml_node import KeyPath
from handcart.primitives.knowledge.place import Place, Places, load_places
from handcart.primitives.knowledge.section import NamedFiles, Section
from handcart.primitives.knowledge.sections import section_class
from handcart.robotics.geometry.pose2 import Pose2
from handcart.tasks.domain import domains

PLACES_KIND = "places"
MAP_ORIGIN = Pose2(0.0, 0.0, 0.0)
UNKNOWN_START = "unknown"
"""Value of `start` under `knowledge:` if the start is unknown; a place of that name precedes it."""


@dataclass(frozen=True)
class TaskKnowledge:
    """Places and other prior knowledge from the files that a task names, except its map.

    Each domain, which is a kind of work such as opening doors, has a section of the world model.
    """

    places: Loaded[Places] | None
    """Places of the map; None if no file names them."""
    sections: Mapping[str, Section]
    """Sections of the domains, by the domains' names."""
    start: Pose2 = MAP_ORIGIN
    """map_T_base at first: at the place that the task names, or at the map's origin."""
    is_start_known: bool = True
    """False if the task says that the start is unknown."""
    are_files_read: bool = True
    """False if a file with places, or of a domain, is missing or its places cannot be read."""

    def names(self) -> dict[str, Collection[object]]:
        """Return the names that may be values of actions' parameters, by kind, such as the names of all
        `places`.

        A kind is missing if the task names no file for it, or if the file cannot be read.
        """
        every: dict[str, Collection[object] | None] = {}
        for section in self.sections.values():
            every |= section.names()
        found = {kind: names for kind, names in every.items() if names is not None}
        computed = every.get(PLACES_KIND, ())
        if computed is None or not self.are_files_read:
            found.pop(PLACES_KIND, None)
        elif self.places is not None or computed or self._more_places():
            found[PLACES_KIND] = [*self.all_places(), *computed]
        return found

    def all_places(self) -> dict[str, Place]:
        """Return the known places by name, those of the file of places and those from the files of all
        domains.
        """
        return {**(self.places.value.places if self.places else {}), **self._more_places()}

    def _more_places(self) -> dict[str, Place]:
        return {name: place for section in self.sections.values() for name, place in section.places().items()}

    def fresh_sections(self) -> dict[str, Section]:
        """Return new copies of all world model sections for one run; the run may change them."""
        return {name: replace(section) for name, section in self.sections.items()}


def read_knowledge(
    document: Document, findings: Findings, resolved: Callable[[Document, KeyPath], Path | None]
) -> TaskKnowledge:
    """Read the files that a task names under `knowledge`, except its maps.

    Missing files, and files outside the allowed folders, are skipped.

    Args:
        document: the task.
        findings: list to which faults in the files are added.
        resolved: function that returns the path of the file that the task names under a key.
    """

    def path(key: str) -> Path | None:
        try:
            found = resolved(document, ("knowledge", key))
        except UnsafePath:
            return None
        return found if found is not None and found.is_file() else None

    places = _places(path(PLACES_KIND), findings)
    start = _start(document, places)
    is_known = not is_start_unknown(document, list(places.value.places) if places else ())
    paths = {key: found for key in domain_keys() if (found := path(key)) is not None}
    named = [key for key in domain_keys() if document.root.deepest(("knowledge", key))[1]]
    lacks_places = places is None and document.root.deepest(("knowledge", PLACES_KIND))[1]
    sections = read_sections(paths, start, document, findings)
    return TaskKnowledge(places, sections, start, is_known, not lacks_places and len(named) == len(paths))


def read_sections(
    paths: Mapping[str, Path], start: Pose2, document: Document, findings: Findings
) -> dict[str, Section]:
    """Read the world model sections that have a file, by the names of their domains (kinds of work).

    Args:
        paths: paths of the files, by their keys under `knowledge:`.
        start: pose of the base at the start, map_T_base.
        document: the document that names the files.
        findings: findings in the files are added here.
    """
    found = {}
    for domain in domains():
        own = {
            key: paths[key] for key in (domain.knowledge.files if domain.knowledge else ()) if key in paths
        }
        kind = section_class(domain) if own else None
        if kind is not None:
            found[domain.name] = kind.load(NamedFiles(own, start, document, findings))
    return found


def _places(path: Path | None, findings: Findings) -> Loaded[Places] | None:
    try:
        return load_places(path) if path else None
    except FileError as error:
        findings.take(error)
        return None


def _start(document: Document, places: Loaded[Places] | None) -> Pose2:
    node, there = document.root.deepest(("knowledge", "start"))
    known = places.value.places if places else {}
    name = node.content if there and isinstance(node.content, str) else ""
    return known[name].pose if name in known else MAP_ORIGIN


def is_start_unknown(document: Document, names: Collection[object]) -> bool:
    """Return whether a task states that the robot's pose at the start is unknown.

    Args:
        document: the task.
        names: names of the task's places; if a place has the name `unknown`, this word means the place.
    """
    node, there = document.root.deepest(("knowledge", "start"))
    return there and node.content == UNKNOWN_START and UNKNOWN_START not in names


def domain_keys() -> list[str]:
    """Return the keys of a task file's `knowledge:` that belong to world model sections."""
    return [key for domain in domains() if domain.knowledge for key in domain.knowledge.files]
