"""Colours of diagrams that colour-blind readers can distinguish, by Okabe and Ito (2008)."""

from __future__ import annotations

BLACK, GREY = "#111111", "#767676"
BLUE, SKY, GREEN = "#0072b2", "#56b4e9", "#009e73"
ORANGE, VERMILION, PURPLE = "#e69f00", "#d55e00", "#cc79a7"

SERIES_COLOURS = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY)
"""Colours for a series of similar curves, in order."""
OUTCOME_COLOURS = {"Success": BLUE, "Fail": VERMILION, "GiveUp": "#1d2733", "": GREY}
"""Colours by outcome of an action; empty: it has not ended. White text is readable on all of them."""
