"""Tracking a seam while the base drives along it: what TRACK does not do, for comparison.

Shin et al. (2005), figure 5, compare a standing base with one that moves. A moving base strays: its error
is an Ornstein-Uhlenbeck process, smoothed, along both axes and about the vertical. The arm knows of it
nothing (open loop), or what the positioning tells (base feedback).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.linalg import expm, solve_discrete_are
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation, Slerp

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.simulation.body.simulated_parts import ArmError
from handcart.primitives.motions.working_arm import working_arm
from handcart.primitives.seam.seam_placer import work_of
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import inverse
from handcart.robotics.manipulation.placement.placer import Placer
from handcart.robotics.manipulation.tracking.tool_path import ToolPath

DISTANCE = 1.0  # [m] from the base's way to the seam
AHEAD = 0.35  # [m] by which the base stays behind the tool
STEP = 0.005  # [s] of the simulation

Floats = NDArray[np.float64]


class Straying(NamedTuple):
    """How a moving base strays from where it should be."""

    position: float = 0.005
    """Sigma along each axis, in [m]."""
    heading: float = np.radians(0.4)
    """Sigma, in [rad]."""
    tau: float = 1.5
    """[s] after which it has forgotten where it was."""
    smooth: float = 0.15
    """[s]: it has mass."""


class Feedback(NamedTuple):
    """What the arm does about it."""

    bandwidth: float
    """Of the arm, in [Hz]."""
    latency: float
    """From the measurement to the arm's command, in [s]."""
    rate: float
    """Of measurements and commands, in [Hz]."""
    ahead: bool = True
    """Whether readings are carried on by what the base was seen to do, and commands make up for the lag."""


class MovingRun(NamedTuple):
    """One run."""

    times: Floats
    """(k,) in [s]."""
    errors: Floats
    """(k,): the tool's distance from where it should be then, in [m]."""
    speed_use: float
    """Largest joint speed as a share of its limit."""


class MovingTracking:
    """A robot whose base drives along a seam at the tool's speed."""

    def __init__(self, spec: RobotFile, seam: ToolPath, straying: Straying = Straying()) -> None:
        """Plan it once.

        Args:
            spec: of the robot; its arm reaches to its left.
            seam: it runs roughly straight, seen from above, and the tool points to its left.
            straying: of the base.
        """
        self._spec, self._straying, self._arm = spec, straying, working_arm(spec)
        work = work_of(spec)
        self._placer = Placer(self._arm, work)
        self._times = np.arange(0.0, seam.length / work.speed, STEP)
        self._tools = _sampled(seam, work.speed * self._times)
        self._ways = _abreast(self._tools[:, :3, 3])
        self._near = self._placer.joints(self._ways[0], seam.part(0, 1))[0]

    def run(self, seed: int, feedback: Feedback | None = None) -> MovingRun:
        """Drive and track once; None: open loop."""
        rng = np.random.default_rng(seed)
        strays = self._strayed(rng)
        commanded = plain = self._angles(np.zeros_like(strays))
        if feedback is not None:
            corrected = self._angles(self._known(strays, feedback, rng))
            commanded = plain + _lagged(corrected - plain, feedback.bandwidth)
        error = ArmError(self._spec.errors, self._arm, seed)
        tips = np.empty((len(commanded), 3))
        for index, (q, way, stray) in enumerate(zip(commanded, self._ways, strays, strict=True)):
            tips[index] = (_base(way, stray) @ self._arm.forward(q + error.offset(q, 0)))[:3, 3]
        off = np.linalg.norm(tips - self._tools[:, :3, 3], axis=1)
        speeds = np.abs(np.diff(commanded, axis=0)) / STEP / self._arm.velocity
        return MovingRun(self._times, off, float(speeds.max()))

    def _strayed(self, rng: np.random.Generator) -> Floats:
        """(k, 3): where the base is, seen from where it should be, in [m] and [rad]."""
        way, count = self._straying, len(self._times)
        start = int(5.0 * way.tau / STEP)  # until it has forgotten that it began in its place
        keep, forget = np.exp(-STEP / way.tau), 1.0 - np.exp(-STEP / way.smooth)
        noise = rng.standard_normal((start + count, 3)) * np.sqrt(1.0 - keep**2)
        raw = lfilter([1.0], [1.0, -keep], noise, axis=0)
        smooth = lfilter([forget], [1.0, forget - 1.0], raw, axis=0)
        # Smoothing takes some of the variance away: tau / (tau + smooth) is left.
        scale = np.sqrt((way.tau + way.smooth) / way.tau)
        return np.asarray(scale * smooth[start:] * (way.position, way.position, way.heading))

    def _known(self, strays: Floats, feedback: Feedback, rng: np.random.Generator) -> Floats:
        """(k, 3): where the arm is told at each instant that the base is, held between readings.

        Where readings are carried on, more is told than is wanted, as much as the arm's lag takes away of it
        until the next command.
        """
        system = self._spec.positioning
        assert system is not None, "base feedback comes from the positioning"
        sigma = np.array([system.sigma_mm, system.sigma_mm, system.heading_sigma_mrad]) / 1e3
        every, late = round(1.0 / feedback.rate / STEP), round(feedback.latency / STEP)
        ahead = (late + every - 1) * STEP if feedback.ahead else 0.0
        # It was seen before it set out.
        observer = _Observer(self._straying, every * STEP, ahead, sigma, strays[0])
        corrected, done = np.tile(strays[0], (len(strays), 1)), strays[0]
        left = _left(feedback.bandwidth) ** every if feedback.ahead else 0.0
        for index in range(0, len(strays), every):
            observer.see(strays[index] + sigma * rng.standard_normal(3))
            wanted = observer.ahead()
            corrected[index + late : index + late + every] = (wanted - left * done) / (1.0 - left)
            done = wanted
        return corrected

    def _angles(self, strays: Floats) -> Floats:
        """(k, n): joint angles that keep the tool on the seam, the base where it is believed to be."""
        found = np.empty((len(strays), self._arm.dof))
        found[0] = self._near
        bases = [_base(way, stray) for way, stray in zip(self._ways, strays, strict=True)]
        tools = np.array([inverse(base) @ tool for base, tool in zip(bases, self._tools, strict=True)])
        nothing = np.zeros((len(tools), 3))
        path = ToolPath(tools[:, :3, 3], tools[:, :3, :3], nothing, nothing, self._times)
        return self._placer.follower.joints(path, np.eye(4), self._near)


class _Observer:
    """Kalman filters for x, y and heading that know how a base strays: where it is drawn to, where it is."""

    def __init__(self, straying: Straying, period: float, ahead: float, sigma: Floats, start: Floats) -> None:
        """Filters that have run for long.

        Args:
            straying: of the base.
            period: of the readings, in [s].
            ahead: by how much the straying is wanted in advance, in [s].
            sigma: (3,) of the readings, in [m] and [rad].
            start: (3,) where the base is at first.
        """
        tau, smooth = straying.tau, straying.smooth
        self._flow = np.array([[-1.0 / tau, 0.0], [1.0 / smooth, -1.0 / smooth]])
        self._step, self._ahead = expm(self._flow * period), expm(self._flow * ahead)
        sizes = np.array([straying.position, straying.position, straying.heading])
        sizes = sizes * np.sqrt((tau + smooth) / tau)
        pairs = zip(sizes.tolist(), sigma.tolist(), strict=True)
        gains = [self._gain(period, size, max(each, 1e-6)) for size, each in pairs]
        self._gains, self._state = np.column_stack(gains), np.vstack((start, start))

    def see(self, reading: Floats) -> None:
        """Take a reading (3,) in."""
        self._state = self._step @ self._state
        self._state = self._state + self._gains * (reading - self._state[1])

    def ahead(self) -> Floats:
        """The straying (3,) in advance, in [m] and [rad]."""
        return np.asarray((self._ahead @ self._state)[1])

    def _gain(self, period: float, size: float, sigma: float) -> Floats:
        """(2,): of a filter that has run for long."""
        full = np.zeros((4, 4))  # Van Loan (1978): what white noise adds in a period
        full[:2, :2], full[2:, 2:] = -self._flow, self._flow.T
        full[0, 2] = -2.0 * size**2 * self._flow[0, 0]
        block = expm(full * period)
        pushed = block[2:, 2:].T @ block[:2, 2:]
        noise = np.array([[max(sigma, _EXACT) ** 2]])
        spread = solve_discrete_are(self._step.T, np.array([[0.0], [1.0]]), 0.5 * (pushed + pushed.T), noise)
        return np.asarray(spread[:, 1] / (spread[1, 1] + noise[0, 0]))


_EXACT = 1e-6  # [m], [rad]: no reading is more so


def _sampled(seam: ToolPath, lengths: Floats) -> Floats:
    """(k, 4, 4): world_T_tool at arc lengths (k,)."""
    poses = np.tile(np.eye(4), (len(lengths), 1, 1))
    poses[:, :3, 3] = CubicSpline(seam.lengths, seam.points)(lengths)
    poses[:, :3, :3] = Slerp(seam.lengths, Rotation.from_matrix(seam.rotations))(lengths).as_matrix()
    return poses


def _abreast(points: Floats) -> Floats:
    """(k, 3): base poses on a straight line beside tool positions (k, 3), which are to its left."""
    way = points[-1, :2] - points[0, :2]
    along = way / np.linalg.norm(way)
    left = np.array([-along[1], along[0]])
    aside = float(np.mean(points[:, :2] @ left)) - DISTANCE
    spots = (points[:, :2] @ along)[:, None] * along + aside * left
    return np.column_stack((spots - AHEAD * along, np.full(len(spots), np.arctan2(along[1], along[0]))))


def _base(way: Floats, stray: Floats) -> Floats:
    """world_T_base (4, 4)."""
    return Pose2(*way.tolist()).compose(Pose2(*stray.tolist())).lift()


def _left(bandwidth: float) -> float:
    """Share of a step that is still to come after `STEP`, for a bandwidth in [Hz]."""
    return float(np.exp(-2.0 * np.pi * bandwidth * STEP))


def _lagged(values: Floats, bandwidth: float) -> Floats:
    """(k, n) through a lag of first order, in [Hz]."""
    share = 1.0 - _left(bandwidth)
    start = (1.0 - share) * values[:1]  # at rest at its first value
    return np.asarray(lfilter([share], [1.0, share - 1.0], values, axis=0, zi=start)[0])
