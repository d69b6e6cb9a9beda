"""Classes of bodies in physics, for `handcart.tasks.domain`."""

from __future__ import annotations

from handcart.backends.physics.blocks.block_body import BlockBody
from handcart.backends.simulation.field.field_props import FieldProps
from handcart.backends.simulation.field.sensor import Sensor

from .magazine import Magazine

PROP_BODIES = {Sensor: BlockBody, FieldProps: Magazine}
