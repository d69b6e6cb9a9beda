"""Front and handle of a door as bodies."""

from __future__ import annotations

from typing import ClassVar, cast

from typing_extensions import override

from handcart.backends.physics.engine.thing_form import OnJoint, Sticks, ThingForm, WorldJoint
from handcart.backends.physics.world.thing_body import ThingBody
from handcart.backends.simulation.doors.door_part import DoorPart
from handcart.backends.simulation.doors.spec import SimulatedDoorSpec

HANDLE_MASS_KG = 0.2
MAX_LOCK_PLAY = 1e-4  # of a locked joint, in [rad] or [m]


class DoorBody(ThingBody):
    """Body of a physics engine for the front of a door or drawer on its hinge or slide, or for its handle."""

    STICKS: ClassVar[Sticks | None] = None

    @override
    def form(self) -> ThingForm:
        part = cast(DoorPart, self.thing)
        spec, form = part.spec, super().form()
        if part.is_handle:
            return form._replace(mass=HANDLE_MASS_KG, hung=OnJoint(spec.name, None))
        return form._replace(mass=spec.mass_kg, hung=OnJoint(spec.name, _joint(spec)))


def _joint(spec: SimulatedDoorSpec) -> WorldJoint:
    """Return the joint of a door that was made at its first opening."""
    joint, limits = spec.true_joint(), (spec.start - spec.opened, spec.stop - spec.opened + MAX_LOCK_PLAY)
    if joint.hinge is None:
        x, y, z = (joint.sign * joint.closed[:3, 0]).tolist()
        return WorldJoint(True, (0.0, 0.0, 0.0), (x, y, z), limits, spec.friction_n, spec.damping_n_s_m)
    x, y, z = (joint.closed @ (*joint.hinge, 0.0, 1.0))[:3].tolist()
    lever = joint.radius
    return WorldJoint(
        False,
        (x, y, z),
        (0.0, 0.0, joint.sign),
        limits,
        spec.friction_n * lever,
        spec.damping_n_s_m * lever**2,
    )
