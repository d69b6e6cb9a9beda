"""Localization of a base, indoors."""
