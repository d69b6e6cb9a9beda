"""What a backend may be able to do."""

from __future__ import annotations

from abc import ABC


class Capability(ABC):  # noqa: B024  what it can do is abstract in each kind
    """One thing that a robot can do or sense. A backend has those that its robot has.

    A command lives one period: it takes effect with the next step of the backend; not renewed, the base
    stops, and arm and gripper hold. A reading is taken once a period: asking again gives the same one.
    """
