"""Which classes stand for what in Bullet; see `handcart.tasks.domain`."""

from __future__ import annotations

from handcart.backends.pybullet.blocks.block_body import BlockBody
from handcart.backends.simulation.field.field_props import FieldProps
from handcart.backends.simulation.field.sensor import Sensor

from .bullet_magazine import BulletMagazine

BODIES = {Sensor: BlockBody, FieldProps: BulletMagazine}
