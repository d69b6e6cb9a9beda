"""Colours of diagrams, which the colour-blind tell apart as well: those of Okabe and Ito (2008)."""

from __future__ import annotations

BLACK, GREY = "#111111", "#767676"
BLUE, SKY, GREEN = "#0072b2", "#56b4e9", "#009e73"
ORANGE, VERMILION, PURPLE = "#e69f00", "#d55e00", "#cc79a7"

SERIES = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY)
"""Of things of one kind, one after the other."""
OUTCOMES = {"Success": BLUE, "Fail": VERMILION, "GiveUp": "#1d2733", "": GREY}
"""By how an action ended; empty: it didn't, yet. White letters are read on all of them."""
