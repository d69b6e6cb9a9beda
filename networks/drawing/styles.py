"""Colours and lines of networks; blue and orange differ for the colour-blind, too (Okabe and Ito, 2008)."""

from __future__ import annotations

from typing import NamedTuple

from .network_picture import DrawnBox, DrawnLink

HIGHLIGHT_COLOUR = "#ffd84d"


class BoxStyle(NamedTuple):
    """Colours and lines of the box of a situation or an action in a drawing of a network."""

    fill: str
    colour: str
    """Colour of its edge."""
    dash: tuple[float, float] | None
    round: float
    """Radius of its corners, in [px]."""
    width: float
    """Width of its edge, in [px]."""


class LinkStyle(NamedTuple):
    """Colour and width of the line that is drawn from a situation to an action or back."""

    colour: str
    width: float
    """Width of the line, in [px]."""


_BOXES = {
    "start": BoxStyle("#e0f0fa", "#0072b2", None, 12.0, 2.0),
    "goal": BoxStyle("#dff3ec", "#009e73", None, 12.0, 2.0),
    "situation": BoxStyle("#f4f7fb", "#8aa0b8", None, 12.0, 1.5),
    "action": BoxStyle("#ffffff", "#4a5d73", None, 2.0, 1.2),
    "travelled": BoxStyle("#e0f0fa", "#0072b2", None, 2.0, 1.5),
    "mixed": BoxStyle("#fff4d6", "#d55e00", None, 2.0, 1.5),
    "failed": BoxStyle("#fde6d8", "#d55e00", (5.0, 3.0), 2.0, 1.5),
    "untried": BoxStyle("#ffffff", "#8593a1", (2.0, 3.0), 2.0, 1.2),
}


def style_of_box(box: DrawnBox) -> BoxStyle:
    """Return colours and edge of a situation's or action's box in the drawing of a network, by its kind."""
    return _BOXES[box.kind]


def style_of_link(link: DrawnLink) -> LinkStyle:
    """Return colour and width of a link between a situation and an action.

    A link that a run took is thicker. A link after a Fail has another colour.
    """
    if link.failed:
        return LinkStyle("#d55e00", 2.5 if link.travelled else 1.3)
    return LinkStyle("#0072b2", 2.5) if link.travelled else LinkStyle("#7b8b9c", 1.3)
