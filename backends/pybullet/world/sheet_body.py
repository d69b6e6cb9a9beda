"""A sheet of paper in Bullet."""

from __future__ import annotations

from handcart.backends.pybullet.physics import Physics, placed
from handcart.backends.simulation.world.sheet import Sheet
from handcart.robotics.geometry.transform import transform

from .box_mesh import box_mesh

_OFF = 2e-4  # [m] that a sheet lies above what it is painted on
_FLAT = ((0.5, 0.5),) * 4
_LEVEL = 1  # of its pictures: the renderer takes the nearest points of a finer one


def add_sheet(physics: Physics, paper: Sheet) -> int:
    """A printed sheet that can be seen and not touched."""
    picture, metres = paper.levels[min(_LEVEL, len(paper.levels) - 1)]
    height, width = (size * metres for size in picture.shape)
    sheet = [_FLAT] * 4 + [((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)), _FLAT]
    visual = box_mesh(physics, (width, height, _OFF), sheet)
    pose = paper.pose @ transform((0.0, 0.0, _OFF / 2))
    p, client = physics.p, physics.client
    body = int(p.createMultiBody(0.0, -1, visual, *placed(pose), physicsClientId=client))
    texture = physics.texture(picture)
    p.changeVisualShape(body, -1, textureUniqueId=texture, physicsClientId=client)
    return body
