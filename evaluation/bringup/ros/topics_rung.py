"""The step that holds the robot's file against the topics; nothing moves."""

from __future__ import annotations

from typing_extensions import override

from handcart.backends.ros2.air_check.air_report import listen
from handcart.evaluation.bringup.rung import Facts, Rung, RungFailed

from .ros_site import RosSite


class TopicsRung(Rung[RosSite]):
    """Bring-up step that checks that all ROS topics of the robot's file exist and fit that file."""

    name = "topics"
    summary = "each topic is on the air and as the file says; rates, gaps and ages of stamps are recorded"
    moves = False

    @override
    def climb(self, site: RosSite) -> Facts:
        with site.air() as (link, wait):
            report = listen(site.robot, site.spec, link, wait)
        if report.faults:
            raise RungFailed("; ".join(fault.words for fault in report.faults))
        for remark in report.remarks:
            site.operator.tell(f"   {remark.words}")
        return {
            topic.topic: {
                "rate_hz": round(topic.rate_hz, 2),
                "max_gap_ms": round(1e3 * topic.max_gap_s, 1),
                "age_ms": None if topic.age_s is None else round(1e3 * topic.age_s, 2),
                "nodes": report.nodes[topic.topic],
            }
            for topic in report.topics
        }
