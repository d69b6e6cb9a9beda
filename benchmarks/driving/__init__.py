"""Driving, measured."""
