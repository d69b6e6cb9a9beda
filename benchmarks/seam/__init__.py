"""Tracking, measured."""
