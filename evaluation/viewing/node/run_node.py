"""A run as a node of ROS 2."""

from __future__ import annotations

import threading
import time as clock
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import orjson
from typing_extensions import override

from handcart.backends.robot.robot import Robot
from handcart.backends.ros2.wire.serving_link import DIAGNOSTICS_TOPIC, ServingLink
from handcart.files.errors import InputError
from handcart.networks.events.events import Ended, Event, Planned, Restoring, RunEnded, Started
from handcart.networks.events.run_observer import RunObserver
from handcart.primitives.outcomes.outcome import Success
from handcart.robotics.geometry.pose2 import Pose2

from .diagnostics import diagnostics_message, summary_of
from .door import SERVICE_PREFIX, Door
from .map_message import map_message
from .marker_messages import MARKERS_KIND, marker_array, path_message, pose_message
from .seen_state import SeenState, action_state, seen_state

if TYPE_CHECKING:
    from handcart.networks.task.preparing import Prepared

PUBLISH_PERIOD_S = 0.2
DIAGNOSTICS_PERIOD_S = 1.0
MAX_SLEEP_S = 1.0
LAST_WORDS_S = 0.5
"""Time for which the node stays after the run's end, in [s], so that last messages and answers arrive."""
STEP_M = 0.03
LOOK_PERIOD_S = 0.1
STOP_SERVICE = f"{SERVICE_PREFIX}/stop"
MESSAGE_KINDS = {
    "status": "std_msgs/String",
    "situation": "std_msgs/String",
    "action": "std_msgs/String",
    "markers": MARKERS_KIND,
    "pose": "geometry_msgs/PoseWithCovarianceStamped",
    "path": "nav_msgs/Path",
    "map": "nav_msgs/OccupancyGrid",
}


class SecondNode(InputError):
    """Error for a second run with a node in the same ROS network, where a command could reach either run."""


class RunNode(RunObserver):
    """Observer that publishes a run's state in ROS 2 and offers the operator's commands as services.

    It works in its own thread on data copied between two periods; its errors never change the run. A
    simulated run is slowed down to real time, as with `--view`; a run of a real robot is never slowed down.
    """

    def __init__(
        self,
        link: ServingLink,
        say: Callable[[str], None] = lambda _: None,
        now: Callable[[], float] = clock.monotonic,
        sleep: Callable[[float], None] = clock.sleep,
    ) -> None:
        """Publish over a link, which this observer closes.

        Args:
            link: to ROS 2.
            say: receives messages about problems of the node.
            now: gives a wall time in [s].
            sleep: waits so many seconds.
        """
        self._link, self._say, self._now, self._sleep = link, say, now, sleep
        self._publishers = {
            name: link.latched(kind, f"{SERVICE_PREFIX}/{name}") for name, kind in MESSAGE_KINDS.items()
        }
        self._publishers["diagnostics"] = link.latched("diagnostic_msgs/DiagnosticArray", DIAGNOSTICS_TOPIC)
        self._wanted, self._over, self._ended = threading.Event(), threading.Event(), threading.Event()
        self._seen: SeenState | None = None
        self._action: dict[str, Any] = {}
        self._residuals, self._situation = "", ""
        self._end: dict[str, Any] = {}
        self._evidence: Mapping[str, Any] = {}
        self._driven: list[Pose2] = []
        self._snapshot: Pose2 | None = None
        self._since: tuple[float, float] | None = None
        self._last: dict[str, Any] = {}
        self._thread: threading.Thread | None = None
        self._door: Door | None = None

    @override
    def begin(self, prepared: Prepared, run_dir: Path) -> None:
        self._head = {"task": prepared.task.file.title, "run": str(run_dir)}
        self._hardware, self._situation = str(prepared.task.robot), prepared.task.network.start
        self._robot = prepared.robot
        if prepared.backend.simulated:
            self._since = self._now(), prepared.robot.time
        self._door = Door(run_dir, self._ended)
        self._door.offer(self._link)
        if prepared.model.map is not None:
            self._publishers["map"](map_message(self._link, prepared.model.map))
        self._take(prepared.robot)
        self._thread = threading.Thread(target=self._serve, name="ros node", daemon=True)
        self._thread.start()

    @override
    def period(self, robot: Robot) -> None:
        if not self._driven or _apart(robot.pose, self._driven[-1]) >= STEP_M:
            self._driven.append(robot.pose)
        if self._wanted.is_set():
            self._take(robot)
        if self._since is not None:
            wall, time = self._since
            ahead = (robot.time - time) - (self._now() - wall)
            if ahead > 0.0:
                self._sleep(min(ahead, MAX_SLEEP_S))
            else:
                self._since = self._now(), robot.time

    @override
    def event(self, event: Event) -> None:
        match event:
            case Planned(situation=situation):
                self._situation = situation
            case Started(_, number, action, primitive, fails):
                self._action = action_state(number, action, fails)
                self._snapshot, self._driven, self._residuals = self._robot.pose, [self._robot.pose], ""
                self._evidence, self._situation = primitive.evidence.points, action.source
            case Restoring(reason=reason):
                self._action = {**self._action, "state": "restoring", "reason": reason}
            case Ended(action=action, outcome=outcome):
                ended = {"state": "ended", "outcome": type(outcome).__name__}
                if isinstance(outcome, Success):
                    self._situation = action.target
                else:
                    self._residuals = outcome.residuals.words_with_limits
                    ended |= {"reason": outcome.reason, "residuals": self._residuals}
                self._action = {**self._action, **ended}
            case RunEnded(end=end):
                self._situation = end.situation
                if self._action.get("state") in ("running", "restoring"):
                    self._action = {**self._action, "state": "broken off"}
                self._end = {"outcome": end.outcome, "situation": end.situation, "reason": end.reason}
                if self._door is not None:
                    self._door.outcome = summary_of(self._end) + f"; situation {end.situation}"
                self._ended.set()
            case _:
                pass

    @override
    def end(self) -> None:
        """Publish the last state, answer pending service calls, and leave the ROS network."""
        self._ended.set()
        self._over.set()
        if self._thread is not None:
            self._thread.join(timeout=LAST_WORDS_S + 5.0)
        self._link.close()

    # The node's own thread

    def _serve(self) -> None:
        try:
            last = -DIAGNOSTICS_PERIOD_S
            while not self._over.is_set():
                self._wanted.set()
                self._publish(self._now() - last >= DIAGNOSTICS_PERIOD_S)
                last = self._now() if self._now() - last >= DIAGNOSTICS_PERIOD_S else last
                self._spin_for(PUBLISH_PERIOD_S, self._over)
            self._publish(True)
            self._spin_for(LAST_WORDS_S)
        except Exception as error:
            self._say(f"the node of ROS 2 has ended, the run continues: {type(error).__name__}: {error}")

    def _spin_for(self, seconds: float, until: threading.Event | None = None) -> None:
        end = self._now() + seconds
        while (left := end - self._now()) > 0.0 and not (until is not None and until.is_set()):
            self._link.spin(min(left, 0.05))

    def _publish(self, diagnostics: bool) -> None:
        status = {**self._head, **self._status()}
        self._send_text("status", orjson.dumps(status).decode())
        self._send_text("situation", self._situation)
        self._send_text("action", orjson.dumps(self._action).decode())
        if diagnostics:
            self._publishers["diagnostics"](diagnostics_message(self._link, self._hardware, status))
        seen = self._seen
        if seen is None:
            return
        words = f"{self._situation}: {self._action.get('do', '')} ({summary_of(status)})"
        self._publishers["markers"](marker_array(self._link, seen, words, self._residuals))
        self._publishers["pose"](pose_message(self._link, seen.pose, seen.covariance))
        self._publishers["path"](path_message(self._link, seen.planned))

    def _status(self) -> dict[str, Any]:
        """Return the run's own answer; after its end, how it ended."""
        if self._ended.is_set():
            return {"state": "ended", **self._end}
        assert self._door is not None
        return self._door.status()

    def _send_text(self, name: str, words: str) -> None:
        """Publish a text; the situation and the action only if they are new."""
        if name != "status" and self._last.get(name) == words:
            return
        self._last[name] = words
        message = self._link.message(MESSAGE_KINDS[name])
        message.data = words
        self._publishers[name](message)

    def _take(self, robot: Robot) -> None:
        self._wanted.clear()
        self._seen = seen_state(robot, self._evidence, self._driven, self._snapshot)


def check_alone(
    link: ServingLink,
    seconds: float,
    ghost_s: float = 0.0,
    say: Callable[[str], None] = lambda _: None,
    sleep: Callable[[float], None] = clock.sleep,
) -> None:
    """Check that no other run has a node in the ROS network.

    Args:
        link: connection to ROS 2.
        seconds: time in [s] for other nodes to be discovered.
        ghost_s: time in [s] to wait for a discovered node to leave, because the node of a killed program
            remains visible for a while.
        say: receives a message if the function waits for another node to leave.
        sleep: function that waits for a number of seconds.

    Raises:
        SecondNode: another run has a node in the ROS network.
    """
    if not _appears(link, round(seconds / LOOK_PERIOD_S), sleep):
        return
    if ghost_s:
        say(f"another node offers {STOP_SERVICE}; waiting for up to {ghost_s:g} s until it has left")
        for _ in range(round(ghost_s / LOOK_PERIOD_S)):
            if not link.servers(STOP_SERVICE):
                return
            sleep(LOOK_PERIOD_S)
    allowed = "another namespace (--node-namespace); a killed program's node stays for half a minute"
    raise SecondNode(f"another node offers {STOP_SERVICE} in this namespace; allowed: {allowed}")


def _appears(link: ServingLink, looks: int, sleep: Callable[[float], None]) -> bool:
    """Return whether another run's node is discovered."""
    for _ in range(max(1, looks)):
        if link.servers(STOP_SERVICE):
            return True
        sleep(LOOK_PERIOD_S)
    return False


def _apart(a: Pose2, b: Pose2) -> float:
    return float(np.hypot(a.x - b.x, a.y - b.y))
