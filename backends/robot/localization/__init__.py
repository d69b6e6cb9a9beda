"""Localization of a robot's base, with whichever sensors it has."""
