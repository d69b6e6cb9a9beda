"""Live view of a run."""

from __future__ import annotations

import threading
import time as clock
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from typing_extensions import override

from handcart.backends.robot.robot import Robot
from handcart.evaluation.judging.survey import simulated_world
from handcart.evaluation.viewing.playback.scenery import scenery_of, thing_shapes
from handcart.networks.events.events import Ended, Event, Planned, Restoring, RunEnded, Started
from handcart.networks.events.run_observer import RunObserver
from handcart.networks.operator.view_address import forget_address, note_address
from handcart.networks.past_runs.past_run import PastAction
from handcart.networks.task.preparing import Prepared
from handcart.primitives.contract.action_primitive import ActionPrimitive

from .frame import Frame
from .live_frames import LiveFrames
from .page import Page

if TYPE_CHECKING:
    import viser

MAX_FRAMES_PER_S = 15.0
MAX_CATCH_UP_S = 0.5
"""Wall time in [s] by which a run may lag, as in a pause, and still catch up at its highest speed."""
FASTEST_LABEL = "fastest"
SPEED_LABELS = ("1", "2", "5", "20", FASTEST_LABEL)


class LiveView(RunObserver):
    """Observer that shows a run live on a web page, which it draws in its own thread.

    A simulated run is slowed down to the speed chosen on the page, at first real time; a real robot is never
    slowed down. The view reads its data between two periods, and only data that the run reads anyway, so it
    does not change the run.
    """

    def __init__(self, server: viser.ViserServer, address: str) -> None:
        """Draw onto the page of a server with this address."""
        self._server, self._address = server, address
        self._page: Page | None = None
        self._folder: Path | None = None
        self._frames: LiveFrames | None = None
        self._wanted, self._taken, self._over = threading.Event(), threading.Event(), threading.Event()
        self._frame: Frame | None = None
        self._actions: list[PastAction] = []
        self._news = False
        self._primitive: ActionPrimitive | None = None
        self._situation, self._restoring = "", False
        self._factor: float | None = 1.0
        self._since = (0.0, 0.0)  # a wall time, and the robot's time then
        self._drawing: threading.Thread | None = None

    @override
    def begin(self, prepared: Prepared, run_dir: Path) -> None:
        scene = simulated_world(prepared.backend)
        scenery = scenery_of(prepared, scene)
        things = [] if scene is None else thing_shapes(scene.things())
        task = prepared.task
        self._page = Page(self._server, scenery, things, task.file.title, "goes on")
        self._network = task.network
        self._page.panel.know(task.network, ())
        self._frames = LiveFrames(prepared.robot, scene, scenery, {thing.name for thing in things})
        self._situation = task.network.start
        if prepared.backend.simulated:
            self._add_speeds(self._page)
        else:
            self._factor = None
        self._page.add_layers()
        self._since = (clock.monotonic(), prepared.robot.time)
        self._take()
        note_address(run_dir, self._address)
        self._folder = run_dir
        self._drawing = threading.Thread(target=self._draw, daemon=True)
        self._drawing.start()

    @override
    def period(self, robot: Robot) -> None:
        if self._wanted.is_set():
            self._take()
        if self._factor is not None:
            wall, time = self._since
            ahead = (robot.time - time) / self._factor - (clock.monotonic() - wall)
            if ahead > 0.0:
                clock.sleep(min(ahead, 1.0))
            elif ahead < -MAX_CATCH_UP_S:
                self._since = (clock.monotonic(), robot.time)

    @override
    def event(self, event: Event) -> None:
        match event:
            case Planned(situation=situation):
                self._situation = situation
            case Started(time, number, action, primitive, _):
                self._situation, self._restoring, self._primitive = action.source, False, primitive
                way = action.do, action.source, action.target
                self._actions.append(PastAction(number, 0, *way, {}, time, np.inf, None, ""))
            case Restoring(time=time):
                self._restoring = True
                self._actions[-1] = replace(self._actions[-1], broken_off=time)
            case Ended(time=time, outcome=outcome, action=action):
                name = type(outcome).__name__
                self._actions[-1] = replace(self._actions[-1], end=time, outcome=name)
                self._situation = action.target if name == "Success" else action.source
                self._restoring, self._news = False, True
            case RunEnded(end=end):
                self._situation = end.situation
                if self._page is not None:
                    self._page.panel.ended = end.outcome
            case _:
                pass

    def end(self) -> None:
        """Draw the state at the end of the run, which stays on the page."""
        if self._folder is not None:
            forget_address(self._folder)
        if self._drawing is not None:
            self._take()
            self._over.set()
            self._drawing.join(timeout=2.0)

    # The page's own thread

    def _draw(self) -> None:
        while not self._over.is_set():
            self._wanted.set()
            if self._taken.wait(0.2):
                self._taken.clear()
                self._put()
            self._over.wait(1.0 / MAX_FRAMES_PER_S)
        self._put()

    def _put(self) -> None:
        frame, page = self._frame, self._page
        if frame is None or page is None:
            return
        actions = list(self._actions)
        now = frame.moment.time
        if self._news:
            self._news = False
            page.panel.know(self._network, actions)
        so_far = [replace(action, end=min(action.end, now)) for action in actions]
        running = actions[-1] if actions else None
        page.draw(frame, running, so_far, (0.0, max(now, 1.0)))

    # The run's own thread

    def _take(self) -> None:
        """Read the data of the next frame."""
        if self._frames is None:
            return
        self._wanted.clear()
        number = self._actions[-1].number if self._actions else 0
        points = {} if self._primitive is None else self._primitive.evidence.points
        planned = points.get("planned")
        self._frame = self._frames.now(self._situation, number, self._restoring, planned)
        self._taken.set()

    def _add_speeds(self, page: Page) -> None:
        with page.panel.controls:
            speed = self._server.gui.add_button_group("speed", SPEED_LABELS)

        @speed.on_click
        def _(_: object) -> None:
            assert self._frames is not None
            self._since = (clock.monotonic(), self._frames.time)
            self._factor = None if speed.value == FASTEST_LABEL else float(speed.value)
