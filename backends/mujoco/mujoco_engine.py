"""MuJoCo: its clock, its bodies, its saved states."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from handcart.backends.physics.engine import ContactPoint, Engine, Pinned, Touching
from handcart.backends.physics.thing_form import ThingForm
from handcart.backends.plain_values import from_plain, to_plain
from handcart.backends.saved_state import NotAState
from handcart.backends.simulation.world.material import WOOD, Material
from handcart.backends.simulation.world.sheet import Sheet
from handcart.backends.simulation.world.thing import GreyImage
from handcart.robotics.geometry.transform import Transform, inverse
from handcart.robotics.kinematics.shapes import Box

from .mujoco_module import mujoco
from .pins import Pins
from .rendering.looks import BoxLook, Looks, TileLook
from .saved_data import restore, saved
from .world_spec import ROBOT_GROUP, WorldSpec, box_inertia, quaternion

Array = NDArray[np.float64]
STAYS = 0.005  # [m/s]: slower, what slid in the hand is held again
_NO_ISLAND = -2
LOOKS = 2  # steps of the solver after which it is seen whether what is held slips
FELT = 4  # times at a period's end that what touches is looked at
_KEPT = ("actuator_gainprm", "actuator_biasprm", "actuator_forcerange")


class _Thing(NamedTuple):
    """Where a thing's numbers stand in MuJoCo's arrays."""

    body: int
    position: int
    """Of its seven coordinates."""
    velocity: int
    geometries: tuple[int, ...]


class MujocoEngine(Engine):
    """A model and its data of MuJoCo's. Bodies are numbered as they are made.

    The model is compiled when it is first asked for; what is added later has it compiled anew, and all that
    was there goes on as it was.
    """

    CHUNK = math.inf
    CONTACTS_CARRY = 0.5  # they know speeds, not places: what they hold in a hand that turns drifts

    def __init__(self, period: float) -> None:
        """Start the engine; see `Engine`."""
        super().__init__(period)
        self.mj = mujoco()
        self.world = WorldSpec(self.chunk / self.substeps)
        self._forms: list[ThingForm | None] = []
        self._compiled: tuple[Any, Any] | None = None
        self._grown = self._stale = True
        self._pinned: Pinned | None = None
        self.looks = Looks()
        """How all of it looks."""
        self.pins = Pins()
        """What holds together where contacts alone don't."""
        self._owners: list[tuple[int, int]] = []
        self._things: dict[int, _Thing] = {}
        self._links: dict[int, tuple[int, int]] = {}
        self._bodies: dict[tuple[int, int], int] = {}
        self._robot: int | None = None
        """Its tree of bodies."""
        self._leans = np.zeros(0, np.bool_)
        """(trees,): what touches the robot, by what is between them."""
        self._seen: Array | None = None
        """All coordinates when `moved` was last asked; None: everything may have moved."""
        self._movers: tuple[NDArray[np.int64], NDArray[np.int64]] = (np.zeros(0, np.int64),) * 2
        """Numbers of the things (n,), and where their coordinates are (n, 7)."""

    # The model

    @property
    def model(self) -> Any:
        """MuJoCo's model of all that was made."""
        return self._both()[0]

    @property
    def data(self) -> Any:
        """MuJoCo's data of it; poses of links in it may be those of before, see `links`."""
        return self._both()[1]

    def _both(self) -> tuple[Any, Any]:
        if self._grown or self._compiled is None:
            self._compile()
        assert self._compiled is not None
        return self._compiled

    def grow(self) -> int:
        """Something is added to `world`; gives the number of a further body."""
        self._grown = True
        self._forms.append(None)
        return len(self._forms) - 1

    def changed(self) -> None:
        """What is in `world` was changed."""
        self._grown = True

    def link_body(self, number: int, link: int) -> int:
        """MuJoCo's number of a link."""
        return self._bodies[number, link]

    def name_links(self, number: int, bodies: dict[str, int]) -> None:
        """A body is made of MuJoCo's bodies of these names, each with its number as a link."""
        model = self.model
        self._links = {model.body(name).id: (number, link) for name, link in bodies.items()}
        self._bodies = {owner: body for body, owner in self._links.items()}
        self._find_owners()

    def _compile(self) -> None:
        before = self._compiled
        if before is None:
            model = self.world.spec.compile()
            self._compiled = model, self.mj.MjData(model)
        else:
            self._compiled = self.world.spec.recompile(*before)
            model = self._compiled[0]
            for name in _KEPT:
                old, new = getattr(before[0], name), getattr(model, name)
                if old.shape == new.shape:
                    new[:] = old
        self._grown, self._stale = False, True
        self._find_owners()

    def _find_owners(self) -> None:
        """Whose the geometries are, and where things' coordinates stand."""
        assert self._compiled is not None
        model = self._compiled[0]
        owners, self._things = [(-1, -1)] * int(model.ngeom), {}
        mine: dict[int, list[int]] = {}
        for geometry in range(model.ngeom):
            body, name = int(model.geom_bodyid[geometry]), model.geom(geometry).name
            if body in self._links:
                owners[geometry] = self._links[body]
            elif name.partition(".")[0].isdigit():
                number = int(name.partition(".")[0])
                owners[geometry] = number, -1
                mine.setdefault(number, []).append(geometry)
        for number, form in enumerate(self._forms):
            if form is not None:
                joint = model.joint(f"{number}")
                self._things[number] = _Thing(
                    int(joint.bodyid[0]), int(joint.qposadr[0]), int(joint.dofadr[0]), tuple(mine[number])
                )
        self._owners = owners
        numbers = np.array(list(self._things), np.int64)
        first = np.array([each.position for each in self._things.values()], np.int64)
        self._movers, self._seen = (numbers, first[:, None] + np.arange(7)), None
        self._robot = int(model.body_treeid[next(iter(self._links))]) if self._links else None
        leaned, self._leans = self._leans, np.zeros(int(model.ntree), np.bool_)
        if self._robot is not None:
            self._set_leaning(np.pad(leaned, (0, len(self._leans) - len(leaned))))

    def links(self) -> Any:
        """MuJoCo's data, poses of all links as of now."""
        data = self.data
        if self._stale:
            self.mj.mj_kinematics(self.model, data)
            self._stale = False
        return data

    def displaced(self) -> None:
        """Coordinates were changed: poses follow when they are asked for."""
        self._stale = True

    def parts(self) -> Sequence[int]:
        """See `Engine`: a force is felt as a mean, for that of an impact alone misleads."""
        often = max(0, min(FELT, self.substeps // LOOKS - 1))
        return (self.substeps - often * LOOKS, *(LOOKS,) * often)

    def step(self, steps: int | None = None) -> None:
        """See `Engine`."""
        model, data = self._both()
        steps = self.substeps if steps is None else steps
        while self._pinned is not None and steps > 0:
            self.mj.mj_step(model, data, min(LOOKS, steps))
            steps -= LOOKS
            self._stale = True
            self._slip(self._pinned)
        if steps > 0:
            self.mj.mj_step(model, data, steps)
        self._stale = True
        self._keep_awake(model, data)

    def _keep_awake(self, model: Any, data: Any) -> None:
        """Let nothing sleep that leans on the robot: it would not fall when the robot goes away."""
        if self._robot is None:
            return
        island = data.tree_island
        mine = island[self._robot]
        leans = island == (mine if mine >= 0 else _NO_ISLAND)
        if (leans != self._leans).any():
            self._set_leaning(leans)

    def _set_leaning(self, leans: NDArray[np.bool_]) -> None:
        """Have those trees stay awake, and all others sleep when they come to rest."""
        kinds, policy = self.mj.mjtSleepPolicy, self.model.tree_sleep_policy
        policy[self._leans] = kinds.mjSLEEP_ALLOWED
        policy[leans] = kinds.mjSLEEP_NEVER
        policy[self._robot] = kinds.mjSLEEP_NEVER
        self._leans = leans

    def _slip(self, pinned: Pinned) -> None:
        """Let what is held slide while more pulls at it than holds it, and hold it again where it stays."""
        data = self.data
        if self.pins.closed(data):
            # While they hold, contacts carry next to nothing: what is still can pull at these points alone.
            if self.pins.pull(data) > pinned.force_n / (1.0 - self.CONTACTS_CARRY):
                self.pins.open(data)
            return
        there = self._points_now(pinned)
        slid = float(np.linalg.norm(there - np.array(pinned.other_points), axis=1).max())
        points = tuple((float(x), float(y), float(z)) for x, y, z in there)
        self._pinned = replace(pinned, other_points=points)
        if slid < STAYS * self.chunk:
            self.pin(self._pinned)

    def _points_now(self, pinned: Pinned) -> Array:
        """Where the hand's points are in the frame of what is held, (n, 3) in [m]."""
        data, link = self.links(), self.link_body(pinned.body, pinned.link)
        middle = np.eye(4)
        middle[:3, :3], middle[:3, 3] = data.ximat[link].reshape(3, 3), data.xipos[link]
        other_T_hand = inverse(self.pose(pinned.other)) @ middle
        return np.asarray(np.array(pinned.points) @ other_T_hand[:3, :3].T + other_T_hand[:3, 3])

    def close(self) -> None:
        """See `Engine`."""
        self._compiled, self._grown = None, True

    # Bodies

    def add_floor(self, friction: float) -> int:
        """See `Engine`."""
        number = self.grow()
        self.looks.level = True
        self.world.floor(number, friction)
        return number

    def add_box(
        self, box: Box, friction: float, grey: int, moves: bool = False, material: Material = WOOD
    ) -> int:
        """See `Engine`."""
        number = self.grow()
        self.looks.boxes[number] = BoxLook(box, grey, moves, material)
        self.world.box(number, box, friction, moves)
        return number

    def add_tile(self, corner: Array, cell: float, heights: Array, friction: float) -> int:
        """See `Engine`."""
        number = self.grow()
        self.looks.tiles[number] = TileLook(corner, cell, heights)
        self.world.tile(number, corner, cell, heights, friction)
        return number

    def add_sheet(self, sheet: Sheet) -> None:
        """See `Engine`."""
        self.looks.sheets.append(sheet)

    def add_thing(self, form: ThingForm) -> int:
        """See `Engine`."""
        number = self.grow()
        self._forms[number] = self.looks.things[number] = form
        self.world.thing(number, form)
        return number

    def show(self, body: int, picture: GreyImage) -> None:
        """See `Engine`."""
        self.looks.shown[body] = picture

    def weigh(self, body: int, mass: float) -> None:
        """See `Engine`."""
        form = self._forms[body]
        assert form is not None
        inertia = box_inertia(mass, form.size)
        model, index = self.model, self._things[body].body
        model.body_mass[index], model.body_inertia[index] = mass, inertia
        pinned = model.eq_data.copy()
        self.mj.mj_setConst(model, self.mj.MjData(model))  # how hard contacts push follows from the masses
        model.eq_data[:] = pinned  # it has things held where they were at first
        spec = self.world.spec.body(f"{body}")
        spec.mass, spec.inertia = mass, inertia

    def pose(self, body: int) -> Transform:
        """See `Engine`; of things."""
        index, data = self.thing_at(body).body, self.links()
        result = np.zeros((4, 4))
        result[:3, :3], result[:3, 3], result[3, 3] = data.xmat[index].reshape(3, 3), data.xpos[index], 1.0
        return result

    def moved(self) -> Collection[int] | None:
        """See `Engine`."""
        coordinates, seen = self.data.qpos, self._seen
        self._seen = coordinates.copy()
        if seen is None:
            return None
        changed = coordinates != seen
        numbers, where = self._movers
        return frozenset(numbers[changed[where].any(axis=1)].tolist())

    def thing_at(self, body: int) -> _Thing:
        """Where a thing stands in MuJoCo's arrays."""
        self._both()
        return self._things[body]

    def set_pose(self, body: int, pose: Transform) -> None:
        """See `Engine`."""
        model, data = self._both()
        placed = np.concatenate([pose[:3, 3], quaternion(pose)])
        if body in self._things:
            thing = self._things[body]
            data.qpos[thing.position : thing.position + 7] = placed
            data.qvel[thing.velocity : thing.velocity + 6] = 0.0
        else:
            mocap = int(model.body(f"{body}").mocapid[0])
            data.mocap_pos[mocap], data.mocap_quat[mocap] = placed[:3], placed[3:]
        self._stale = True

    def touches(self, body: int, anything: bool) -> None:
        """See `Engine`."""
        bits, model = int(anything), self.model
        thing = self._things[body]
        model.body_contype[thing.body] = model.body_conaffinity[thing.body] = bits  # MuJoCo looks here first
        for geometry in thing.geometries:
            model.geom_contype[geometry] = model.geom_conaffinity[geometry] = bits
            spec = self.world.spec.geom(model.geom(geometry).name)
            spec.contype = spec.conaffinity = bits

    @property
    def pinned(self) -> Pinned | None:
        """See `Engine`."""
        return self._pinned

    def pin(self, wanted: Pinned | None) -> None:
        """See `Engine`."""
        self._pinned = wanted
        if wanted is None:
            self.pins.open(self.data)
            return
        link = self.link_body(wanted.body, wanted.link)
        self.pins.close(self.model, self.data, wanted, link, self._things[wanted.other].body)

    # What is there

    def touching(self, body: int) -> set[Touching]:
        """See `Engine`."""
        return {touching for touching, *_ in self._pressing(body)}

    def contacts(self, body: int) -> list[ContactPoint]:
        """See `Engine`."""
        pressing = list(self._pressing(body))
        contact, forces = self.data.contact, self.data.efc_force
        # A contact's frame has its normal first, which points from the first to the second geometry.
        frames = [sign * contact.frame[index].reshape(3, 3) for _, index, _, sign in pressing]
        return [
            ContactPoint(*touching, tuple(frame[0].tolist()), tuple((forces[row : row + 3] @ frame).tolist()))
            for (touching, _, row, _), frame in zip(pressing, frames, strict=True)
        ]

    def _pressing(self, body: int) -> Iterator[tuple[Touching, int, int, float]]:
        """Of contacts of a body: who, its number, its first row of forces, and the sign of its frame."""
        contact, forces, owners = self.data.contact, self.data.efc_force, self._owners
        rows = contact.efc_address.tolist()
        for index, (row, (first, second)) in enumerate(zip(rows, contact.geom.tolist(), strict=True)):
            one, other = owners[first], owners[second]
            if row < 0 or body not in (one[0], other[0]) or forces[row] <= 0.0:
                continue
            if one[0] == body:
                yield Touching(one[1], *other), index, row, -1.0
            if other[0] == body:
                yield Touching(other[1], *one), index, row, 1.0

    def free_shares(self, start: Array, ends: Array) -> Array:
        """See `Engine`."""
        model, data = self.model, self.links()
        ways = np.ascontiguousarray(ends - start)
        met, share = np.full(len(ways), -1, np.int32), np.zeros(len(ways))
        groups = np.ones(6, np.uint8)
        groups[ROBOT_GROUP] = 0
        self.mj.mj_multiRay(
            model, data, start, ways.ravel(), groups, True, -1, met, share, None, len(ways), 1.0
        )
        return np.where((met >= 0) & (share <= 1.0), share, np.inf)

    # States

    def state(self) -> dict[str, Any]:
        """See `Engine`: to the last bit."""
        pinned = to_plain(self._pinned, Pinned | None)
        return {**saved(self.model, self.data), "pinned": pinned, "leans": self._leans.astype(np.int64)}

    def set_state(self, state: object) -> None:
        """See `Engine`."""
        self._both()
        if not isinstance(state, dict) or not {"pinned", "leans"} <= state.keys():
            raise NotAState("no state of this engine; needed: mujoco, asleep, pinned, leans")
        pinned = from_plain(state["pinned"], Pinned | None, "pinned")
        self._check_pinned(pinned)
        leans = from_plain(state["leans"], NDArray[np.int64], "leans")
        if leans.shape != self._leans.shape:
            raise NotAState("no saved state: the engine's world has other bodies")
        own = {name: state[name] for name in state if name not in ("pinned", "leans")}
        self.pin(pinned)
        restore(self.model, self.data, own)  # what slips just now isn't held
        self._set_leaning(leans != 0)
        self._stale, self._seen = True, None

    def _check_pinned(self, pinned: Pinned | None) -> None:
        if pinned is None:
            return
        if pinned.other not in self._things or (pinned.body, pinned.link) not in self._links.values():
            raise NotAState("no saved state: what is held together isn't there")
        if len(pinned.points) != len(pinned.other_points):
            raise NotAState("no saved state: what is held together has other points")
