"""Paths and arms that several tests use."""

from __future__ import annotations

import numpy as np

from handcart.robotics.manipulation.paths.tool_path import ToolPath, tool_path
from handcart.robotics.numerics.arrays import FloatArray


def straight(length: float = 4.4, points: int = 201) -> ToolPath:
    """Along x at y = 0; the tool points along y."""
    poses = np.tile(np.eye(4), (points, 1, 1))
    poses[:, 0, 3] = np.linspace(0.0, length, points)
    poses[:, :3, :3] = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
    return tool_path(poses)


def arched_poses(
    points: int = 200, span: float = 4.6, low: float = 0.7, rise: float = 0.5, pitch_deg: float = -35.0
) -> FloatArray:
    """An arch over y = 0, seen from negative y; the tool points along y and down."""
    t = np.linspace(-0.5, 0.5, points)
    poses = np.tile(np.eye(4), (points, 1, 1))
    poses[:, 0, 3], poses[:, 2, 3] = t * span, low + rise * (1.0 - (2.0 * t) ** 2)
    pitch = np.radians(pitch_deg)
    axis = np.array([0.0, np.cos(pitch), np.sin(pitch)])
    poses[:, :3, 0], poses[:, :3, 1] = axis, [-1.0, 0.0, 0.0]
    poses[:, :3, 2] = np.cross(axis, [-1.0, 0.0, 0.0])
    return poses


def arched(points: int = 200, **shape: float) -> ToolPath:
    """The path through `arched_poses`."""
    return tool_path(arched_poses(points, **shape), longest_step=0.2)


def stands(x: tuple[float, float, int], y: tuple[float, float, int], headings: int = 1) -> FloatArray:
    """A grid of base poses (b, 3)."""
    turns = np.linspace(-np.pi, np.pi, headings, endpoint=False) if headings > 1 else np.zeros(1)
    grid = np.meshgrid(np.linspace(*x), np.linspace(*y), turns, indexing="ij")
    return np.stack(grid, axis=-1).reshape(-1, 3)


def five_joint_urdf() -> str:
    """Yaw, three pitches and a roll, with the figures of `PitchArm`, and a kilogram for each link."""
    links = "".join(
        f'<link name="{name}"><inertial><mass value="1"/><origin xyz="{x} 0 0"/>'
        '<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        for name, x in [("base", 0), ("a", 0), ("b", 0.27), ("c", 0.27), ("d", 0), ("e", 0.1), ("hand", 0)]
    )
    joints = "".join(
        f'<joint name="j{number}" type="revolute"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{xyz}"/><axis xyz="{axis}"/>'
        f'<limit lower="{low}" upper="{high}" velocity="1.5" effort="60"/></joint>'
        for number, parent, child, xyz, axis, low, high in [
            (1, "base", "a", "0.35 0 0.8", "0 0 1", -2.618, 2.618),
            (2, "a", "b", "0 0 0", "0 -1 0", -3.1, 3.1),
            (3, "b", "c", "0.55 0 0", "0 -1 0", -3.1, 0.0),
            (4, "c", "d", "0.55 0 0", "0 -1 0", -3.1, 3.1),
            (5, "d", "e", "0 0 0", "1 0 0", -3.1, 3.1),
        ]
    )
    tip = '<joint name="tip" type="fixed"><parent link="e"/><child link="hand"/>'
    tip += '<origin xyz="0.25 0 0"/></joint>'
    return f'<robot name="five">{links}{joints}{tip}</robot>'
