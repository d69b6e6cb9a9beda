"""Bring-up of a real robot, step by step."""
