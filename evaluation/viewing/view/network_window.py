"""Section of the action network around the current situation, drawn on the page's panel."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from handcart.networks.drawing.network_picture import DrawnBox, NetworkPicture, draw_network
from handcart.networks.drawing.svg import to_svg
from handcart.networks.graph.network import ActionNetwork
from handcart.networks.past_runs.past_run import PastAction

WINDOW_WIDTH_PX, WINDOW_HEIGHT_PX = 560.0, 260.0  # in pixels of the network
BOX_MARGIN_PX = 10.0  # around the outermost boxes


class NetworkWindow:
    """Drawing of a task's network of actions and outcomes; a view shows the part around the present
    action.
    """

    def __init__(self, network: ActionNetwork, actions: Sequence[PastAction]) -> None:
        self._picture = draw_network(network, [(action.index, action.outcome) for action in actions])

    def svg(self, situation: str, action: PastAction | None) -> str:
        """Return the section of the drawing around an action or situation as SVG, with both highlighted.

        Args:
            situation: name of the present situation.
            action: running action, in the middle of the section; None: the situation is in the middle.
        """
        lit = [self._picture.box(situation=situation)]
        if action is not None:
            lit = [self._picture.box(action=action.index), *lit]
        drawn = to_svg(self._picture, lit, _window(self._picture, lit[0]))
        named = f'role="img" aria-label="action network at {escape(situation)}"'
        return drawn.replace("<svg ", f"<svg {named} ", 1)


def _window(picture: NetworkPicture, box: DrawnBox) -> str:
    """Return the section around a box as a `viewBox`, no higher than its content."""
    x = min(max(box.x + box.width / 2 - WINDOW_WIDTH_PX / 2, 0.0), max(0.0, picture.width - WINDOW_WIDTH_PX))
    seen = [item for item in picture.boxes if item.x < x + WINDOW_WIDTH_PX and item.x + item.width > x]
    top = min(item.y for item in seen) - BOX_MARGIN_PX
    high = min(WINDOW_HEIGHT_PX, max(item.y + item.height for item in seen) + BOX_MARGIN_PX - top)
    y = max(top, box.y + box.height / 2 - WINDOW_HEIGHT_PX / 2) if high == WINDOW_HEIGHT_PX else top
    return f"{x:.0f} {y:.0f} {WINDOW_WIDTH_PX:.0f} {high:.0f}"
