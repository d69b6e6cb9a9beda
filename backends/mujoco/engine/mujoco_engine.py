"""MuJoCo: its clock, its bodies, its saved states."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from typing import Any

import numpy as np
from typing_extensions import override

from handcart.backends.physics.engine.engine import ContactPoint, Engine, Pinned, Touching
from handcart.backends.physics.engine.thing_form import ThingForm
from handcart.backends.plain_values import from_plain, to_plain
from handcart.backends.saved_state import NotAState
from handcart.backends.simulation.world.material import WOOD_MATERIAL, Material
from handcart.backends.simulation.world.sheet import Sheet
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.numerics.arrays import ByteArray, FloatArray, IntArray

from .beams import LidarBeams
from .growing_model import GrowingModel
from .leaning import Leaning
from .looks import BoxLook, Looks, TileLook
from .mujoco_module import mujoco
from .numbering import Numbering, ThingNumbers
from .pins import Pins
from .pressing import Pressing
from .saved_data import restore, saved
from .slipping import Slipping
from .world_spec import box_inertia, quaternion

SLIP_CHECK_STEPS = 2  # steps of the solver after which it is seen whether what is held slips
TOUCH_CHECKS_PER_PERIOD = 4  # times at a period's end that what touches is looked at


class MujocoEngine(Engine):
    """Physics engine MuJoCo with a world's bodies, numbered from 0, and a robot.

    The drives are MuJoCo's: Python commands the drives once in a control period, and reads contacts and slip
    several times in it.
    """

    CHUNK = math.inf
    CONTACTS_CARRY = 0.5  # contacts act on speeds, not on positions: an object in a turning hand drifts

    def __init__(self, period: float) -> None:
        """Start the engine with an empty world; the control period is in [s]."""
        super().__init__(period)
        mujoco()
        self._grown = GrowingModel(self.chunk / self.substeps, self._number)
        self.world = self._grown.world
        self._forms: list[ThingForm | None] = []
        self.looks = Looks()
        """Appearance of all bodies."""
        self.pins = Pins()
        """Pinned connection of the hand and a thing, where contacts alone don't hold it."""
        self._slipping = Slipping(self.pins, self.CONTACTS_CARRY, self.chunk)
        self._links: dict[int, tuple[int, int]] = {}
        self._bodies: dict[tuple[int, int], int] = {}
        self._leaning = Leaning()
        self._is_pulled = False
        self._seen: FloatArray | None = None
        """All coordinates when `moved` was last asked; None: everything may have moved."""

    # The model

    @property
    def model(self) -> Any:
        """MuJoCo's `MjModel` of the robot and all bodies of the world, compiled if needed."""
        return self._grown.both()[0]

    @property
    def data(self) -> Any:
        """MuJoCo's `MjData` (the state); its poses of links may be outdated, and `links` updates them."""
        return self._grown.both()[1]

    def grow(self) -> int:
        """Return the number of the body that was just added to `world`.

        The model is compiled again when it is next used.
        """
        self._grown.changed()
        self._forms.append(None)
        return len(self._forms) - 1

    def changed(self) -> None:
        """Mark the model as outdated after a change of `world`; the next use compiles it again."""
        self._grown.changed()

    def link_body(self, number: int, link: int) -> int:
        """Return MuJoCo's number of a link's body.

        Args:
            number: number that this engine gave to the robot or thing with the link.
            link: index of the link in that robot or thing.
        """
        return self._bodies[number, link]

    def name_links(self, number: int, bodies: dict[str, int]) -> None:
        """Register which body of MuJoCo represents each link of a robot or thing.

        Args:
            number: number of the robot or thing in this engine.
            bodies: index of each link, by the name of the body of MuJoCo that represents it.
        """
        model = self.model
        self._links = {model.body(name).id: (number, link) for name, link in bodies.items()}
        self._bodies = {owner: body for body, owner in self._links.items()}
        self._number(model)

    def _number(self, model: Any) -> None:
        """Find the owners of the geometries and coordinates of a new model."""
        things = [number for number, form in enumerate(self._forms) if form is not None]
        self._numbering, self._seen = Numbering(model, self._links, things), None
        self._pressing, self._beams = Pressing(self._numbering.owners), LidarBeams(model)
        self._leaning.compiled(model, next(iter(self._links), None))
        if (pinned := self._slipping.pinned) is not None:
            self.pins.aim(model, pinned, *self._joined(pinned))

    def links(self) -> Any:
        """Return MuJoCo's data (`MjData`) with the current poses of all links."""
        return self._grown.links()

    def displaced(self) -> None:
        """Mark all poses as outdated after a joint was set; the next call of the method `links` computes them
        again.
        """
        self._grown.displaced()

    def parts(self) -> Sequence[int]:
        """Return the numbers of solver steps to make before each reading of the contacts, in order.

        Their sum is the number of steps in a chunk, the time between two commands to the drives. Contact
        forces are read several times in a chunk and averaged, because the force of a single impact would
        mislead.
        """
        often = max(0, min(TOUCH_CHECKS_PER_PERIOD, self.substeps // SLIP_CHECK_STEPS - 1))
        return (self.substeps - often * SLIP_CHECK_STEPS, *(SLIP_CHECK_STEPS,) * often)

    @override
    def step(self, steps: int | None = None) -> None:
        model, data = self._grown.both()
        steps = self.substeps if steps is None else steps
        while (pinned := self._slipping.pinned) is not None and steps > 0:
            mujoco().mj_step(model, data, min(SLIP_CHECK_STEPS, steps))
            steps -= SLIP_CHECK_STEPS
            self._slipping.look(model, data, *self._joined(pinned))
        if steps > 0:
            mujoco().mj_step(model, data, steps)
        self.displaced()
        self._leaning.look(model, data)

    @override
    def close(self) -> None:
        self._grown.forget()

    # Bodies

    @override
    def add_floor(self, friction: float) -> int:
        number = self.grow()
        self.looks.level = True
        self.world.floor(number, friction)
        return number

    @override
    def add_box(
        self, box: Box, friction: float, grey: int, moves: bool = False, material: Material = WOOD_MATERIAL
    ) -> int:
        number = self.grow()
        self.looks.boxes[number] = BoxLook(box, grey, moves, material)
        self.world.box(number, box, friction, moves)
        return number

    @override
    def add_tile(self, corner: FloatArray, cell: float, heights: FloatArray, friction: float) -> int:
        number = self.grow()
        self.looks.tiles[number] = TileLook(corner, cell, heights)
        self.world.tile(number, corner, cell, heights, friction)
        return number

    @override
    def add_sheet(self, sheet: Sheet) -> None:
        self.looks.sheets.append(sheet)

    @override
    def add_thing(self, form: ThingForm) -> int:
        number = self.grow()
        self._forms[number] = self.looks.things[number] = form
        self.world.thing(number, form)
        return number

    @override
    def show(self, body: int, picture: ByteArray) -> None:
        self.looks.shown[body] = picture

    @override
    def weigh(self, body: int, mass: float) -> None:
        form = self._forms[body]
        assert form is not None
        inertia = box_inertia(mass, form.size)
        model, index = self.model, self.thing_at(body).body
        model.body_mass[index], model.body_inertia[index] = mass, inertia
        pinned = model.eq_data.copy()
        mujoco().mj_setConst(model, mujoco().MjData(model))  # how hard contacts push follows from the masses
        model.eq_data[:] = pinned  # it has things held where they were at first
        spec = self.world.spec.body(f"{body}")
        spec.mass, spec.inertia = mass, inertia

    def pose(self, body: int) -> Transform:
        """Return the pose world_T_body (4, 4) of a thing's frame, which is at its centre of mass."""
        index, data = self.thing_at(body).body, self.links()
        result = np.zeros((4, 4))
        result[:3, :3], result[:3, 3], result[3, 3] = data.xmat[index].reshape(3, 3), data.xpos[index], 1.0
        return result

    @override
    def moved(self) -> Collection[int] | None:
        coordinates, seen = self.data.qpos, self._seen
        self._seen = coordinates.copy()
        return None if seen is None else self._numbering.moved(coordinates != seen)

    def thing_at(self, body: int) -> ThingNumbers:
        """Return the indices of a movable body in MuJoCo's arrays, by its number in this engine."""
        self._grown.both()
        return self._numbering.things[body]

    @override
    def set_pose(self, body: int, pose: Transform) -> None:
        model, data = self._grown.both()
        placed = np.concatenate([pose[:3, 3], quaternion(pose)])
        if body in self._numbering.things:
            thing = self._numbering.things[body]
            if thing.coordinates == 1:
                raise ValueError(f"the body {body} moves with a joint alone")
            data.qpos[thing.position : thing.position + 7] = placed
            data.qvel[thing.velocity : thing.velocity + 6] = 0.0
        else:
            mocap = int(model.body(f"{body}").mocapid[0])
            data.mocap_pos[mocap], data.mocap_quat[mocap] = placed[:3], placed[3:]
        self.displaced()

    @override
    def pull(self, body: int | None, force: FloatArray) -> None:
        if body is None and not self._is_pulled:
            return
        applied = self.data.xfrc_applied
        applied[:] = 0.0
        self._is_pulled = body is not None
        if body is not None:
            applied[self.thing_at(body).body, :3] = force

    @override
    def touches(self, body: int, anything: bool) -> None:
        bits, model = int(anything), self.model
        thing = self._numbering.things[body]
        model.body_contype[thing.body] = model.body_conaffinity[thing.body] = bits  # MuJoCo looks here first
        for geometry in thing.geometries:
            model.geom_contype[geometry] = model.geom_conaffinity[geometry] = bits
            spec = self.world.spec.geom(model.geom(geometry).name)
            spec.contype = spec.conaffinity = bits

    @property
    @override
    def pinned(self) -> Pinned | None:
        return self._slipping.pinned

    @override
    def pin(self, wanted: Pinned | None) -> None:
        model, data = self._grown.both()
        if wanted is None:
            self._slipping.let_go(data)
        else:
            self._slipping.hold(model, data, wanted, *self._joined(wanted))

    @override
    def pin_force(self) -> FloatArray:
        return self.pins.force(self.data)

    def _joined(self, pinned: Pinned) -> tuple[int, int]:
        """Return MuJoCo's numbers of the two bodies that are held together."""
        return self.link_body(pinned.body, pinned.link), self._numbering.things[pinned.other].body

    # Bodies of the model

    @override
    def touching(self, body: int) -> Collection[Touching]:
        data = self.data  # compiling may renumber what `data` refers to
        return self._pressing.touching(data, body)

    @override
    def contacts(self, body: int) -> list[ContactPoint]:
        data = self.data
        return self._pressing.contacts(data, body)

    @override
    def free_shares(self, start: FloatArray, ends: FloatArray) -> FloatArray:
        data = self.links()
        return self._beams.free_shares(data, start, ends)

    # States

    def state(self) -> dict[str, Any]:
        """Return MuJoCo's state, and the connection between hand and held thing, for a checkpoint.

        A run that is restored from this state continues like the original run, to the last bit.
        """
        pinned = to_plain(self.pinned, Pinned | None)
        leans = self._leaning.trees.astype(np.int64)
        return {**saved(self.model, self.data), "pinned": pinned, "leans": leans}

    @override
    def set_state(self, state: object) -> None:
        model, data = self._grown.both()
        if not isinstance(state, dict) or not {"pinned", "leans"} <= state.keys():
            raise NotAState("no state of this engine; needed: mujoco, asleep, pinned, leans")
        pinned = from_plain(state["pinned"], Pinned | None, "pinned")
        self._check_pinned(pinned)
        leans = from_plain(state["leans"], IntArray, "leans")
        if leans.shape != self._leaning.trees.shape:
            raise NotAState("no saved state: the engine's world has other bodies")
        own = {name: state[name] for name in state if name not in ("pinned", "leans")}
        self.pin(pinned)
        restore(model, data, own)  # an object that is slipping now is not held
        self._leaning.set(model, leans != 0)
        self.displaced()
        self._seen = None

    def _check_pinned(self, pinned: Pinned | None) -> None:
        if pinned is None:
            return
        if pinned.other not in self._numbering.things or (pinned.body, pinned.link) not in self._bodies:
            raise NotAState("no saved state: the held body is missing")
        if len(pinned.points) != len(pinned.other_points):
            raise NotAState("no saved state: the held body has other points")
