"""The simulated world itself, for surveys that need more of it than its `GroundTruth`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from handcart.backends.backend import Backend

if TYPE_CHECKING:
    from handcart.backends.simulation.scene import Scene


def simulated_world(backend: Backend) -> Scene | None:
    """What is behind a backend, through all that is put around it; None where no scene is simulated."""
    while backend.inner is not None:
        backend = backend.inner
    if not backend.simulated:
        return None
    from handcart.backends.simulation.simulated_backend import SimulatedBackend

    return backend.scene if isinstance(backend, SimulatedBackend) else None
