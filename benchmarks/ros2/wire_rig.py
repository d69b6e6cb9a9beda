"""Processes on both sides of the middleware: a bench with the cart, and a program that drives circles."""

from __future__ import annotations

import ctypes
import fcntl
import importlib
import importlib.util
import multiprocessing
import os
import signal
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

from handcart.backends.backend import Backend, RobotFault
from handcart.backends.capabilities.base import Base
from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.description.ros_spec import RosLidarSpec, RosOdometrySpec, RosSpec
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.registry import make_backend
from handcart.backends.ros2.bench.bench_faults import BenchFaults, TopicFault
from handcart.backends.ros2.bench.ros_bench import RosBench
from handcart.backends.ros2.ros_backend import RosBackend
from handcart.backends.ros2.wire.ros_link import RosLink, node_name
from handcart.backends.ros2.wire.transports import TRANSPORTS
from handcart.evaluation.trials.rig import LIBRARY_FOLDER
from handcart.files.errors import HandcartError

from .judged import Lateness, LoopWatch, most_late

FORK_CONTEXT = multiprocessing.get_context("fork")
DRIVE_SPEED_M_S, DRIVE_TURN_RAD_S = 0.1, 0.5
FIRST_PERIODS = 10
"""Periods after which a program drives: in the first ones functions are loaded."""
ANSWER_S = 60.0
"""[s] in which a process has to answer; the machine may be busy."""
FIRST_DOMAIN, DOMAINS = 30, 60
LOCKS_FOLDER = Path(tempfile.gettempdir())
END_WITH_PARENT = 1
"""Option `PR_SET_PDEATHSIG` of Linux' `prctl`."""
DROVE_TO_END = "drove to its end"
"""Words of a program that nothing stopped."""
Pipe = Any


class Ended(NamedTuple):
    """End of the driving program."""

    time: float
    """Time of the end by the monotonic clock, in [s]."""
    words: str
    figures: dict[str, Any]


class Rest(NamedTuple):
    """When the base of the bench came to rest after an instant."""

    seconds: float
    """Duration by the wall clock, in [s]."""
    periods: int
    """Number of periods of the bench in which it still moved; a busy machine stretches periods, not this."""


class Process:
    """A forked process with a pipe to it; it is killed when this one ends, however that ends."""

    def __init__(self, work: Callable[..., None], *words: Any) -> None:
        """Run `work` with a pipe and `words`."""
        self.pipe, other = FORK_CONTEXT.Pipe()
        # Without a lock: a process that is killed while it writes would keep it for ever.
        self._late = FORK_CONTEXT.Array("d", Lateness(), lock=False)
        self._process = FORK_CONTEXT.Process(
            target=_work_as_child, args=(os.getpid(), self._late, work, other, *words), daemon=True
        )
        self._process.start()
        other.close()
        for watching in Watched.open:
            watching.processes.append(self)

    @property
    def late(self) -> Lateness:
        """Time by which a period of its loop was too long, at most so far; 0 without a loop."""
        machine, own, is_split = self._late
        return Lateness(machine, own, bool(is_split))

    def kill(self) -> float:
        """Kill it (SIGKILL); return the time in [s]."""
        self._process.kill()
        now = time.monotonic()
        self._process.join()
        return now

    def answer(self, seconds: float = ANSWER_S) -> Any:
        """Return its next message.

        Raises:
            TimeoutError: none has come.
        """
        if not self.pipe.poll(seconds):
            raise TimeoutError(f"no answer within {seconds:g} s")
        try:
            return self.pipe.recv()
        except EOFError:
            self._process.join()
            raise TimeoutError(f"the process died with status {self._process.exitcode}") from None


def _work_as_child(parent: int, late: Any, work: Callable[..., None], *words: Any) -> None:
    """Do the work of a child that the kernel kills with its parent: else one would spin on for ever."""
    ctypes.CDLL(None, use_errno=True).prctl(END_WITH_PARENT, signal.SIGKILL)
    if os.getppid() != parent:  # it has ended before
        return
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches it, too: its parent decides
    LoopWatch.shared = late
    work(*words)


def warm_up() -> None:
    """Load in this process what each forked one needs: a trial then costs half of the CPU time."""
    link_modules = ("rclpy.executors", "nav_msgs.msg", "sensor_msgs.msg", "geometry_msgs.msg")
    for module in filter(lambda name: importlib.util.find_spec(name.partition(".")[0]), link_modules):
        importlib.import_module(module)
    bench = make_backend("kinematic", cart(1000.0), LIBRARY_FOLDER / "world.yaml", 0)
    with RosBackend.build_on_bench(cart(1000.0), LIBRARY_FOLDER / "world.yaml", 0, type(bench)) as backend:
        base, lidar = backend.get(Base), backend.get(RangeSensor)  # type: ignore[type-abstract]
        assert base is not None and lidar is not None
        for _ in range(FIRST_PERIODS):
            base.drive(DRIVE_SPEED_M_S, DRIVE_TURN_RAD_S)
            backend.step()
            lidar.scan()
    bench.close()


def await_driving(driver: Process) -> None:
    """Wait until a program of `drive_circles` drives.

    Raises:
        TimeoutError: it does not, or has ended before.
    """
    said = driver.answer()
    if isinstance(said, Ended):
        raise TimeoutError(f"it ended before anything went wrong: {said.words}")


class Watched:
    """Processes of a trial."""

    open: ClassVar[list[Watched]] = []
    """Those of the trials under way."""

    def __init__(self) -> None:
        """Begin without a process."""
        self.processes: list[Process] = []

    @property
    def late(self) -> Lateness:
        """Time by which a period of any of them was too long, at most."""
        return most_late([process.late for process in self.processes])


@contextmanager
def watching() -> Iterator[Watched]:
    """Watch the loops of all processes that are started inside."""
    watched = Watched()
    Watched.open.append(watched)
    try:
        yield watched
    finally:
        Watched.open.remove(watched)


@contextmanager
def on_the_air(trial: int) -> Iterator[None]:
    """Give the processes that are forked inside a ROS domain of their own on this machine.

    A domain that another benchmark uses at the same time is passed over.
    """
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    with ExitStack() as kept:
        for number in range(trial, trial + DOMAINS):
            domain = FIRST_DOMAIN + number % DOMAINS
            file = kept.enter_context((LOCKS_FOLDER / f"handcart-domain-{domain}-{os.getuid()}").open("w"))
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                continue
            kept.callback(fcntl.flock, file, fcntl.LOCK_UN)  # forked processes have the file as well
            os.environ["ROS_DOMAIN_ID"] = str(domain)
            yield
            return
    raise RuntimeError(f"{DOMAINS} benchmarks use all ROS domains from {FIRST_DOMAIN}; needed: a free one")


def cart(max_late_ms: float, first_message_s: float = 30.0, stale_ms: float | None = None) -> RobotFile:
    """Return the cart with topics of the usual names; times in [ms] and [s].

    `stale_ms` is the age in [ms] beyond which readings are stale; None: the usual ages.
    """
    robot = load_robot("cart")
    topics: dict[str, Any] = {}
    if stale_ms is not None:
        topics = {"odometry": RosOdometrySpec(stale_ms=stale_ms), "lidar": RosLidarSpec(stale_ms=stale_ms)}
        topics["max_missed_periods"] = 100
    spec = RosSpec(first_message_s=first_message_s, max_late_ms=max_late_ms, **topics)
    return robot.model_copy(update={"ros2": spec}).read_in(robot.folder)


def serve_bench(pipe: Connection) -> None:
    """Serve the cart's topics until killed.

    A received `TopicFault` begins at once. A received time, in [s] of the monotonic clock, is answered by
    the `Rest` of the base after it.
    """
    robot = cart(1000.0)
    inner = make_backend("kinematic", robot, LIBRARY_FOLDER / "world.yaml", 0)

    def moves(bench: RosBench) -> bool:
        return bool(bench.speeds.speed or bench.speeds.turn_rate)

    serve(pipe, robot, inner, moves)


def serve(pipe: Connection, robot: RobotFile, inner: Backend, moves: Callable[[RosBench], bool]) -> None:
    """Serve a robot's topics and actions until killed; answer as `serve_bench` does.

    Args:
        pipe: to the program that sends faults and times.
        robot: with a section `ros2`.
        inner: simulated robot behind the bench.
        moves: returns whether what is watched has moved in the bench's last period.
    """
    assert robot.ros2 is not None
    os.environ[TRANSPORTS] = "DEFAULT"  # with shared memory, as a robot's drivers have it
    faults = BenchFaults(robot.period_s)
    bench = RosBench(robot, robot.ros2, inner, RosLink(node_name("bench")), faults)
    moved: list[tuple[float, bool]] = []
    due = time.monotonic()
    pipe.send("ready")
    watch = LoopWatch(robot.period_s, FIRST_PERIODS)
    while True:
        bench.step()
        watch.note()
        moved.append((time.monotonic(), moves(bench)))
        while pipe.poll():
            asked = pipe.recv()
            if isinstance(asked, TopicFault):
                faults.add(asked)
            else:
                late = [at for at, moving in moved if moving and at > asked]
                pipe.send(Rest(max(late, default=asked) - asked, len(late)))
        due = max(due + robot.period_s, time.monotonic() - robot.period_s)
        time.sleep(max(0.0, due - time.monotonic()))


def drive_circles(
    pipe: Connection, seconds: float, first_message_s: float = 30.0, stale_ms: float | None = None
) -> None:
    """Drive in circles and read the lidar each period; send "drives", then how it ended.

    Any message ends it early. See `cart` for `stale_ms`.
    """
    words, figures, ended = DROVE_TO_END, dict[str, Any](), 0.0
    try:
        with RosBackend(cart(1000.0, first_message_s, stale_ms)) as backend:
            base, lidar = backend.get(Base), backend.get(RangeSensor)  # type: ignore[type-abstract]
            assert base is not None and lidar is not None
            watch = LoopWatch(backend.period, FIRST_PERIODS + 1)
            try:
                for period in range(round(seconds / backend.period)):
                    base.drive(DRIVE_SPEED_M_S, DRIVE_TURN_RAD_S)
                    backend.step()
                    lidar.scan()
                    base.wheel_travel()
                    if period == FIRST_PERIODS:
                        pipe.send("drives")
                    watch.note()
                    if pipe.poll():  # asked to end
                        words = "cut off"
                        break
            finally:
                watch.note()
                ended, figures = time.monotonic(), {**backend.figures(), "too long": watch.figures()}
    except (RobotFault, HandcartError) as error:
        words = str(error)
    # Leaving the air takes a moment more, up to 2 s where the other side was killed.
    pipe.send(Ended(ended or time.monotonic(), words, figures))
