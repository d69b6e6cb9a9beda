"""Classes of bodies in physics, for `handcart.tasks.domain`."""

from __future__ import annotations

from handcart.backends.simulation.objects.carried_object import CarriedObject

from .object_body import ObjectBody

PROP_BODIES = {CarriedObject: ObjectBody}
