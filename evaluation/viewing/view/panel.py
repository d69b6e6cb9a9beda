"""Panel of the page: current action, time line, camera picture and network."""

from __future__ import annotations

import base64
from collections.abc import Callable, Sequence
from html import escape
from typing import TYPE_CHECKING

from handcart.evaluation.viewing.drawing.palette import OUTCOME_COLOURS
from handcart.networks.graph.network import ActionNetwork
from handcart.networks.past_runs.past_run import PastAction

from .frame import Frame
from .network_window import NetworkWindow
from .time_line import time_line

if TYPE_CHECKING:
    import viser

TIME_LINE_PERIOD_S = 0.2  # between two updates
_READABLE = """<style>
label { color: #495057 !important }
.mantine-Button-root { --button-bg: #00527f !important; --button-hover: #003f61 !important }
.mantine-Button-root[data-variant="outline"] { --button-bg: #fff !important;
  --button-color: #00527f !important; --button-bd: 1px solid #00527f !important }
</style>"""
"""Darker colours than viser's own grey and blue, with sufficient contrast."""
_HEAD = "font-family:system-ui,sans-serif;padding:0.3em 0.8em;line-height:1.35;color:#1d2733;font-size:0.85em"


Why = Callable[[PastAction], Sequence[str]]
"""Function that returns why an action was chosen, line by line."""


def _unknown(_action: PastAction) -> Sequence[str]:
    return ()


def _listed(lines: Sequence[str]) -> str:
    if not lines:
        return ""
    items = "".join(f"<li>{escape(line)}</li>" for line in lines)
    return f'<details style="{_HEAD}"><summary>Why this action?</summary><ul>{items}</ul></details>'


class Panel:
    """Panel of a run's web page with status, reasons, time line, controls and network."""

    def __init__(self, server: viser.ViserServer, title: str, ended: str) -> None:
        """Create an empty panel.

        Args:
            server: server of the page.
            title: title of the task.
            ended: outcome of the run in a sentence, or that it is still going.
        """
        gui = server.gui
        self._title, self.ended = title, ended
        self._status = gui.add_html("")
        self._why_text = gui.add_html("")
        self._line = gui.add_html("")
        self.controls = gui.add_folder(None)
        self._network = gui.add_html("")
        self._picture = gui.add_html("")
        self._window: NetworkWindow | None = None
        self._why: Why = _unknown
        self._explained: int | None = None
        self._shown: tuple[object, ...] = ()
        self._line_at = -1.0

    def know(
        self, network: ActionNetwork | None, actions: Sequence[PastAction], why: Why | None = None
    ) -> None:
        """Set the network that the panel shows from now on, and the actions of the run with their outcomes.

        Args:
            network: the network; None if it is not known.
            actions: the actions of the run.
            why: function that returns the reasons for choosing an action, line by line; None: unchanged.
        """
        self._why = why or self._why
        self._window = None if network is None else NetworkWindow(network, actions)
        self._shown = ()

    def show(
        self,
        frame: Frame,
        action: PastAction | None,
        actions: Sequence[PastAction],
        span: tuple[float, float],
        at_once: bool,
    ) -> None:
        """Show a frame of the run in the panel.

        Args:
            frame: the frame.
            action: action to describe, the running one or the one nearest in time; None if there is none.
            actions: all actions of the run, for the time line.
            span: start and end of the time line, in [s] of the robot's time.
            at_once: True to draw the time line again now, not only from time to time.
        """
        time = frame.moment.time
        runs = action is not None and action.start <= time < action.end
        self._status.content = self._words(frame, action, runs)
        if action is not None and action.number != self._explained:
            self._explained = action.number
            self._why_text.content = _listed(self._why(action))
        if at_once or abs(time - self._line_at) >= TIME_LINE_PERIOD_S * max(1.0, (span[1] - span[0]) / 100.0):
            self._line_at = time
            self._line.content = f'<div style="padding:0.2em 0.8em">{time_line(actions, *span, time)}</div>'
        if frame.picture is not None:
            data = base64.b64encode(frame.picture).decode()
            image = f'<img alt="what the camera saw" style="width:100%" src="data:image/jpeg;base64,{data}">'
            self._picture.content = f'<div style="padding:0.2em 0.8em">{image}</div>'
        shown = (frame.situation, action.number if action is not None and runs else None)
        if shown != self._shown and self._window is not None:
            self._shown = shown
            svg = self._window.svg(frame.situation, action if runs else None)
            self._network.content = f'<div style="padding:0.4em 0.8em">{svg}</div>'

    def _words(self, frame: Frame, action: PastAction | None, runs: bool) -> str:
        doing = f"in situation <b>{escape(frame.situation)}</b>"
        if action is not None and runs:
            way = f"{escape(action.source)} → {escape(action.target)}"
            doing = f"{action.number}. <b>{escape(action.do)}</b> {way}"
            if frame.moment.restoring:
                doing += f' <b style="color:{OUTCOME_COLOURS["Fail"]}">restoring</b>'
        return (
            f'{_READABLE}<div style="{_HEAD}">'
            f'<h1 style="font-size:1em;font-weight:600;margin:0">{escape(self._title)}</h1>'
            f'<div style="color:#4a5868">{escape(self.ended)}</div>'
            f'<div style="margin-top:0.3em"><span style="font-variant-numeric:tabular-nums">'
            f"{frame.moment.time:.1f} s</span> &nbsp;{doing}</div></div>"
        )
