"""Contradictions within a file of objects, at their lines."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from handcart.backends.description.things.printed_tag import PrintedTag
from handcart.files.suggest import suggest

from .object_kind import KnownObject, ObjectKind
from .surface import ObjectSurface

if TYPE_CHECKING:
    from handcart.files.errors import Finding
    from handcart.files.yaml.yaml_document import Document

OPENING_MARGIN_MM = 4.0  # that the fingers open wider than what they close on


def object_findings(
    document: Document,
    kinds: Mapping[str, ObjectKind],
    surfaces: Mapping[str, ObjectSurface],
    objects: Mapping[str, KnownObject],
) -> Iterator[Finding]:
    """Yield a finding for each value in a file of objects that contradicts another part of the file."""
    for name, kind in kinds.items():
        yield from _too_large(document, ("kinds", name), kind.tags, kind)
    for name, surface in surfaces.items():
        yield from _of_surface(document, name, surface, kinds)
    for name, known in objects.items():
        yield from _of_object(document, name, known, kinds.get(known.kind), surfaces.get(known.on))
        if known.kind not in kinds:
            words = f"unknown kind {known.kind!r}{suggest(known.kind, kinds)}"
            yield document.finding(("objects", name, "kind"), words)
        if known.on not in surfaces:
            words = f"unknown surface {known.on!r}{suggest(known.on, surfaces)}"
            yield document.finding(("objects", name, "on"), words)
    yield from _shared_tags(document, kinds, objects)


def gripper_findings(
    document: Document, kinds: Mapping[str, ObjectKind], opening_mm: float
) -> Iterator[Finding]:
    """Yield a finding for each kind of objects too large for fingers that open by `opening_mm`."""
    widest = opening_mm - OPENING_MARGIN_MM
    for name, kind in kinds.items():
        if min(kind.size_mm) > widest:
            wrong = f"no side of a {name} is narrow enough for the fingers: the least is"
            words = f"{wrong} {min(kind.size_mm):g} mm; allowed: at most {widest:g} mm"
            yield document.finding(("kinds", name, "size_mm"), words)


def _too_large(
    document: Document, path: tuple[str, ...], tags: Sequence[PrintedTag], kind: ObjectKind
) -> Iterator[Finding]:
    for number, tag in enumerate(tags):
        if not tag.fits(kind.size_mm, kind.is_round):
            words = f"the tag {tag.id} is larger than the side {tag.face}; allowed: {_allowed(kind)}"
            yield document.finding((*path, "tags", number), words)


def _allowed(kind: ObjectKind) -> str:
    if not kind.is_round:
        return "within its side"
    return f"on +z of a cylinder, within {kind.size_mm[0] * math.sqrt(0.5):.0f} mm"


def _of_surface(
    document: Document, name: str, surface: ObjectSurface, kinds: Mapping[str, ObjectKind]
) -> Iterator[Finding]:
    for number, kind in enumerate(() if surface.kinds == "any" else surface.kinds):
        if kind not in kinds:
            words = f"unknown kind {kind!r}{suggest(kind, kinds)}"
            yield document.finding(("surfaces", name, "kinds", number), words)
    for label, spot in surface.spots.items():
        if surface.margin(spot.x_m, spot.y_m) < 0.0:
            words = f"the spot {label!r} is outside of the surface; allowed: a point on it"
            yield document.finding(("surfaces", name, "spots", label), words, at_key=True)


def _of_object(
    document: Document, name: str, known: KnownObject, kind: ObjectKind | None, surface: ObjectSurface | None
) -> Iterator[Finding]:
    path = ("objects", name)
    if (known.x_m is None) != (known.y_m is None):
        words = "only one of x_m and y_m is given; allowed: both, or none for anywhere on the surface"
        yield document.finding(path, words, at_key=True)
    if kind is not None:
        yield from _too_large(document, path, known.tags, kind)
    if surface is None:
        return
    if surface.kinds != "any" and not surface.allows(known.kind):
        words = f"the surface {known.on!r} takes no {known.kind}; allowed: {', '.join(surface.kinds)}"
        yield document.finding((*path, "on"), words)
    if known.x_m is not None and known.y_m is not None and surface.margin(known.x_m, known.y_m) < 0.0:
        words = f"it is believed to be outside of {known.on!r}; allowed: a point on that surface"
        yield document.finding((*path, "x_m"), words)


def _shared_tags(
    document: Document, kinds: Mapping[str, ObjectKind], objects: Mapping[str, KnownObject]
) -> Iterator[Finding]:
    """Yield tags that are on two objects, which would be confused."""
    owners: dict[tuple[str, int], str] = {}
    for name, known in objects.items():
        shared = kinds[known.kind].tags if known.kind in kinds else ()
        for tag in (*shared, *known.tags):
            other = owners.setdefault(tag.key, name)
            if other != name:
                words = f"the tag {tag.family} {tag.id} is on {other!r} and on {name!r}"
                allowed = "allowed: each tag on one object"
                yield document.finding(("objects", name), f"{words}; {allowed}", at_key=True)
