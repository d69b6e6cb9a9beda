"""`handcart node`: runs requested, acknowledged and resumed from ROS 2."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

STATE_PERIOD_S = 0.5


def node(
    tasks: Annotated[list[Path], typer.Argument(help="tasks that can be requested: files, or their names")],
    runs: Annotated[Path, typer.Option(help="where the runs' folders are")] = Path("runs"),
    backend: Annotated[str | None, typer.Option(help="another backend than the tasks name")] = None,
    robot: Annotated[str | None, typer.Option(help="another robot than the tasks name")] = None,
    namespace: Annotated[str, typer.Option(help="namespace of the services and topics")] = "",
) -> None:
    """Offer ROS 2 services that start or resume runs, one at a time, until Ctrl-C; a running run goes on
    after that.
    """
    from handcart.backends.ros2.wire.ros_link import node_name
    from handcart.backends.ros2.wire.serving_link import RosServingLink
    from handcart.evaluation.viewing.node.door import SERVICE_PREFIX
    from handcart.files.errors import FileError
    from handcart.networks.task.preparing import check
    from handcart.tasks.task_names import task_path
    from handcart.tools.terminal.asked_to_end import AskedToEnd

    from .run_desk import RunDesk, service_names, state_text

    named = service_names([task_path(path) for path in tasks])
    given = {} if robot is None else {"robot": robot}
    for task in named.values():
        if errors := check(task, backend, given).errors:
            raise FileError(errors)
    options = {"--backend": backend, "--robot": robot}
    words = [word for key, value in options.items() if value for word in (key, value)]
    link = RosServingLink(node_name("desk"), namespace)
    desk, over, last = (
        RunDesk(named, runs, words, ["--node-namespace", namespace] if namespace else []),
        AskedToEnd(),
        "",
    )
    publish = link.latched("std_msgs/String", f"{SERVICE_PREFIX}/desk")
    desk.offer(link)
    for name in named:
        print(f"ros2 service call {namespace}/{SERVICE_PREFIX}/run/{name} std_srvs/srv/Trigger", flush=True)
    try:
        while not over:
            text = state_text(desk.state())
            if text != last:
                message, last = link.message("std_msgs/String"), text
                message.data = text
                publish(message)
            link.spin(STATE_PERIOD_S)
    finally:
        link.close()
    raise typer.Exit(over.status)
