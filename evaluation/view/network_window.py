"""The action network as the page's panel shows it: a window about where the run is, which is lit."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from handcart.evaluation.report.network_picture import Box, NetworkPicture, Way, draw_network, folded
from handcart.networks.graph.network import ActionNetwork
from handcart.networks.journal.past_run import PastAction

WIDE, HIGH = 420.0, 190.0  # of the window, in pixels of the network
BESIDE = 10.0  # of the outermost boxes
LIT = "#ffd84d"
_FILLS = {
    "situation": ("#f4f7fb", "#8aa0b8"),
    "travelled": ("#e0f0fa", "#0072b2"),
    "mixed": ("#fff4d6", "#d55e00"),
    "failed": ("#fde6d8", "#d55e00"),
    "untried": ("#ffffff", "#c9d2dc"),
}


class NetworkWindow:
    """A network, laid out once for as many actions as are known."""

    def __init__(self, network: ActionNetwork, actions: Sequence[PastAction]) -> None:
        self._picture: NetworkPicture = draw_network(network, actions)

    def svg(self, situation: str, action: PastAction | None) -> str:
        """Where the run is, in the middle: a situation, or an action that runs."""
        name = folded(situation)
        way = None if action is None else Way(folded(action.source), folded(action.target), action.do)
        lit = [each for each in self._picture.boxes if _is(each, name, way)]
        middle = next((each for each in lit if each.way == way), lit[0] if lit else self._picture.boxes[0])
        box = _window(self._picture, middle)
        words = [
            f'<svg xmlns="http://www.w3.org/2000/svg" width="100%" viewBox="{box}" role="img" '
            f'aria-label="action network at {escape(situation)}" text-anchor="middle" '
            'font-family="system-ui, sans-serif" font-size="12" style="display:block">'
        ]
        for link in self._picture.links:
            colour, width = ("#0072b2", 2.5) if link.travelled else ("#c9d2dc", 1.2)
            words.append(f'<path d="{link.path}" fill="none" stroke="{colour}" stroke-width="{width}"/>')
        words += [_drawn(each, each in lit) for each in self._picture.boxes]
        return "".join([*words, "</svg>"])


def _is(box: Box, situation: str, way: Way | None) -> bool:
    return box.words == situation if box.way is None else box.way == way


def _window(picture: NetworkPicture, box: Box) -> str:
    """As `viewBox` has it: no higher than what is seen in it."""
    x = min(max(box.x + box.width / 2 - WIDE / 2, 0.0), max(0.0, picture.width - WIDE))
    seen = [each for each in picture.boxes if each.x < x + WIDE and each.x + each.width > x]
    top = min(each.y for each in seen) - BESIDE
    high = min(HIGH, max(each.y + each.height for each in seen) + BESIDE - top)
    y = max(top, box.y + box.height / 2 - HIGH / 2) if high == HIGH else top
    return f"{x:.0f} {y:.0f} {WIDE:.0f} {high:.0f}"


def _drawn(box: Box, lit: bool) -> str:
    fill, stroke = _FILLS[box.kind]
    if lit:
        fill, stroke = LIT, "#1d2733"
    middle, round_ = box.x + box.width / 2, 12 if box.way is None else 2
    weight = 600 if box.way is None or lit else 400
    words = (
        f'<rect x="{box.x:.1f}" y="{box.y:.1f}" width="{box.width:.1f}" height="{box.height:.1f}" '
        f'rx="{round_}" fill="{fill}" stroke="{stroke}" stroke-width="{2.5 if lit else 1.5}"/>'
        f'<text x="{middle:.1f}" y="{box.y + (17 if box.below else 24):.1f}" fill="#1d2733" '
        f'font-weight="{weight}">{escape(box.words)}</text>'
    )
    if box.below:
        at = f'x="{middle:.1f}" y="{box.y + 32:.1f}"'
        words += f'<text {at} fill="#4a5868" font-size="11">{escape(box.below)}</text>'
    return words
