"""Time line of a run's actions for the page's panel."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from handcart.evaluation.viewing.drawing.palette import OUTCOME_COLOURS
from handcart.networks.past_runs.past_run import PastAction

LINE_WIDTH, LINE_HEIGHT = 1000.0, 64.0
LETTER_WIDTH = 15.0  # of the numbers on the bars


def time_line(actions: Sequence[PastAction], start: float, end: float, now: float) -> str:
    """Return an SVG with a bar for each action's duration and a line at `now`; all times in [s]."""
    span = max(end - start, 1e-9)
    words = [
        '<svg xmlns="http://www.w3.org/2000/svg" width="100%" '
        f'viewBox="0 0 {LINE_WIDTH:.0f} {LINE_HEIGHT:.0f}" '
        'role="img" aria-label="time line of the actions" font-family="system-ui, sans-serif" font-size="26" '
        'text-anchor="middle" style="display:block">',
        f'<rect x="0" y="8" width="{LINE_WIDTH:.0f}" height="48" fill="#e9edf2"/>',
    ]
    for action in actions:
        x, wide = (action.start - start) / span * LINE_WIDTH, (action.end - action.start) / span * LINE_WIDTH
        runs = action.start <= now < action.end
        words.append(
            f'<rect x="{x:.1f}" y="8" width="{max(wide - 2.0, 1.0):.1f}" height="48" '
            f'fill="{OUTCOME_COLOURS.get(action.outcome, OUTCOME_COLOURS[""])}" '
            f'opacity="{1.0 if runs else 0.8}"/>'
        )
        if action.broken_off is not None:
            back = (action.end - action.broken_off) / span * LINE_WIDTH
            words.append(
                f'<rect x="{x + wide - back:.1f}" y="44" width="{max(back - 2.0, 1.0):.1f}" height="12" '
                'fill="#7a3f00"/>'
            )
        if wide > LETTER_WIDTH * (len(str(action.number)) + 1):
            words.append(
                f'<text x="{x + wide / 2:.1f}" y="41" fill="#fff">{escape(str(action.number))}</text>'
            )
    at = min(max((now - start) / span, 0.0), 1.0) * LINE_WIDTH
    words.append(
        f'<rect x="{min(at, LINE_WIDTH - 6.0):.1f}" y="0" width="6" height="{LINE_HEIGHT:.0f}" '
        'fill="#11181f"/></svg>'
    )
    return "".join(words)
