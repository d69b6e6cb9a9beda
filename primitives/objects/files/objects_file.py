"""File of objects: kinds, objects, and the surfaces that carry them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, Literal

from pydantic import Field
from typing_extensions import override

from handcart.backends.description.things.printed_tag import PrintedTag
from handcart.files.models.model import FileModel
from handcart.robotics.perception.objects.known_solids import KnownSolid

from .object_findings import object_findings
from .object_kind import KnownObject, Name, ObjectKind
from .surface import ObjectSurface

if TYPE_CHECKING:
    from handcart.files.errors import Finding
    from handcart.files.yaml.yaml_document import Document


class ObjectsFile(FileModel):
    """File of objects that a robot finds, picks and places, and of the surfaces that carry them."""

    format: Literal["handcart-objects/1"]
    kinds: dict[Name, ObjectKind]
    surfaces: dict[Name, ObjectSurface]
    objects: dict[Name, KnownObject] = Field(default_factory=dict)
    detectors: dict[Name, dict[str, Any]] = Field(default_factory=dict)
    """Detectors of other packages, by the names of their entry points, with their options."""

    @override
    def contradictions(self, document: Document) -> Iterator[Finding]:
        yield from object_findings(document, self.kinds, self.surfaces, self.objects)

    def solids(self) -> dict[str, KnownSolid]:
        """Return the shapes of all kinds of objects in the file, by name."""
        return {name: KnownSolid(name, kind.size, kind.is_round) for name, kind in self.kinds.items()}

    def kind_of(self, name: str) -> ObjectKind:
        """Return the kind (shape and size) of the object `name`; both the object and its kind must be in the
        file.
        """
        return self.kinds[self.objects[name].kind]

    def tags_of(self, name: str) -> tuple[PrintedTag, ...]:
        """Return all tags on the object `name`: those printed on each object of its kind, and those on this
        object only.
        """
        return (*self.kind_of(name).tags, *self.objects[name].tags)
