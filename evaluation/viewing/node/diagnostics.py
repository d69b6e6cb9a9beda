"""State of a run as `diagnostic_msgs`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from handcart.backends.ros2.wire.messages import set_stamp
from handcart.backends.ros2.wire.serving_link import ServingLink

OK, WARN, ERROR = b"\0", b"\1", b"\2"
WAITING_STATES = ("waiting for permission", "paused while acting", "paused while restoring", "restoring")
GOOD_OUTCOMES = ("Success", "Cancelled")


def level_of(status: Mapping[str, Any]) -> bytes:
    """Return the diagnostic level of a run's status: `OK`, `WARN` or `ERROR`.

    `ERROR` means an error, a GiveUp, or a run that does not answer. `WARN` means a run that waits for a
    person, is paused or restores, or that ended in any other way than Success or by cancelling.
    """
    if status.get("error") or (outcome := status.get("outcome")) in ("GiveUp", "Error"):
        return ERROR
    if outcome is not None:
        return OK if outcome in GOOD_OUTCOMES else WARN
    return WARN if status.get("state") in WAITING_STATES else OK


def summary_of(status: Mapping[str, Any]) -> str:
    """Return a run's status as a short text: error, outcome or state, with reason or question."""
    if status.get("error"):
        return str(status["error"])
    words = str(status.get("outcome") or status.get("state"))
    if status.get("reason"):
        return f"{words}: {status['reason']}"
    asks = status.get("asks")
    return f"{words}: {asks['do']} from {asks['from']}" if asks else words


def diagnostics_message(link: ServingLink, hardware: str, status: Mapping[str, Any]) -> Any:
    """Return a ROS message `DiagnosticArray` with the status of a run as its only entry.

    Args:
        link: connection to ROS 2, which creates the message.
        hardware: name of the robot.
        status: status of the run, as the run's own node publishes it.
    """
    entry = link.message("diagnostic_msgs/DiagnosticStatus")
    entry.name, entry.hardware_id = "handcart: run", hardware
    entry.level, entry.message = level_of(status), summary_of(status)
    keys = ("task", "situation", "state", "outcome", "acting", "actions", "sim_time_s", "run")
    entry.values = [_value(link, key, status[key]) for key in keys if status.get(key) is not None]
    message = link.message("diagnostic_msgs/DiagnosticArray")
    set_stamp(message.header, link.now())
    message.status = [entry]
    return message


def _value(link: ServingLink, key: str, value: Any) -> Any:
    entry = link.message("diagnostic_msgs/KeyValue")
    entry.key, entry.value = key, str(value)
    return entry
