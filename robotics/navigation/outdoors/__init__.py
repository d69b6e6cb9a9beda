"""Localization of a base on open ground, by wheels, gyros and GNSS."""
