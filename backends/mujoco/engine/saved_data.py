"""MuJoCo's data kept, and brought back to the last bit."""

from __future__ import annotations

from typing import Any

import numpy as np

from handcart.backends.plain_values import from_plain
from handcart.backends.saved_state import NotAState
from handcart.robotics.numerics.arrays import FloatArray, IntArray

from .mujoco_module import mujoco

_FREE = 7  # coordinates of a body that moves as it will


def saved(model: Any, data: Any) -> dict[str, Any]:
    """Return MuJoCo's complete state for a checkpoint. It contains all that MuJoCo's integration needs
    (`mjSTATE_INTEGRATION`), and which kinematic trees sleep.
    """
    kind = mujoco().mjtState.mjSTATE_INTEGRATION
    values = np.zeros(mujoco().mj_stateSize(model, kind))
    mujoco().mj_getState(model, data, values, kind)
    return {"mujoco": values, "asleep": data.tree_asleep.astype(np.int64)}


def restore(model: Any, data: Any, state: dict[str, Any]) -> None:
    """Restore a state that `saved` returned for an equal model.

    Args:
        model: MuJoCo's model.
        data: MuJoCo's data, which the state replaces.
        state: result of `saved`.

    Raises:
        NotAState: the state is of another kind, or its model has other bodies.
    """
    if state.keys() != {"mujoco", "asleep"}:
        raise NotAState("no state of this engine; needed: mujoco, asleep, pinned, leans")
    values = from_plain(state["mujoco"], FloatArray, "engine")
    asleep = from_plain(state["asleep"], IntArray, "engine")
    mj, kind = mujoco(), mujoco().mjtState.mjSTATE_INTEGRATION
    if values.shape != (mj.mj_stateSize(model, kind),) or asleep.shape != (model.ntree,):
        raise NotAState("no saved state: the engine's world has other bodies")
    sleepers = np.flatnonzero(asleep >= 0)
    if not np.array_equal(np.sort(asleep[sleepers]), sleepers):  # MuJoCo follows each round of them
        raise NotAState("no saved state: those that sleep don't name each other in rounds")
    _send_to_sleep(model, data, values, asleep)
    mj.mj_setState(model, data, values, kind)
    data.tree_asleep[:] = asleep
    data.qacc[:] = data.qacc_smooth[:] = data.qacc_warmstart  # of sleepers a step hands it on as it is


def _send_to_sleep(model: Any, data: Any, values: FloatArray, asleep: IntArray) -> None:
    """Restore a state with its sleeping bodies asleep, given MuJoCo's state vector (n,) and `tree_asleep`
    (trees,).

    MuJoCo wakes a body that is moved while it sleeps. At a reset it places sleeping bodies at the model's
    initial positions, so those are set to the restored ones for the reset. Contacts are switched off
    meanwhile, because the robot's joints are at their zero then, and its arm would wake the bodies that it
    overlaps.
    """
    mj, flags = mujoco(), model.opt.disableflags
    first, policy = model.qpos0.copy(), model.tree_sleep_policy.copy()
    mj.mj_setState(model, data, values, mj.mjtState.mjSTATE_INTEGRATION)
    trees = model.body_treeid[model.jnt_bodyid]
    for joint in np.flatnonzero(asleep[trees] >= 0):
        at = int(model.jnt_qposadr[joint])
        count = _FREE if model.jnt_type[joint] == mj.mjtJoint.mjJNT_FREE else 1
        model.qpos0[at : at + count] = data.qpos[at : at + count]
    model.tree_sleep_policy[policy == mj.mjtSleepPolicy.mjSLEEP_INIT] = mj.mjtSleepPolicy.mjSLEEP_ALLOWED
    model.tree_sleep_policy[asleep >= 0] = mj.mjtSleepPolicy.mjSLEEP_INIT
    model.opt.disableflags = flags | mj.mjtDisableBit.mjDSBL_CONTACT
    mj.mj_resetData(model, data)
    model.opt.disableflags = flags
    model.qpos0[:], model.tree_sleep_policy[:] = first, policy
