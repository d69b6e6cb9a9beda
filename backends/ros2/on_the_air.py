"""Comparison of the topics on the air with the robot's file."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence

from handcart.backends.ros2.wire.ros_errors import NotOnTheAir
from handcart.backends.ros2.wire.ros_link import Link

from .goal_stream import GoalStream
from .ros_gps import RosGps
from .ros_topics import RosTopics
from .wire.topic_sensor import TopicSensor

DISCOVERY_S = 1.0  # in which nearly all nodes on a network find each other
LATE_DISCOVERY_S = 3.0
"""Time in [s] after which no driver is expected any more that was on the air before."""
PAUSE_S = 0.02


def await_robot(
    topics: RosTopics,
    link: Link,
    seconds: float,
    sleep: Callable[[float], None],
    discovery_s: float = 0.0,
) -> None:
    """Wait for the first message of each topic, and for a subscriber to each command topic.

    Args:
        topics: topics of the robot's file.
        link: connection to these topics.
        seconds: longest wait for all messages and subscribers, in [s].
        sleep: function that waits a number of seconds.
        discovery_s: shortest wait, in which other nodes that publish commands are discovered, in [s].

    Raises:
        NotOnTheAir: topics are missing, differ from the robot's file, another node publishes commands, or two
            nodes publish readings; the error lists all of them. No command has been sent.
    """
    begun = link.clock()
    while True:
        link.receive()
        topics.advance()
        missing = [*_silent(topics), *_deaf(topics, link)]
        if not missing and link.clock() - begun >= discovery_s:
            break
        if missing and link.clock() - begun > seconds:
            raise NotOnTheAir(list(_findings(topics, link)))
        sleep(PAUSE_S)
    if others := [*other_masters(topics, link), *doubled_readings(topics, link)]:
        raise NotOnTheAir(others)


def refuse_masters(
    topics: Sequence[str], link: Link, discovery_s: float, sleep: Callable[[float], None]
) -> None:
    """Look for other nodes that publish commands, before this program's node does.

    A run that is under way would take a second node on its command topics for a rival, and stop.

    Args:
        topics: names of the command topics.
        link: connection that has published none of them.
        discovery_s: time after the robot's drivers are seen in which other nodes are discovered, in [s].
        sleep: function that waits a number of seconds.

    Raises:
        NotOnTheAir: another node publishes commands; the error names topics and nodes.
    """
    begun, seen, is_first = link.clock(), math.inf, True
    while True:
        found = {topic: sorted(nodes) for topic in topics if (nodes := link.publishers(topic))}
        if found and is_first:
            sleep(discovery_s)  # the first look may find nodes without a name yet
            is_first = False
        elif found:
            hint = "is another run under way, or was one killed in the last 20 s?"
            allowed = f"allowed: this program alone; {hint}"
            raise NotOnTheAir(
                [f"{topic}: {', '.join(nodes)} publishes it; {allowed}" for topic, nodes in found.items()]
            )
        now = link.clock()
        seen = min(seen, now) if any(map(link.listeners, topics)) else seen
        if now - seen >= discovery_s or (seen > now and now - begun >= LATE_DISCOVERY_S):
            return
        sleep(PAUSE_S)


def other_masters(topics: RosTopics, link: Link) -> Iterator[str]:
    """Yield a message for each command topic or action to which another program sends commands as well."""
    for topic in topics.commands:
        nodes = link.publishers(topic)
        if len(nodes) > 1:
            names = ", ".join(sorted(nodes))
            yield f"{topic}: {len(nodes)} nodes publish it ({names}); allowed: this one alone"
    yield from (stream.rival for stream in topics.streams if stream.rival)


def restarted_servers(topics: RosTopics) -> Iterator[str]:
    """Yield a message for each action with another server than at the start."""
    yield from (stream.restart for stream in topics.streams if stream.restart)


def ended_drivers(topics: RosTopics, link: Link) -> Iterator[str]:
    """Yield a message for each topic whose driver may be silent, but is not on the air any more."""
    for sensor in topics.sensors:
        may_be_silent = isinstance(sensor, RosGps) and sensor.is_silent_without_fix
        if may_be_silent and not link.publishers(sensor.source.topic):
            yield f"{sensor.name}: nobody publishes it any more"


def doubled_readings(topics: RosTopics, link: Link) -> Iterator[str]:
    """Yield a message for each topic of readings that several nodes publish: their readings alternate.

    Two nodes are no fault if the robot's file names the frame of the topic and only one of them uses it.
    """
    for sensor in topics.sensors:
        nodes = sorted(node for node in link.publishers(sensor.source.topic) if f"({sensor.KIND})" in node)
        is_filtered = sensor.source.frame is not None and sensor.has_other_frames
        if len(nodes) < 2 or not sensor.HAS_ONE_NODE or is_filtered:
            continue
        words = f"{sensor.name}: {len(nodes)} nodes publish it ({', '.join(nodes)}); allowed: one"
        hint = ". Was it started twice, or killed in the last 20 s?" if len(set(nodes)) < len(nodes) else ""
        yield f"{words}, or its `frame` in the robot's file{hint}"


def _silent(topics: RosTopics) -> list[TopicSensor]:
    return [sensor for sensor in topics.sensors if sensor.age is None]


def _deaf(topics: RosTopics, link: Link) -> list[str]:
    """Return the topics of commands without a subscriber, as texts; commands to joints that no message names
    count, too.
    """
    unknown = [] if topics.states is None or not topics.states.missing else [topics.states.missing]
    return [*unheard(topics, link), *unknown]


def empty_air(topics: RosTopics, link: Link) -> str:
    """Return where drivers were looked for, as text, if the air has none of the robot's; "" otherwise."""
    readings = {sensor.source.topic for sensor in topics.sensors}
    kinds = {sensor.KIND for sensor in topics.sensors}
    others = (topic for kind in kinds for topic in link.topics_of(kind))
    if not link.place or any(map(link.publishers, (*readings, *others))):
        return ""
    return (
        f"no driver of the robot is on the air in {link.place}; needed: running drivers, and their domain"
        " (ROS_DOMAIN_ID, or `domain` in the section ros2)"
    )


def _findings(topics: RosTopics, link: Link) -> Iterator[str]:
    if where := empty_air(topics, link):
        yield where
    for sensor in _silent(topics):
        yield silence(sensor, link)
    for topic in unheard(topics, link):
        yield deafness(topics, link, topic)
    if topics.states is not None and topics.states.age is not None and topics.states.missing:
        yield topics.states.missing


def unheard(topics: RosTopics, link: Link) -> list[str]:
    """Return the names of command topics without a subscriber of the right message type, and of actions
    without a server.

    In ROS, a node that subscribes with another message type receives nothing, and no error is reported.
    """
    deaf = [
        topic
        for topic, kind in topics.commands.items()
        if not any(f"({kind})" in listener for listener in link.listeners(topic))
    ]
    return deaf + [stream.name for stream in topics.streams if not stream.sender.is_ready()]


def deafness(topics: RosTopics, link: Link, topic: str) -> str:
    """Return a message that states why commands to `topic`, a command topic or action, do not arrive."""
    for stream in topics.streams:
        if stream.name == topic:
            return _no_server(stream, link)
    kind, others = topics.commands[topic], link.listeners(topic)
    if others:
        return f"{topic}: {', '.join(others)} listens, but {kind} is sent; change `type`"
    heard = [text for text in link.topics_of(kind) if link.listeners(text)]
    hint = f"; there are {', '.join(heard)}" if heard else ""
    return f"{topic}: nobody listens to it; needed: a controller or driver that takes {kind}{hint}"


def _no_server(stream: GoalStream, link: Link) -> str:
    """Return why no goal of an action arrives."""
    if others := link.action_servers(stream.name):
        return f"{stream.name}: {', '.join(others)} serves it; needed: {stream.kind}"
    served = link.actions_of(stream.kind)
    hint = f"; there are {', '.join(served)}" if served else ""
    return f"{stream.name}: nobody serves the action; needed: a controller that takes {stream.kind}{hint}"


def silence(sensor: TopicSensor, link: Link) -> str:
    """Return a message that states why no valid readings arrive on the topic of a sensor."""
    topic, kind = sensor.source.topic, sensor.KIND
    if sensor.doubt and not sensor.rejected:
        return f"{sensor.name}: {sensor.doubt}"
    if sensor.rejected:
        return f"{sensor.name}: {sensor.rejected} messages were no good; of the last one, {sensor.doubt}"
    nodes = link.publishers(topic)
    if nodes and not any(f"({kind})" in node for node in nodes):
        return f"{sensor.name}: its type is not {kind}: {', '.join(nodes)}"
    if nodes:
        return f"{sensor.name}: {', '.join(nodes)} publishes it, but no message arrives"
    others = [text for text in link.topics_of(kind) if link.publishers(text)]
    hint = f"; there are {', '.join(others)}" if others else f"; no topic has the type {kind}"
    return f"{sensor.name}: nobody publishes it{hint}"
