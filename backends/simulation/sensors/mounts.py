"""Where a sensor is mounted, by the URDF."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from handcart.robotics.geometry.transform import Transform
from handcart.robotics.kinematics.urdf_tree import kinematic_urdf


def base_T_frame(urdf_text: str, frame: str, base: str = "base") -> Transform:
    """Pose (4, 4) of a URDF's link in the link `base`, all joints at zero.

    Raises:
        ValueError: the URDF has no such link.
    """
    model = pin.buildModelFromXML(kinematic_urdf(urdf_text))
    if not model.existFrame(frame):
        raise ValueError(f"the URDF has no link {frame!r}")
    data = model.createData()
    pin.framesForwardKinematics(model, data, pin.neutral(model))
    root_T_base, root_T_frame = (data.oMf[model.getFrameId(name)] for name in (base, frame))
    return np.asarray((root_T_base.inverse() * root_T_frame).homogeneous)
