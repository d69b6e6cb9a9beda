"""Header of a run's journal."""

from __future__ import annotations

import hashlib
import os
import time
from collections.abc import Mapping
from datetime import time as time_of_day
from importlib.metadata import version
from pathlib import Path
from typing import Any

import orjson

from handcart.backends.description.robot_file import RobotFile
from handcart.networks.graph.network import Action, ActionNetwork
from handcart.networks.journal.journal import JOURNAL_SCHEMA
from handcart.networks.journal.retracing import has_fingerprint
from handcart.networks.operator.permits import Mode
from handcart.networks.task.preparing import Prepared
from handcart.primitives.restoring.patience import NO_PATIENCE

_KEYS = ("do", "from", "to", "on_fail", "cost_s", "attempts", "uses", "permit", "time_out_s", "with")
_CHANCE_KEYS = ("p", "p_give_up", "others", "unlimited", "renewals", "fresh_after", "budget", "fails")
"""Columns of networks with probabilities, several results or shared attempts."""
_BOOT = Path("/proc/sys/kernel/random/boot_id")


def header(prepared: Prepared, begins_at: time_of_day | None = None) -> dict[str, Any]:
    """Return the fields of a journal's first record, RUN, with task, network, robot, backend and seed.

    They are equal in two runs of the same task with the same seed.

    Args:
        prepared: the prepared run.
        begins_at: time of day at which a simulated run begins; None if the robot is real, or the task has
            no times of day.
    """
    task = prepared.task
    return {
        "schema": JOURNAL_SCHEMA,
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
        **({} if begins_at is None else {"begins_at": begins_at.isoformat()}),
    }


def network_fields(network: ActionNetwork) -> dict[str, Any]:
    """Return a network as fields that can be written as JSON.

    `actions` is a table, whose columns `keys` names. The column `uses` has the entries of the world model
    that a primitive may read; `do` is null for a skip. `elements` maps a situation to its element of a
    `repeat`.
    """
    more = any(
        action.p is not None or action.others or action.fail_endings or _counts_otherwise(action)
        for action in network.actions
    )
    rows = [
        (
            a.binding and a.do,
            *(a.source, a.target, a.on_fail, a.cost_s, a.attempts, _uses(a), a.permit, a.time_out_s),
            a.binding.given() if a.binding else {},
            *(_chance_fields(a) if more else ()),
        )
        for a in network.actions
    ]
    facts = {situation.name: dict(situation.facts) for situation in network.situations.values()}
    return {
        "start": network.start,
        "goal": network.goal,
        "situations": facts,
        "elements": {s.name: s.element for s in network.situations.values() if s.element is not None},
        "keys": (*_KEYS, *_CHANCE_KEYS) if more else _KEYS,
        "actions": rows,
        **_aims(network),
    }


def is_of_network(header: Mapping[str, Any], network: ActionNetwork) -> bool:
    """Return whether a journal's first record was written for a network.

    The checksums of both networks are compared first. They also differ if a later version of a primitive has
    further parameters; therefore the networks themselves are compared next, without parameters that have
    their default values.
    """
    if has_fingerprint(header, network):
        return True
    kept = header.get("plan_on")
    if not isinstance(kept, Mapping):
        return False
    try:
        return _by_names(kept) == _by_names(orjson.loads(orjson.dumps(network_fields(network))))
    except (LookupError, TypeError, ValueError):  # a damaged header is of no network
        return False


def _by_names(fields: Mapping[str, Any]) -> dict[str, Any]:
    """Return the fields of a network with actions by column name, without `uses`, which may change."""
    rows = [dict(zip(fields["keys"], row, strict=True)) for row in fields["actions"]]
    for row in rows:
        row.pop("uses", None)
    return {**fields, "keys": None, "actions": rows}


def _counts_otherwise(action: Action) -> bool:
    return action.unlimited or bool(action.fresh_after) or bool(action.budget)


def _chance_fields(action: Action) -> tuple[Any, ...]:
    others = [[other.target, other.result, other.p] for other in action.others]
    counted = action.unlimited, action.renewals, action.fresh_after, action.budget
    fails = [[ending.cause, ending.target, ending.p] for ending in action.fail_endings]
    return action.p, action.p_give_up, others, *counted, fails


def _aims(network: ActionNetwork) -> dict[str, Any]:
    """Return the optional fields of a network: policy, beliefs, repeated restoring, aims, `otherwise`."""
    aims: dict[str, Any] = {}
    if network.policy != "rule":
        aims = {"policy": network.policy, "person_s": network.person_s}
    if network.belief is not None:
        aims["belief"] = {"attempts": network.belief.attempts, "entries": list(network.belief.entries)}
    if network.restoring != NO_PATIENCE:
        aims["restoring"] = list(network.restoring)
    aims |= network.aims.fields()
    return {**aims, "otherwise": network.otherwise} if network.otherwise else aims


def _uses(action: Action) -> list[str]:
    if action.binding is None:
        return []
    kind = action.binding.kind
    return sorted({*kind.reads, *kind.writes, *(key.split(".")[0] for key in action.binding.late.values())})


def robot_fingerprint(spec: RobotFile) -> str:
    """Return a checksum of all keys of a robot's file that differ from their defaults, in hexadecimal.

    A key that a later version adds, with a default, does not change it, so that older runs can be resumed.
    """
    return hashlib.sha256(spec.model_dump_json(exclude_defaults=True).encode()).hexdigest()


def process_facts(permits: Mode) -> dict[str, Any]:
    """Return process ID, boot ID, hash seed, monotonic time in [s] and rule for permissions of a process,
    for a journal's records RUN and EPOCH.

    They differ between two runs with the same seed, and are not part of the journal's chain of checksums.

    Args:
        permits: what happens to actions that need the operator's permission.
    """
    return {
        "monotonic_s": round(time.monotonic(), 6),
        "pid": os.getpid(),
        "boot_id": boot_id(),
        "hash_seed": os.environ.get("PYTHONHASHSEED"),
        "permits": permits,
    }


def boot_id() -> str | None:
    """Return an identifier that changes with each start of the machine; None if the system has none."""
    return _BOOT.read_text().strip() if _BOOT.exists() else None
