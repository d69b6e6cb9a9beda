"""Put unexpected frames on a robot's bus, and watch the program's errors and its drives."""

from __future__ import annotations

import random
import traceback
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass

import can
from typing_extensions import override

from handcart.backends.can.bench.bench import Bench
from handcart.backends.can.bench.bench_bus import BenchBus
from handcart.backends.can.bus.errors import CanFault
from handcart.backends.can.bus.frame_names import FrameNames
from handcart.backends.can.bus.frame_words import FrameWords
from handcart.backends.can.can_backend import CanBackend
from handcart.backends.can.drives.axis import ENABLED
from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.base import Base
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.loading.robot_loading import load_robot

BUS_PHASES = ("set-up", "enabling", "driving", "stop", "closing", "all")
"""When the bus is noisy."""
_LEVELS = (1, 10, 100)  # frames at most behind one of the program's
_ROBOTS = ("cart",) * 19 + ("librarian",)
_PERIODS = 12  # that are driven
_AFTER = 1.0  # [s] in which nothing moves any more
_COMMANDS = (0x200, 0x300, 0x400, 0x500, 0x600)  # to a drive: RPDOs and SDO requests (CiA 301)
_ANSWERS = (0x080, 0x180, 0x280, 0x580, 0x700)  # of a drive
_KEPT = 200  # frames of the real traffic that are remembered


@dataclass(frozen=True)
class Attack:
    """Result of one noisy bus."""

    number: int
    phase: str
    frames: int
    """Number of unexpected frames that were received."""
    fault: str
    """Message of the program's fault; "" if it ran to its end."""
    wrong: str
    """Violation: an error other than `CanFault`, or a drive that keeps its torque; empty without one."""


class Noise:
    """Random frames, and what becomes of real ones."""

    def __init__(self, rng: random.Random, nodes: list[int]) -> None:
        """Make noise for drives with these node IDs."""
        self._rng, self._nodes = rng, nodes
        self._heard: deque[can.Message] = deque(maxlen=_KEPT)

    def note(self, frame: can.Message) -> None:
        """Note a real frame."""
        self._heard.append(frame)

    def frame(self) -> can.Message:
        """Return the next one."""
        kinds = (self._any, self._aimed, self._aimed, self._damaged, self._damaged, self._odd)
        return self._rng.choice(kinds)()

    def _any(self) -> can.Message:
        return self._plain(self._rng.randrange(0x800), self._rng.randbytes(self._rng.randrange(9)))

    def _aimed(self) -> can.Message:
        """Return a frame that looks as if a drive had sent it."""
        can_id = self._rng.choice(_ANSWERS) + self._rng.choice(self._nodes)
        return self._plain(can_id, self._rng.randbytes(self._rng.choice((0, 1, 1, 2, 4, 6, 8, 8))))

    def _damaged(self) -> can.Message:
        """Return a real one: as it was, with bits flipped, cut off, of another length, of another node."""
        if not self._heard:
            return self._any()
        real = self._rng.choice(self._heard)
        can_id, data = real.arbitration_id, bytearray(real.data)
        match self._rng.randrange(5):
            case 0 if data:
                data[self._rng.randrange(len(data))] ^= 1 << self._rng.randrange(8)
            case 1:
                del data[self._rng.randrange(len(data) + 1) :]
            case 2:
                data = (data + self._rng.randbytes(8))[: self._rng.randrange(9)]
            case 3:
                can_id = can_id & ~0x7F | self._rng.choice(self._nodes)
        return self._plain(can_id, bytes(data))

    def _odd(self) -> can.Message:
        """Remote, extended, FD and error frames."""
        rng, can_id = self._rng, self._rng.randrange(0x800)
        match rng.randrange(8):
            case 0:
                return can.Message(
                    arbitration_id=1 << rng.randrange(9), data=rng.randbytes(8), is_error_frame=True
                )
            case 1 | 2:
                wide = rng.randrange(1 << 29)
                return can.Message(arbitration_id=wide, data=rng.randbytes(8), is_extended_id=True)
            case 3 | 4:
                data = rng.randbytes(rng.choice((0, 3, 8, 12, 64)))
                return can.Message(arbitration_id=can_id, data=data, is_fd=True, is_extended_id=False)
            case _:
                length = rng.randrange(9)
                return can.Message(
                    arbitration_id=can_id, dlc=length, is_remote_frame=True, is_extended_id=False
                )

    @staticmethod
    def _plain(can_id: int, data: bytes) -> can.Message:
        return can.Message(arbitration_id=can_id, data=data, is_extended_id=False)


class NoisyBus(can.BusABC):
    """The program's end of a bench's bus, on which others talk."""

    def __init__(self, bus: BenchBus, noise: Noise, rng: random.Random, nodes: list[int]) -> None:
        """Take over an open bus; closed by `shutdown`."""
        self._inner, self._noise, self._rng = bus, noise, rng
        self._commands = {0x000, 0x080, *(first + node for first in _COMMANDS for node in nodes)}
        self._due = 0
        self._words = FrameWords(FrameNames(time="robot", nodes={}, pdos={}))
        self.level = 0
        """Frames at most behind one that the program sends; 0: it is quiet."""
        self.frames = 0
        """Number of unexpected frames that were received."""
        self.channel_info = bus.channel_info
        super().__init__(channel=bus.channel_info)

    @property
    def state(self) -> can.BusState:
        """See python-can."""
        return self._inner.state

    @state.setter
    def state(self, new_state: can.BusState) -> None:
        self._inner.state = new_state

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """See python-can."""
        self._inner.send(msg, timeout)
        self._noise.note(msg)
        if self.level and self._rng.random() < 0.5:
            self._due += self._rng.randint(1, self.level)

    def flush_tx_buffer(self) -> None:
        """See python-can."""
        self._inner.flush_tx_buffer()

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        if self._due and self.level and self._rng.random() < 0.5:
            return self._shouted(), True
        frame = self._inner.recv(timeout)
        if frame is None:
            return (self._shouted() if self._due and self.level else None), True
        self._noise.note(frame)
        return frame, True

    def _shouted(self) -> can.Message:
        """Return an unexpected frame; drives receive it too, unless it commands them: they would obey."""
        self._due, self.frames = self._due - 1, self.frames + 1
        frame = self._noise.frame()
        self._words.describe(frame)
        if not frame.is_error_frame and frame.arbitration_id not in self._commands:
            self._inner.send(frame)
        return frame

    def shutdown(self) -> None:
        """See python-can."""
        super().shutdown()
        self._inner.shutdown()


class NoisyBench(Bench):
    """A bench on whose bus others talk."""

    def __init__(self, robot: RobotFile, rng: random.Random) -> None:
        assert robot.can is not None
        super().__init__(robot, robot.can, None)
        self._rng = rng
        self.bus: NoisyBus | None = None

    @override
    def open(self) -> NoisyBus:  # type: ignore[override]
        nodes = list(self.drives)
        self.bus = NoisyBus(super().open(), Noise(self._rng, nodes), self._rng, nodes)
        return self.bus


def attacks(setups: int, frames: int, seed: int = 0) -> Iterator[Attack]:
    """Attack robots on benches until there have been so many set-ups, and so many frames.

    Args:
        setups: at least.
        frames: at least.
        seed: the same one gives the same frames.
    """
    robots = {name: load_robot(name) for name in _ROBOTS}
    number = 0
    while number < setups or frames > 0:
        rng = random.Random(f"{seed}/{number}")
        attack = _Attacked(number, robots[rng.choice(_ROBOTS)], rng).run()
        frames -= attack.frames
        yield attack
        number += 1


class _Attacked:
    """One robot from set-up to closing."""

    def __init__(self, number: int, robot: RobotFile, rng: random.Random) -> None:
        self._number, self._phase = number, BUS_PHASES[number % len(BUS_PHASES)]
        self._rng, self._robot = rng, robot
        self._level = rng.choice(_LEVELS)
        self._bench = NoisyBench(robot, rng)
        self._bench_open = True
        self._wrong: list[str] = []

    def run(self) -> Attack:
        fault = ""
        try:
            self._go()
        except CanFault as error:
            fault = str(error)
        except Exception:
            self._wrong.append(traceback.format_exc())
        finally:
            self._bench.close()
        self._look("at the end")
        bus = self._bench.bus
        frames = bus.frames if bus else 0
        return Attack(self._number, self._phase, frames, fault, "\n".join(self._wrong))

    def _noisy(self, phase: str) -> None:
        if self._bench.bus is not None:
            self._bench.bus.level = self._level if self._phase in (phase, "all") else 0

    def _go(self) -> None:
        bench, level = self._bench, self._level
        if self._phase in ("set-up", "all"):
            opened = bench.open

            def loud() -> NoisyBus:
                bus = opened()
                bus.level = level
                return bus

            bench.open = loud  # type: ignore[method-assign]
        backend = CanBackend(self._robot, bench)
        try:
            self._use(backend)
        except CanFault as fault:
            self._after(backend, fault)
            raise
        finally:
            self._noisy("closing")
            backend.close()

    def _use(self, backend: CanBackend) -> None:
        self._noisy("enabling")
        backend.enable()
        self._noisy("driving")
        base, arm = backend.get(Base), backend.get(Arm)  # type: ignore[type-abstract]
        assert base is not None
        for _ in range(_PERIODS):
            base.drive(0.4, self._rng.uniform(-0.5, 0.5))
            if arm is not None:
                arm.move(arm.command() + 0.005)
            backend.step()
        self._noisy("stop")
        backend.stop()
        for _ in range(_PERIODS):
            backend.step()

    def _after(self, backend: CanBackend, fault: CanFault) -> None:
        """Check that the backend stays stopped after the fault, by the drives' own state."""
        self._look("after the fault")
        self._noisy("")
        drives = self._bench.drives.values()
        there = [drive.position for drive in drives]
        try:
            backend.step()
            self._wrong.append("a step after the fault")
        except CanFault as again:
            if again is not fault:
                self._wrong.append(f"another fault: {again}")
        for _ in range(round(_AFTER / backend.period)):
            self._bench.serve()
            self._bench.tick(backend.period)
        if [drive.position for drive in drives] != there:
            self._wrong.append("something moved after the fault")
        self._look("a second later")

    def _look(self, when: str) -> None:
        for drive in self._bench.drives.values():
            if drive.life.state == ENABLED:
                self._wrong.append(f"node {drive.number} is in {ENABLED} {when}")
