"""The backends that can be named."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from handcart.backends.description.robot_file import RobotFile
from handcart.files.errors import FileError, InputError
from handcart.files.extras import extra_of
from handcart.files.plugins import check_name, import_plugin, paths_of
from handcart.files.suggest import suggest
from handcart.robotics.geometry.pose2 import Pose2

from .backend import Backend, NoBench

if TYPE_CHECKING:
    from handcart.robotics.navigation.maps.grid_map import GridMap

SHIPPED_BACKENDS = {
    "can": "handcart.backends.can.can_backend:CanBackend",
    "mujoco": "handcart.backends.mujoco.mujoco_backend:MujocoBackend",
    "kinematic": "handcart.backends.kinematic.kinematic_backend:KinematicBackend",
    "pybullet": "handcart.backends.pybullet.pybullet_backend:PyBulletBackend",
    "ros2": "handcart.backends.ros2.ros_backend:RosBackend",
}
"""Name to import path; other packages add theirs by an entry point of the group `handcart.backends`."""

ENTRY_POINT_GROUP = "handcart.backends"
DEFAULT_START = Pose2(0.0, 0.0, 0.0)
SEEDS = range(-(2**63), 2**63)
"""Seeds that a journal can hold: integers of 64 bits."""


class UnknownBackend(InputError, KeyError):
    """Error: no backend has the requested name."""

    def __init__(self, name: str) -> None:
        self.name = name
        super().__init__(f"unknown backend {name!r}{suggest(name, backend_names())}")

    def __str__(self) -> str:
        # KeyError shows its argument in quotes.
        return str(self.args[0])


class MissingLibrary(InputError):
    """Error: a Python package that a backend needs is not installed."""

    def __init__(self, backend: str, missing: ImportError) -> None:
        extra = extra_of(missing)
        install = f"'handcart[{extra}]'" if extra else "handcart"
        package = str(missing.name or missing)
        super().__init__(
            f"the backend {backend!r} needs the package {package!r}; install with: pip install {install}"
        )


@cache
def _all() -> dict[str, str]:
    return paths_of(ENTRY_POINT_GROUP, SHIPPED_BACKENDS)


def backend_names() -> list[str]:
    """Return the names of all backends, shipped ones and those of other packages."""
    return sorted(_all())


def make_backend(
    name: str,
    robot: RobotFile,
    world: Path | None,
    seed: int,
    start: Pose2 = DEFAULT_START,
    window: bool = False,
    bench: str | None = None,
    put_at_start: bool = False,
) -> Backend:
    """Build a backend with a robot and a world.

    Args:
        name: one of `backend_names()`.
        robot: robot file.
        world: a world's file, or a map in ROS format, whose occupied cells become the world.
        seed: seed of simulated errors.
        start: initial world_T_base in a map's world; a world's file has its own.
        window: True to show robot and world.
        bench: name of the simulated backend whose robot simulated drives move; None: no simulated drives.
        put_at_start: True to put the robot at `start` also in the world of a world's file.

    Raises:
        UnknownBackend: no backend has that name; the message lists the known ones.
        NotMovable: the backend cannot put the robot elsewhere than the world's file states.
        FileError: the world's file is missing or invalid.
        NoWindow: the backend has no window.
        NoBench: the backend has no drives, or `bench` is not a simulated backend.
        InputError: the seed has more than 64 bits.
    """
    check_seed(seed)
    kind = backend_class(name)
    build: Callable[..., Backend] = kind.build_in_window if window else kind.build
    if bench is not None:
        build = partial(kind.build_on_bench, bench=bench_class(bench, name))
    if world is None:
        return build(robot, None, seed)
    read = kind.read_world(world, start)
    if put_at_start:
        read = kind.with_start(read, start)
    if read is not None:
        return build(robot, read, seed)
    from .map_world import as_world_file

    with as_world_file(world, start) as file:
        return build(robot, file, seed)


def check_seed(seed: int, option: str = "seed") -> None:
    """Check that a journal can hold a seed.

    Raises:
        InputError: it has more than 64 bits; the message begins with `option`.
    """
    if not SEEDS.start <= seed < SEEDS.stop:  # `in` would walk through the range for a subclass of int
        raise InputError(f"{option} {seed}; allowed: {SEEDS.start} to {SEEDS.stop - 1}, integers of 64 bits")


def bench_class(name: str, drives: str) -> type[Backend]:
    """Return the class of a simulated backend whose robot can be moved by simulated drives.

    Args:
        name: name of the simulated backend.
        drives: name of the backend whose drives are simulated, such as `can`.

    Raises:
        NoBench: no backend has that name, it simulates no robot, or the backend `drives` has no drives.
    """
    if not backend_class(drives).has_drives:
        raise NoBench(f"the backend {drives!r} has no drives; allowed: --bench with --backend can or ros2")
    others = [backend_name for backend_name in backend_names() if backend_name != drives]
    if name not in (*others, drives):
        raise NoBench(f"unknown bench {name!r}{suggest(name, others)}")
    kind = backend_class(name)
    if kind.has_drives or not kind.simulated:
        raise NoBench(
            f"the backend {name!r} simulates no robot; allowed: --bench kinematic, mujoco, pybullet"
        )
    return kind


def check_world(
    world: Path, robot: RobotFile | None, initial_pose: Pose2 | None = None, grid: GridMap | None = None
) -> None:
    """Read a world's file and check it against the robot, without building a backend.

    Args:
        world: file of the world, or a map from which a world is made; a map is only read.
        robot: robot file; None to check the world's file alone.
        initial_pose: map_T_base that the program gives to the robot at the start; None if it gives no pose.
        grid: map that the program gives to the robot; None if it gives no map.

    Raises:
        FileError: lists all errors.
    """
    from handcart.files.maps.map_file import is_map_file, load_map

    if is_map_file(world):
        load_map(world)
        return
    loaded, whole = import_module("handcart.backends.simulation.world_files.load_world").read_world(world)
    find = import_module("handcart.backends.simulation.world_files.world_findings").world_findings
    if robot is None:
        return
    if wrong := list(find(loaded, whole, robot, initial_pose, grid)):
        raise FileError(wrong)


def backend_class(name: str) -> type[Backend]:
    """Return the class of a backend.

    Args:
        name: one of `backend_names()`.

    Raises:
        UnknownBackend: no backend has this name.
        BrokenPlugin: a backend of another package cannot be used.
        MissingLibrary: a package that the backend needs is not installed.
    """
    if name not in _all():
        raise UnknownBackend(name)
    check_name(name, ENTRY_POINT_GROUP, SHIPPED_BACKENDS)
    try:
        kind: type[Backend] = import_plugin(_all()[name], f"the backend {name!r}")
    except ModuleNotFoundError as missing:
        raise MissingLibrary(name, missing) from None
    return kind
