"""`handcart bench`: simulated drives, or topics, as a process of their own."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TextIO

import typer

if TYPE_CHECKING:
    import can

    from handcart.backends.can.bench.bench import Bench
    from handcart.backends.can.sensors.range_server import RangeServer
    from handcart.backends.description.can_spec import CanSpec

BETWEEN_PROCESSES, MULTICAST = "udp_multicast", "239.74.163.2"
DEFAULT_ROBOT = "cart"
AT_THE_PROGRAM = ("bus-down", "error-passive", "error-warning", "bus-off", "queue-full", "cable-off")
"""Faults of the interface in the program's own process, which a bench in another process cannot inject."""


def bench(
    robot: Annotated[
        str | None,
        typer.Argument(
            help="a shipped robot, or the path of a robot's file  [default: cart, or that of --task]",
            show_default=False,
        ),
    ] = None,
    interface: Annotated[
        str | None, typer.Option(help="of python-can  [default: udp_multicast]", show_default=False)
    ] = None,
    channel: Annotated[
        str | None,
        typer.Option(
            help="of the interface  [default: the file's, if it has that interface, otherwise 239.74.163.2]",
            show_default=False,
        ),
    ] = None,
    backend: Annotated[
        str | None, typer.Option(help="the simulated robot behind the drives (default: motors alone)")
    ] = None,
    world: Annotated[Path | None, typer.Option(help="world of the simulated robot")] = None,
    seed: Annotated[int, typer.Option(help="of the simulated errors")] = 0,
    faults: Annotated[
        list[str] | None,
        typer.Option(
            "--fault", help="NAME@SECONDS or NAME@SECONDS@NODE: an injected fault; --ros2: NAME@TOPIC@SECONDS"
        ),
    ] = None,
    range_port: Annotated[
        int | None, typer.Option(help="send the simulated robot's scans to clients of this port")
    ] = None,
    wrong: Annotated[
        list[str] | None,
        typer.Option("--wrong", help="with --ros2: NAME=FACTOR: the robot differs from its file"),
    ] = None,
    list_faults: Annotated[bool, typer.Option("--list-faults", help="list the possible faults")] = False,
    log: Annotated[
        Path | None, typer.Option(help="write time, positions, speeds and states of the drives into it")
    ] = None,
    seconds: Annotated[
        float | None, typer.Option(min=0.0, help="duration in s (default: until Ctrl-C)")
    ] = None,
    ros2: Annotated[
        bool, typer.Option("--ros2", help="simulate the topics of a robot's ROS 2 drivers instead")
    ] = False,
    task: Annotated[
        Path | None,
        typer.Option(help="with --ros2: a task's file, which names world, start, and robot if none is given"),
    ] = None,
) -> None:
    """Simulate a robot's CAN drives, or its ROS 2 drivers, in real time, until Ctrl-C."""
    drives_alone = {"--interface": interface, "--channel": channel, "--range-port": range_port, "--log": log}
    if ros2:
        from .ros_bench import RosBenchOptions, list_topic_faults, serve_topics

        _refuse(drives_alone, "with --ros2; allowed: without --ros2, for CAN drives")
        if task is not None:
            _refuse({"--world": world}, "with --task; allowed: one of them, as the task names its world")
        if list_faults:
            list_topic_faults()
            return
        serve_topics(
            RosBenchOptions(
                robot or (DEFAULT_ROBOT if task is None else None),
                backend or "kinematic",
                world,
                task,
                seed,
                tuple(faults or ()),
                seconds,
                tuple(wrong or ()),
            )
        )
        return
    if list_faults:
        _list_faults()
        return
    _refuse({"--task": task, "--wrong": wrong or None}, "without --ros2; allowed: with --ros2")
    if backend is None:
        _refuse({"--world": world}, "without --backend; needed: the simulated robot in that world")
    simulated = robot or DEFAULT_ROBOT
    _serve_drives(
        simulated, interface, channel, (backend, world, seed), faults or [], range_port, log, seconds
    )


def _refuse(options: Mapping[str, object], why: str) -> None:
    """Raise `typer.BadParameter` if one of the options is given, which would have no effect."""
    given = [name for name, value in options.items() if value is not None]
    if given:
        raise typer.BadParameter(f"{', '.join(given)} {why}")


def _serve_drives(
    robot: str,
    interface: str | None,
    channel: str | None,
    simulated: tuple[str | None, Path | None, int],
    faults: list[str],
    range_port: int | None,
    log: Path | None,
    seconds: float | None,
) -> None:
    """Serve simulated drives; `simulated` is the backend behind them, its world and its seed."""
    import time

    from handcart.backends.can.bench.bench import Bench
    from handcart.backends.can.bench.bench_server import BenchServer
    from handcart.backends.can.bench.injected_faults import inject
    from handcart.backends.can.bus.errors import NoDrives
    from handcart.backends.can.bus.open_bus import open_interface
    from handcart.backends.loading.robot_loading import load_robot
    from handcart.backends.registry import make_backend
    from handcart.tools.terminal.asked_to_end import AskedToEnd

    spec = load_robot(robot)
    if spec.can is None:
        raise NoDrives()
    planned = [_planned(fault, spec.can) for fault in faults]
    backend, world, seed = simulated
    interface = interface or BETWEEN_PROCESSES
    channel = channel or (spec.can.channel if spec.can.interface == interface else MULTICAST)
    looks: list[Callable[[Bench], None]] = []
    with ExitStack() as opened:
        with ExitStack() as parts:  # closed here unless the bench owns them
            inner = None if backend is None else make_backend(backend, spec, world or _library(), seed)
            if inner is not None:
                parts.callback(inner.close)
            bus = open_interface(interface, channel, 1000 * spec.can.bitrate_kbit_s)
            parts.callback(bus.shutdown)
            _check_free(bus, spec.can, interface, channel, robot)
            made = Bench(spec, spec.can, inner, bus)
            parts.pop_all()
        opened.callback(made.close)
        if range_port is not None:
            scans = _scans(made, range_port)
            opened.callback(scans.close)
            looks.append(lambda item: scans.send(item.time))
        for name, at, node in planned:
            inject(made, name, at, node)
        if log is not None:  # last: a bench that is refused leaves the log of another one as it is
            looks.append(_Log(opened.enter_context(_opened(log))))
        over, end = AskedToEnd(), None if seconds is None else time.monotonic() + seconds
        nodes = ", ".join(f"{name} {axis.node}" for name, axis in spec.can.axes())
        print(f"drives of {robot} on {interface} {channel}: {nodes}; Ctrl-C ends", flush=True)
        server = BenchServer(made, spec.period_s, look=lambda item: [look(item) for look in looks])
        server.serve(lambda: bool(over) or (end is not None and time.monotonic() >= end))


def _opened(log: Path) -> TextIO:
    from handcart.tools.terminal.writing import NotWritable

    try:
        return log.open("w", encoding="utf-8", buffering=1)
    except OSError as error:
        raise NotWritable(log, error.strerror) from None


def _check_free(bus: can.BusABC, spec: CanSpec, interface: str, channel: str, robot: str) -> None:
    """Raise `ChannelTaken` if another bench or robot is on the channel.

    Args:
        bus: open bus, without any of our nodes.
        spec: section `can` of the robot's file.
        interface: name of the python-can interface.
        channel: name of the channel.
        robot: name of the robot, from which another channel is proposed.
    """
    from handcart.backends.can.bus.channel_use import other_channel_hint, taken_by
    from handcart.backends.can.bus.errors import ChannelTaken

    nodes = {axis.node for _, axis in spec.axes()}
    by = taken_by(bus, nodes, is_shared=interface != BETWEEN_PROCESSES)
    if by:
        hint = other_channel_hint(interface, f"{robot} beside {channel}")
        raise ChannelTaken(interface, channel, by, hint)


def _scans(bench: Bench, port: int) -> RangeServer:
    from handcart.backends.can.sensors.range_server import RangeServer
    from handcart.backends.capabilities.range_sensor import RangeSensor
    from handcart.files.errors import InputError

    sensor = None if bench.inner is None else bench.inner.get(RangeSensor)  # type: ignore[type-abstract]
    if sensor is None:
        raise InputError(
            "--range-port without a simulated lidar; needed: --backend kinematic, and a robot with a lidar"
        )
    try:
        return RangeServer(sensor, port)
    except OSError as error:
        raise InputError(f"port {port} can't be listened on: {error.strerror}; allowed: a free one") from None


def _library() -> Path:
    from handcart.evaluation.trials.rig import LIBRARY_FOLDER

    return LIBRARY_FOLDER / "world.yaml"


def _planned(words: str, spec: CanSpec) -> tuple[str, float, int | None]:
    from handcart.backends.can.bench.injected_faults import injected_fault

    name, _, rest = words.partition("@")
    injected_fault(name)
    if name in AT_THE_PROGRAM:
        raise typer.BadParameter(f"{name!r} happens at the program's own interface; allowed: any other fault")
    at, _, node = rest.partition("@")
    try:
        begins, number = float(at or 0.0), int(node) if node else None
    except ValueError:
        begins, number = math.nan, None
    if not math.isfinite(begins):
        raise typer.BadParameter(f"{words!r} is not a fault; allowed: NAME@SECONDS or NAME@SECONDS@NODE")
    nodes = [axis.node for _, axis in spec.axes()]
    if number is not None and number not in nodes:
        raise typer.BadParameter(
            f"{words!r}: no drive has the node {number}; allowed: {', '.join(map(str, nodes))}"
        )
    return name, begins, number


def _list_faults() -> None:
    from handcart.backends.can.bench.injected_faults import INJECTED_FAULTS

    for name, fault in INJECTED_FAULTS.items():
        here = " (not in a process of its own)" if name in AT_THE_PROGRAM else ""
        print(f"{name:<18} {fault.rows:<9} {fault.what}{here}")


class _Log:
    """Log of monotonic time, bench time, and position, velocity and state of each drive, once a period."""

    def __init__(self, file: TextIO) -> None:
        self._file = file

    def __call__(self, bench: Bench) -> None:
        """Write a line after a period."""
        import time

        cells = [f"{time.monotonic():.6f}", f"{bench.time:.4f}"]
        for node, drive in bench.drives.items():
            cells.append(f"{node}:{drive.position:.1f}:{drive.velocity:.1f}:{drive.life.state}")
        print(",".join(cells), file=self._file)
