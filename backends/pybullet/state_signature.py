"""Signature of Bullet's saved states.

Bullet's reader trusts a file, its sizes and pointers included, so it reads only files that this user's own
programs wrote for the same bodies. The signature is an HMAC with a key in the user's state folder.
"""

from __future__ import annotations

import hmac
import os
import secrets
import tempfile
from functools import cache
from pathlib import Path

from handcart.backends.saved_state import NotAState
from handcart.files.state_folder import state_folder

KEY_BYTES = 32
KEY_FILE = "checkpoint_key"


def sign(content: bytes, bodies: str) -> bytes:
    """Return a signature which proves that a program of this user saved the state of the described bodies.

    Args:
        content: bytes of the saved state.
        bodies: description of the bodies that the state belongs to.
    """
    return hmac.digest(_key(state_folder()), bodies.encode() + b"\n" + content, "sha256")


def check_signature(content: bytes, signature: bytes, bodies: str) -> None:
    """Check that a state was saved by the same user on this machine, for the same bodies.

    Args:
        content: bytes of the saved state.
        signature: result of `sign` that was saved with it.
        bodies: description of the present bodies.

    Raises:
        NotAState: another user or machine saved the state, it was changed, or the bodies are different.
    """
    if not hmac.compare_digest(sign(content, bodies), signature):
        raise NotAState(
            "no saved state: its signature is wrong; allowed: a state saved by the same user on this machine "
            "with the same version of Bullet for the same bodies"
        )


@cache
def _key(folder: Path) -> bytes:
    """Return the user's key, created if it is missing; where it can't be kept, a key of this process."""
    path = folder / KEY_FILE
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if not path.exists():
            _create(path)
        key = path.read_bytes()
    except OSError:
        return secrets.token_bytes(KEY_BYTES)
    return key if len(key) == KEY_BYTES else secrets.token_bytes(KEY_BYTES)


def _create(path: Path) -> None:
    """Create the key's file, complete from the beginning, unless another process was faster."""
    number, name = tempfile.mkstemp(dir=path.parent)  # readable for its owner alone
    try:
        with os.fdopen(number, "wb") as file:
            file.write(secrets.token_bytes(KEY_BYTES))
        os.link(name, path)
    except FileExistsError:
        pass
    finally:
        os.unlink(name)
