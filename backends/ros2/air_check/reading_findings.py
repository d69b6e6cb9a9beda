"""Findings about each topic of readings: there, one publisher, fresh, fast enough, in one frame."""

from __future__ import annotations

from collections.abc import Iterator

from handcart.backends.ros2.frame_odometry import FrameOdometry
from handcart.backends.ros2.joint_states import JointStates
from handcart.backends.ros2.on_the_air import silence
from handcart.backends.ros2.ros_base import OdometryTopic
from handcart.backends.ros2.wire.ros_errors import NotOnTheAir
from handcart.backends.ros2.wire.topic_sensor import TopicSensor

from .air_finding import AirFinding
from .heard_robot import HeardRobot
from .topic_meter import MeasuredTopic

RATE_MARGIN = 0.9
"""Share of the control rate below which a topic is called slow."""


def reading_findings(heard: HeardRobot) -> Iterator[AirFinding]:
    """Yield all findings about the topics with sensor readings, such as missing, late or invalid messages."""
    for key, sensor in heard.sensors():
        place = ("ros2", key)
        measured = heard.link.meters[sensor.source.topic].measured()
        if sensor.age is None:
            yield AirFinding(place, silence(sensor, heard.link))
        elif refusals := heard.refusals.get(sensor.source.topic):
            why, _ = refusals.most_common(1)[0]
            count = sum(refusals.values())
            words = f"{sensor.name}: {count} of {measured.messages} messages are refused: {why}"
            yield AirFinding(place, words)
        for words in _wire_words(heard, sensor):
            yield AirFinding(place, words)
        if sensor.age is not None:
            yield from _timing(heard, key, sensor, measured)
    if heard.topics.odometry.jumped:
        yield AirFinding(("ros2", "odometry"), heard.topics.odometry.jumped)
    yield from _joints(heard)


def _wire_words(heard: HeardRobot, sensor: TopicSensor) -> Iterator[str]:
    """Yield the faults that the graph of nodes shows for a topic, as text."""
    topic = sensor.source.topic
    nodes = heard.link.publishers(topic)
    kinds = {node.rpartition(" ")[2] for node in nodes}
    if len(kinds) > 1:
        yield f"{sensor.name}: nodes publish different types: {', '.join(nodes)}; allowed: {sensor.KIND}"
    elif len(nodes) > 1 and not isinstance(sensor, JointStates | FrameOdometry):
        yield f"{sensor.name}: {len(nodes)} nodes publish it ({', '.join(nodes)}); allowed: one"
    for why in heard.link.mismatches(topic, is_command=False):
        yield f"{sensor.name}: no message arrives by its quality of service: {why}"


def _timing(
    heard: HeardRobot, key: str, sensor: TopicSensor, measured: MeasuredTopic
) -> Iterator[AirFinding]:
    place, source = ("ros2", key), sensor.source
    if 1e3 * measured.max_gap_s > source.stale_ms:
        yield AirFinding(
            (*place, "stale_ms"),
            f"{sensor.name}: no message for {1e3 * measured.max_gap_s:.0f} ms;"
            f" allowed: {source.stale_ms:.0f} ms (stale_ms)",
        )
    if len(measured.frames) > 1:
        frames = ", ".join(map(repr, measured.frames))
        yield AirFinding(place, f"{sensor.name}: its messages are in the frames {frames}; allowed: one")
    wanted = RATE_MARGIN / heard.robot.period_s
    if isinstance(sensor, OdometryTopic | JointStates) and 0.0 < measured.rate_hz < wanted:
        yield AirFinding(
            place,
            f"{sensor.name}: {measured.rate_hz:.1f} Hz; the control runs at {1.0 / heard.robot.period_s:.0f}"
            " Hz, and moves between its readings",
            is_fault=False,
        )
    age = measured.oldest_s
    if not heard.spec.same_clock and age is not None and 1e3 * abs(age) > source.stale_ms:
        yield AirFinding(place, f"{sensor.name}: its stamps differ by {age:.3g} s from this clock", False)


def _joints(heard: HeardRobot) -> Iterator[AirFinding]:
    states = heard.topics.states
    if states is None or states.age is None:
        return
    if states.jumped:
        yield AirFinding(("ros2", "joint_states"), states.jumped)
    if states.missing:
        yield AirFinding(("ros2", "joint_states"), states.missing)
    elif states.is_fresh and heard.topics.arm is not None:
        try:
            heard.topics.arm.begin()
        except NotOnTheAir as beyond:
            for words in beyond.findings:
                yield AirFinding(("ros2", "reversed"), words)
