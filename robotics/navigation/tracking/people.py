"""Predicted positions of people, their distances to a robot's motion, and cells to plan around."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.numerics.arrays import BoolArray, FloatArray
from handcart.robotics.numerics.compiled import compiled, compiled_for

from .moving_tracks import ACCELERATION_DENSITY, BodyTrack

PERSON_RADIUS_M = 0.27  # of a body whose legs alone are seen, at least
MAX_SPREAD_M = 0.15  # of a predicted place that counts as occupied, at most
FORESEEN_S = 3.0  # of walking that routes lead around
FORESEEN_STEP_S = 0.25
CLEAR_OF_ROBOT_M = 0.1  # beside the footprint, where no person is drawn: the way out must stay open


class People(NamedTuple):
    """Positions, velocities and sizes of p people and carts at one instant."""

    positions: FloatArray
    """(p, 2) on the map, in [m]."""
    velocities: FloatArray
    """Velocities (p, 2) on the map, in [m/s]; zero at rest."""
    covariances: FloatArray
    """(p, 4, 4) of x, y in [m] and the velocity along x and y in [m/s], on the map."""
    radii: FloatArray
    """Radii (p,) of their bodies, in [m]."""
    stood_s: FloatArray
    """Time (p,) at rest of each, in [s]; 0 while moving."""

    @classmethod
    def of(cls, tracks: Sequence[BodyTrack]) -> People:
        """Return the people and carts that given tracks describe."""
        return cls(
            np.array([track.position for track in tracks]).reshape(-1, 2),
            np.array([track.velocity for track in tracks]).reshape(-1, 2),
            np.array([track.covariance for track in tracks]).reshape(-1, 4, 4),
            np.array([max(track.radius, PERSON_RADIUS_M) for track in tracks]),
            np.array([track.stood_s for track in tracks]),
        )

    @property
    def moving(self) -> BoolArray:
        """Mask (p,) of the people and carts whose velocity is not zero."""
        return np.asarray((self.velocities != 0.0).any(axis=1))

    @property
    def rows(self) -> FloatArray:
        """Table (p, 7) of all tracked people, to draw them.

        Columns are x, y on the map in [m], the velocity along them in [m/s], and xx, xy, yy of the
        position's covariance in [m²].
        """
        return np.hstack([self.positions, self.velocities, self.covariances[:, [0, 0, 1], [0, 1, 1]]])

    def chosen(self, mask: BoolArray) -> People:
        """Return only the people for whom a mask (p,) is True."""
        return People(*(item[mask] for item in self))

    def spreads(self, times: FloatArray) -> FloatArray:
        """Return the standard deviations (p, t) of all people's predicted positions, in [m].

        Args:
            times: (t,) times from now, in [s].
        """
        P, t = self.covariances, times[None]
        along = [
            P[:, i, i, None] + 2.0 * t * P[:, i, i + 2, None] + t**2 * P[:, i + 2, i + 2, None]
            for i in (0, 1)
        ]
        walking = 0.5 * (along[0] + along[1]) + ACCELERATION_DENSITY * t**3 / 3.0
        standing = 0.5 * (P[:, 0, 0] + P[:, 1, 1])[:, None]
        return np.asarray(np.sqrt(np.where(self.moving[:, None], walking, standing)))


def least_gaps(paths: FloatArray, times: FloatArray, people: People, radius: float) -> FloatArray:
    """Return the least gaps, in [m], between a robot on some paths and people on their predicted paths.

    A gap below 0 is a contact. The radius of a person grows by one standard deviation of the predicted
    position, by at most `MAX_SPREAD_M`.

    Args:
        paths: (k, t, 2) positions of the robot on the map, in [m].
        times: (t,) times of these positions from now, in [s].
        people: all persons.
        radius: radius of the robot's footprint, in [m].

    Returns:
        (k, p) gap on each path to each person.
    """
    return _least_gaps(
        paths, times, people.positions, people.velocities, people.covariances, people.radii, radius
    )


@compiled_for("(f8[:,:,::1], f8[::1], f8[:,::1], f8[:,::1], f8[:,:,::1], f8[::1], f8)")
def _least_gaps(
    paths: FloatArray,
    times: FloatArray,
    positions: FloatArray,
    velocities: FloatArray,
    covariances: FloatArray,
    radii: FloatArray,
    radius: float,
) -> FloatArray:
    """Return the least gaps (k, p), as `least_gaps` does, by the fields of `People`."""
    gaps = np.full((len(paths), len(radii)), np.inf)
    for p in range(len(radii)):
        P = covariances[p]
        moves = velocities[p, 0] != 0.0 or velocities[p, 1] != 0.0
        for i in range(len(times)):
            t = times[i] if moves else 0.0
            size = grown_radius(P, t, radii[p])
            x, y = positions[p, 0] + t * velocities[p, 0], positions[p, 1] + t * velocities[p, 1]
            for k in range(len(paths)):
                away = math.sqrt((paths[k, i, 0] - x) ** 2 + (paths[k, i, 1] - y) ** 2)
                gaps[k, p] = min(gaps[k, p], away - size - radius)
    return gaps


@compiled
def grown_radius(P: FloatArray, t: float, radius: float) -> float:
    """Return a radius in [m] plus one standard deviation of a predicted position, at most `MAX_SPREAD_M`.

    Args:
        P: (4, 4) covariance of x, y in [m] and the velocity along x and y in [m/s].
        t: time of the prediction from now, in [s]; 0 for a person at rest.
        radius: radius of the body, in [m].
    """
    both = P[0, 0] + P[1, 1] + 2.0 * t * (P[0, 2] + P[1, 3]) + t**2 * (P[2, 2] + P[3, 3])
    spread = math.sqrt(0.5 * both + ACCELERATION_DENSITY * t**3 / 3.0)
    return radius + min(spread, MAX_SPREAD_M)


def with_people(grid: GridMap, people: People, here: FloatArray, radius: float, keep: float) -> GridMap:
    """Return a map on which people are obstacles where they are and will be in the next `FORESEEN_S`.

    Args:
        grid: the map with the sensed obstacles.
        people: people around whom routes should lead.
        here: (2,) position of the robot on the map, in [m], around which nothing is drawn.
        radius: radius of the robot's footprint, in [m].
        keep: distance to keep from people, in [m].
    """
    times = np.arange(0.0, FORESEEN_S + 1e-9, FORESEEN_STEP_S)
    there = people.positions[:, None] + times[None, :, None] * people.velocities[:, None]
    sizes = people.radii[:, None] + keep + np.minimum(people.spreads(times), MAX_SPREAD_M)
    discs = np.column_stack([there.reshape(-1, 2), sizes.ravel()])
    discs[np.repeat(~people.moving, len(times)) & (np.tile(times, len(people.radii)) > 0.0), 2] = 0.0
    occupied, corner = grid.occupied.copy(), np.array([grid.origin_x, grid.origin_y], dtype=np.float64)
    _draw(occupied, discs[discs[:, 2] > 0.0], corner, grid.resolution)
    clear = np.zeros_like(occupied)
    around = np.array([[here[0], here[1], radius + CLEAR_OF_ROBOT_M]], dtype=np.float64)
    _draw(clear, around, corner, grid.resolution)
    occupied = np.where(clear, grid.occupied, occupied)
    return grid._replace(occupied=occupied, unknown=grid.unknown & ~occupied)


@compiled_for("(b1[:,::1], f8[:,::1], f8[::1], f8)")
def _draw(cells: BoolArray, discs: FloatArray, corner: FloatArray, resolution: float) -> None:
    """Set the cells (h, w) whose centres lie in discs (k, 3), rows of x, y and radius; all in [m]."""
    height, width = cells.shape
    for i in range(len(discs)):
        column = (discs[i, 0] - corner[0]) / resolution - 0.5
        row = (discs[i, 1] - corner[1]) / resolution - 0.5
        reach = discs[i, 2] / resolution
        left, right = max(0, math.ceil(column - reach)), min(width, math.floor(column + reach) + 1)
        low, high = max(0, math.ceil(row - reach)), min(height, math.floor(row + reach) + 1)
        for r in range(low, high):
            for c in range(left, right):
                if (r - row) * (r - row) + (c - column) * (c - column) <= reach * reach:
                    cells[r, c] = True
