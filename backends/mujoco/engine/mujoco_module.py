"""Import MuJoCo's Python module, or report how to install it."""

from __future__ import annotations

import logging
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from types import ModuleType

from handcart.files.errors import InputError


class MissingMuJoCo(InputError):
    """Error: MuJoCo isn't installed."""

    def __init__(self) -> None:
        super().__init__(
            "the backend 'mujoco' needs MuJoCo, which is not installed; "
            "install it with: pip install 'handcart[sim]'"
        )


@cache
def mujoco() -> ModuleType:
    """Return the module `mujoco`; raises `MissingMuJoCo`."""
    if find_spec("mujoco") is None:
        raise MissingMuJoCo
    module = import_module("mujoco")
    # Without this, MuJoCo writes them into MUJOCO_LOG.TXT in the current folder.
    module.set_mju_user_warning(logging.getLogger(__name__).info)
    return module
