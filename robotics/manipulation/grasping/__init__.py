"""Poses of a hand that grips a box, and of a camera that looks at a point."""
