"""Laying sensors, measured."""
