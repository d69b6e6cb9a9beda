"""Replay of a recorded run in the page, with play, pause and a time slider."""

from __future__ import annotations

import threading
import time as clock
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING

from handcart.evaluation.viewing.explanation.explanation import relying_on_the_journal
from handcart.evaluation.viewing.explanation.explanation_words import choice_words
from handcart.evaluation.viewing.playback.playback import Playback
from handcart.networks.past_runs.hindsight import choice_of
from handcart.networks.past_runs.past_run import PastAction, PastRun

from .page import Page
from .recorded_frames import RecordedFrames

if TYPE_CHECKING:
    import viser

MAX_FRAMES_PER_S = 25.0
SPEED_LABELS = ("¼", "1", "2", "5", "20")
SPEED_FACTORS = {"¼": 0.25}
BEFORE_LABEL, NEXT_LABEL = "◂ before", "next ▸"
SLIDER_STEP_S = 0.1


def _why(run: PastRun, action: PastAction) -> Sequence[str]:
    """Return why an action was chosen, with P(goal) and time of each alternative."""
    with relying_on_the_journal(run):
        choice = choice_of(run, action)
    return () if choice is None else list(choice_words(choice))


class Replay:
    """Replay of a recorded run on a web page with controls; the caller advances it by repeated `step`."""

    def __init__(self, server: viser.ViserServer, playback: Playback) -> None:
        """Draw the start of the run."""
        self._playback, run = playback, playback.run
        self._frames = RecordedFrames(playback)
        things = [track.shape for track in playback.things.values()]
        self._page = Page(server, playback.scenery, things, str(run.header["task"]), _ended(run))
        network = None if run.network is None else run.network.network
        self._page.panel.know(network, run.actions, partial(_why, run))
        self._time, self._drawn = playback.start, -1.0
        self._playing, self._factor = False, 1.0
        self._lock = threading.Lock()
        self._add_controls(server)
        self._page.add_layers()
        self.step(0.0)

    @property
    def time(self) -> float:
        """Time of the run that the page shows, in [s] on the robot's clock."""
        return self._time

    def go_to(self, time: float) -> None:
        """Show the run at a time in [s] on the robot's clock, limited to the recording."""
        with self._lock:
            self._time = min(max(time, self._playback.start), self._playback.end)
        self._follow_slider()

    def play(self, playing: bool) -> None:
        """Start or pause the replay; at the end of the recording, start again from its beginning."""
        if playing and self._time >= self._playback.end:
            self.go_to(self._playback.start)
        self._playing = playing
        self._play.label = "Pause" if playing else "Play"

    def step(self, passed: float) -> bool:
        """Advance the replay by `passed` [s] of wall time; return True if a new frame was drawn."""
        if self._playing:
            self.go_to(self._time + passed * self._factor)
            if self._time >= self._playback.end:
                self.play(False)
        time = self._time
        if time == self._drawn:
            return False
        jumped = not self._playing
        self._drawn = time
        span = (self._playback.start, self._playback.end)
        frame = self._frames.at(time)
        action = self._playback.action(frame.moment.action) or self._next()
        self._page.draw(frame, action, self._playback.run.actions, span, jumped)
        return True

    def run(self, over: Callable[[], bool]) -> None:
        """Play the replay at the speed chosen on the page until `over`, called before each frame, returns
        True.
        """
        before = clock.monotonic()
        while not over():
            clock.sleep(max(0.001, before + 1.0 / MAX_FRAMES_PER_S - clock.monotonic()))
            now = clock.monotonic()
            self.step(now - before)
            before = now

    # Controls

    def _add_controls(self, server: viser.ViserServer) -> None:
        gui = server.gui
        with self._page.panel.controls:
            start, end = self._playback.start, max(self._playback.end, self._playback.start + SLIDER_STEP_S)
            self._slider = gui.add_slider("time [s]", start, end, SLIDER_STEP_S, start)
            self._play = gui.add_button("Play")
            jump = gui.add_button_group("action", (BEFORE_LABEL, NEXT_LABEL))
            speed = gui.add_button_group("speed", SPEED_LABELS)

        @self._slider.on_update
        def _(event: viser.GuiEvent) -> None:  # type: ignore[type-arg]
            if event.client is not None:
                self.go_to(float(self._slider.value))

        @self._play.on_click
        def _(_: object) -> None:
            self.play(not self._playing)

        @jump.on_click
        def _(_: object) -> None:
            self._jump(jump.value == NEXT_LABEL)

        @speed.on_click
        def _(_: object) -> None:
            self._factor = SPEED_FACTORS.get(speed.value) or float(speed.value)

    def _follow_slider(self) -> None:
        value = round(self._time / SLIDER_STEP_S) * SLIDER_STEP_S
        if abs(value - float(self._slider.value)) >= SLIDER_STEP_S / 2:
            self._slider.value = min(max(value, self._slider.min), self._slider.max)  # type: ignore[misc]

    def _jump(self, on: bool) -> None:
        """Go to the start of the next action, or back to the last start that is more than 1 s ago."""
        starts = [action.start for action in self._playback.run.actions]
        if on:
            target = min(
                (start for start in starts if start > self._time + SLIDER_STEP_S / 2),
                default=self._playback.end,
            )
        else:
            target = max(
                (start for start in starts if start < self._time - 1.0), default=self._playback.start
            )
        self.go_to(target)

    def _next(self) -> PastAction | None:
        return next(iter(self._playback.run.actions), None)


def _ended(run: PastRun) -> str:
    end, fails = run.end, sum(action.fails for action in run.actions)
    count = f"{len(run.actions)} action{'' if len(run.actions) == 1 else 's'}, {fails or 'none'} failed"
    if end is None:
        return f"no end is known; {count}"
    reason = f": {end['reason']}" if end["reason"] else ""
    return f"{end['outcome']} after {end['t']:.1f} s, {count}{reason}"
