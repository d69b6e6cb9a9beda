"""Fetching and carrying objects that a file describes."""

from __future__ import annotations

from .domain import Domain, Knowledge

DOMAIN = Domain(
    "objects",
    knowledge=Knowledge(
        "handcart.primitives.objects.objects:Objects",
        {"objects": "Objects: their kinds, tags and surfaces, and where they are believed to be."},
    ),
    props="handcart.backends.simulation.objects.object_props:ObjectProps",
    physics="handcart.backends.physics.objects.bodies:PROP_BODIES",
    files={"objects": "handcart.primitives.objects.objects_file:ObjectsFile"},
)
