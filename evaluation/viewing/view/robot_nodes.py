"""Robot in the page: the visual bodies of its URDF, moved by its joints."""

from __future__ import annotations

import logging
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from handcart.evaluation.viewing.playback.scenery import RobotShape
from handcart.evaluation.viewing.playback.seven import sevens, transforms
from handcart.robotics.geometry.transform import Transform, inverse
from handcart.robotics.numerics.arrays import FloatArray

if TYPE_CHECKING:
    import viser

ROOT_NODE = "/robot"
BASE_LINK = "base"
FINGER_JOINTS = ("left_finger", "right_finger")


class RobotNodes:
    """Nodes of the web page's 3D view that draw the robot; they are created once and then only moved."""

    def __init__(self, server: viser.ViserServer, shape: RobotShape) -> None:
        """Draw the robot with its base at the world's origin; meshes that are not on this machine are
        omitted.
        """
        from viser.extras import ViserUrdf

        self._shape = shape
        self._root = server.scene.add_frame(ROOT_NODE, show_axes=False)
        self._urdf = _loaded(shape.urdf)
        self._drawn = ViserUrdf(server, self._urdf, root_node_name=ROOT_NODE)
        self._actuated = {name: k for k, name in enumerate(self._urdf.actuated_joint_names)}
        self._configuration = np.zeros(len(self._actuated))
        self._urdf.update_cfg(self._configuration)
        links = self._urdf.link_map
        base = BASE_LINK if BASE_LINK in links else self._urdf.base_link
        self._base_T_root: Transform = inverse(self._urdf.get_transform(base))

    def move(self, base: FloatArray, joints: FloatArray, width: float) -> None:
        """Move the robot that is drawn in the view to a pose and posture.

        Args:
            base: (7,) world_T_base: x, y, z in [m], and a unit quaternion w, x, y, z.
            joints: (j,) joint positions of the arm, in [rad] or [m].
            width: opening of the gripper, in [m].
        """
        pose = sevens((transforms(base[None])[0] @ self._base_T_root)[None])[0]
        self._root.position, self._root.wxyz = pose[:3], pose[3:]
        values = dict(zip(self._shape.joints, joints.tolist(), strict=False))
        values |= dict.fromkeys(FINGER_JOINTS, width / 2)
        configuration = self._configuration.copy()
        for name, value in values.items():
            if name in self._actuated:
                configuration[self._actuated[name]] = value
        if not np.array_equal(configuration, self._configuration):
            self._configuration = configuration
            self._drawn.update_cfg(configuration)


def _loaded(text: str) -> Any:
    import yourdfpy

    logging.getLogger("yourdfpy").setLevel(logging.CRITICAL)  # `handcart check` reports faults of a URDF
    return yourdfpy.URDF.load(
        StringIO(text),
        build_scene_graph=True,
        load_meshes=True,
        filename_handler=_mesh,
    )


def _mesh(name: str) -> str:
    """Return the path of a mesh file."""
    return str(Path(name.removeprefix("file://")))
