"""Rough ground in physics."""

from __future__ import annotations

import math

import numpy as np

from handcart.backends.description.ground_spec import GroundSpec
from handcart.backends.physics.engine.engine import Engine
from handcart.backends.simulation.noise.keyed_noise import keyed
from handcart.robotics.numerics.arrays import FloatArray

# [m] between points with a height; with 0.25 m a foot would be on ridges of 27 degrees
CELL_M = 0.05
CELLS_PER_SIDE = 200  # of a tile's side
MIN_GROUND_AHEAD_M = 12.0  # [m] from the robot to ground that isn't there yet, at least
WAVE_COUNT = 48  # of which the ground is made
WAVE_LENGTH_RATIOS = (2.0, 8.0)  # of them, in `roughness_length_m`
STANDS_ON = 0.6  # [m]: length and width between the wheels over which roll and pitch are counted
GROUND_FRICTION = 1.0


class Terrain:
    """Rough ground in a physics engine, a sum of waves in all directions.

    It consists of square tiles, which are created as the robot approaches them. The waves' height is set so
    that a base with wheels 0.6 m apart rolls and pitches as the world's file states.
    """

    def __init__(self, engine: Engine, ground: GroundSpec, seed: int) -> None:
        """Create an empty terrain; see `reach`."""
        self._engine = engine
        rng = keyed(seed, "terrain")
        low, high = (math.log(length * ground.roughness_length_m) for length in WAVE_LENGTH_RATIOS)
        long = np.exp(rng.uniform(low, high, WAVE_COUNT))
        course = rng.uniform(0.0, 2.0 * math.pi, WAVE_COUNT)
        self._waves = 2.0 * math.pi / long * np.array([np.cos(course), np.sin(course)])
        self._phases = rng.uniform(0.0, 2.0 * math.pi, WAVE_COUNT)
        across = np.sin(0.5 * self._waves[0] * STANDS_ON) * np.cos(0.5 * self._waves[1] * STANDS_ON)
        slope = math.sqrt(float((across**2).sum()) / 2.0) * 2.0 / STANDS_ON
        self._size = math.tan(math.radians(ground.roughness_deg)) / max(slope, 1e-9)
        self.tiles: list[tuple[int, int]] = []
        """Existing tiles, in the order of their creation."""
        self.bodies: list[int] = []

    def height(self, x: FloatArray, y: FloatArray) -> FloatArray:
        """Return the heights (...,) of the ground, in [m].

        Args:
            x: (...,) in the world, in [m].
            y: (...,) in the world, in [m].
        """
        phases = x[..., None] * self._waves[0] + y[..., None] * self._waves[1] + self._phases
        return np.asarray(self._size * np.cos(phases).sum(axis=-1))

    def height_at(self, x: float, y: float) -> float:
        """Return the height of the ground at x and y in the world, all in [m]."""
        return float(self.height(np.array(x), np.array(y)))

    def reach(self, x: float, y: float) -> list[tuple[int, int]]:
        """Return the tiles of ground around a position that have not been created yet, each as column and
        row.

        The method `add` creates a tile.

        Args:
            x: x of the position in the world, in [m].
            y: y of the position in the world, in [m].
        """
        side = CELLS_PER_SIDE * CELL_M
        low, high = (
            [math.floor((value + off) / side) for value in (x, y)]
            for off in (-MIN_GROUND_AHEAD_M, MIN_GROUND_AHEAD_M)
        )
        near = [(i, j) for i in range(low[0], high[0] + 1) for j in range(low[1], high[1] + 1)]
        return [tile for tile in near if tile not in self.tiles]

    def add(self, tile: tuple[int, int]) -> int:
        """Create the tile of ground in a column and row; return its number as a body of the engine."""
        along = CELL_M * np.arange(CELLS_PER_SIDE + 1)
        corner = np.array(tile) * CELLS_PER_SIDE * CELL_M
        heights = self.height(*np.meshgrid(corner[0] + along, corner[1] + along))  # a row each y
        body = self._engine.add_tile(corner * 1.0, CELL_M, heights, GROUND_FRICTION)
        self.tiles.append(tile)
        self.bodies.append(body)
        return body
