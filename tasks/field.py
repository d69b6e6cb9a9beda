"""Laying sensors across a field."""

from __future__ import annotations

from .domain import Domain, Knowledge

DOMAIN = Domain(
    "field",
    knowledge=Knowledge(
        "handcart.primitives.field.field_work:FieldWork",
        {
            "field": "A field: how far it reaches, and what is known to stand there.",
            "targets": "Where sensors go in it: CSV or GeoJSON.",
        },
    ),
    files={"field": "handcart.primitives.field.field:Field"},
    primitives={"DEPLOY": "handcart.primitives.field.deploy:Deploy"},
    props="handcart.backends.scene.field.field_props:FieldProps",
)
