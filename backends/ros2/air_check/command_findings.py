"""Findings about each topic of commands: a driver takes it, and this program alone sends."""

from __future__ import annotations

from collections.abc import Iterator

from handcart.backends.ros2.on_the_air import deafness, unheard

from .air_finding import AirFinding
from .heard_robot import HeardRobot


def command_findings(heard: HeardRobot) -> Iterator[AirFinding]:
    """Yield the faults of command topics and actions.

    A fault is a missing subscriber, a different quality of service, or a second node that sends commands.
    """
    link, deaf = heard.link, unheard(heard.topics, heard.link)
    for topic in heard.topics.commands:
        key = ("ros2", _key_of(heard, topic))
        if topic in deaf:
            yield AirFinding(key, deafness(heard.topics, link, topic))
        for why in link.mismatches(topic, is_command=True):
            yield AirFinding(key, f"{topic}: no command arrives by its quality of service: {why}")
        if others := link.publishers(topic):
            names = ", ".join(sorted(others))
            yield AirFinding(key, f"{topic}: {names} publishes it; allowed: nobody but this program")

    for stream in heard.topics.streams:
        if stream.name in deaf:
            yield AirFinding(("ros2", _key_of(heard, stream.name)), deafness(heard.topics, link, stream.name))
        if stream.rival:
            yield AirFinding(("ros2", _key_of(heard, stream.name)), stream.rival)


def _key_of(heard: HeardRobot, topic: str) -> str:
    spec = heard.spec
    fingers = spec.gripper.action or spec.gripper.topic
    return {spec.velocity.topic: "velocity", fingers: "gripper"}.get(topic, "arm")
