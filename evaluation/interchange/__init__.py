"""Behaviour trees, state machines and models of other programs: read as tasks, and written from tasks."""
