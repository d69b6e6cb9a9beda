"""The node of one run: `handcart run --node` and `handcart resume --node`."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from handcart.networks.events.run_observer import RunObserver

DISCOVERY_S = 1.5
"""[s] in which another run's node is looked for."""


@contextmanager
def opened_node(namespace: str, say: Callable[[str], None], ghost_s: float = 0.0) -> Iterator[RunObserver]:
    """Yield an observer that publishes a run as a ROS 2 node, with services for the operator.

    Args:
        namespace: namespace of the node's topics and services; "" for none.
        say: function that receives messages for the user.
        ghost_s: time, in [s], to wait until the node of a killed program disappears.

    Raises:
        NoRos: rclpy is not installed.
        SecondNode: another run has a node in that namespace.
    """
    from handcart.backends.ros2.wire.ros_link import node_name
    from handcart.backends.ros2.wire.serving_link import RosServingLink
    from handcart.evaluation.viewing.node.run_node import RunNode, check_alone

    link = RosServingLink(node_name("run"), namespace)
    try:
        check_alone(link, DISCOVERY_S, ghost_s, say)
        yield RunNode(link, say)
    finally:
        link.close()
