"""Classes of bodies in physics, for `handcart.tasks.domain`."""

from __future__ import annotations

from handcart.backends.simulation.objects.carried_object import CarriedObject
from handcart.backends.simulation.objects.object_props import ObjectProps

from .object_body import ObjectBody
from .object_pulls import ObjectPulls

PROP_BODIES = {CarriedObject: ObjectBody, ObjectProps: ObjectPulls}
