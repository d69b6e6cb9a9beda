"""Classes of bodies in physics, for `handcart.tasks.domain`."""

from __future__ import annotations

from handcart.backends.simulation.doors.door_part import DoorPart

from .door_body import DoorBody

PROP_BODIES = {DoorPart: DoorBody}
