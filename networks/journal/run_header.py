"""What a run's journal begins with."""

from __future__ import annotations

import hashlib
import os
import time
from importlib.metadata import version
from pathlib import Path
from typing import Any

from handcart.backends.description.robot_file import RobotFile
from handcart.networks.graph.journaled_network import network_fields
from handcart.networks.task.preparing import Prepared

from .journal import SCHEMA

_BOOT = Path("/proc/sys/kernel/random/boot_id")


def header(prepared: Prepared) -> dict[str, Any]:
    """The fields of the record RUN: task, network, robot, backend, seed; equal in two runs of one seed."""
    task = prepared.task
    return {
        "schema": SCHEMA,
        "handcart": version("handcart"),
        "task": task.file.title,
        "task_path": str(Path(task.document.file).resolve()),
        "task_sha256": task.document.sha256,
        "task_text": task.document.content.decode(),
        "settings": dict(prepared.settings),
        "network": task.network.fingerprint(),
        "start": task.network.start,
        "plan_on": network_fields(task.network),
        "bound": task.network.bound(),
        "robot": task.file.robot,
        "robot_sha256": robot_fingerprint(prepared.robot.spec),
        "backend": prepared.backend_name,
        "bench": prepared.bench,
        "simulated": prepared.backend.simulated,
        "address": prepared.backend.address,
        "seed": prepared.seed,
        "errors": prepared.errors,
    }


def robot_fingerprint(spec: RobotFile) -> str:
    """A checksum of a robot's file, limits, tolerances and all, in hexadecimal."""
    return hashlib.sha256(spec.model_dump_json().encode()).hexdigest()


def process_facts() -> dict[str, Any]:
    """What RUN and EPOCH say of the process, outside the chain."""
    return {
        "monotonic_s": round(time.monotonic(), 6),
        "pid": os.getpid(),
        "boot_id": boot_id(),
        "hash_seed": os.environ.get("PYTHONHASHSEED"),
    }


def boot_id() -> str | None:
    """Another one each time that the machine starts; None where the system tells none."""
    return _BOOT.read_text().strip() if _BOOT.exists() else None
