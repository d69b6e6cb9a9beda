"""Arm motion: collision, planning, timing."""
