"""Execution of a run, with its metrics, pictures and video."""
