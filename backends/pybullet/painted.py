"""What a block and a sheet of paper look like to Bullet's renderers."""

from __future__ import annotations

import numpy as np

from handcart.backends.scene.block import Block
from handcart.backends.scene.mark import Mark
from handcart.robotics.geometry.transform import transform

from .box_mesh import box_mesh
from .physics import Physics, placed

_SHADE = (0.6, 0.6, 0.75, 0.75, 1.1, 0.4)  # of a block's faces, as if light came from above
_STRIP = 32  # width of one shade in the picture [px]
_OFF = 2e-4  # [m] that a sheet lies above what it is painted on
_FLAT = ((0.5, 0.5),) * 4
_LEVEL = 1  # of a mark's pictures: the renderer takes the nearest points of a finer one


def painted_block(physics: Physics, block: Block) -> tuple[int, int]:
    """Visual shape and texture of a block: each face has a grey of its own."""
    shades = [min(255, round(block.spec.grey * share)) for share in _SHADE]
    picture = np.repeat(np.array([shades], np.uint8), _STRIP, axis=1)
    picture = np.repeat(picture, _STRIP, axis=0)
    uvs = [(((face + 0.5) / len(shades), 0.5),) * 4 for face in range(len(shades))]
    return box_mesh(physics, block.size, uvs), physics.load_texture(picture)


def add_mark(physics: Physics, mark: Mark) -> int:
    """A printed sheet that can be seen and not touched."""
    picture, metres = mark.levels()[_LEVEL]
    height, width = (size * metres for size in picture.shape)
    sheet = [_FLAT] * 4 + [((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)), _FLAT]
    visual = box_mesh(physics, (width, height, _OFF), sheet)
    pose = mark.pose @ transform((0.0, 0.0, _OFF / 2))
    p, client = physics.p, physics.client
    body = int(p.createMultiBody(0.0, -1, visual, *placed(pose), physicsClientId=client))
    texture = physics.load_texture(picture)
    p.changeVisualShape(body, -1, textureUniqueId=texture, physicsClientId=client)
    return body
