"""All of the page: the world with the robot in it, and the panel."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from handcart.evaluation.playback.scenery import Scenery, ThingShape
from handcart.networks.journal.past_run import PastAction

from .frame import Frame
from .panel import Panel
from .robot_nodes import RobotNodes
from .world_nodes import WorldNodes

if TYPE_CHECKING:
    import viser

Array = NDArray[np.float64]
AWAY = np.array([-3.2, -3.6, 4.2])  # of the eye from the robot, at first [m]
BEFORE = np.array([0.4, 0.4, 0.0])  # share of the way to the robot: on a phone the panel covers what is below
FEWER = 2  # of the rays that hit something, every how many is drawn
OUTDOORS = 1.6  # times that far
LAYERS = {
    "range sensor": ("rays", "hits"),
    "planned path": ("planned",),
    "what it ran into": ("bumped",),
    "driven path": ("driven", "restored"),
}
ESTIMATE = "where it believes to be"


class Page:
    """What is served: frames are drawn onto it one by one."""

    def __init__(
        self,
        server: viser.ViserServer,
        scenery: Scenery,
        things: Iterable[ThingShape],
        title: str,
        ended: str,
    ) -> None:
        self._server = server
        self.panel = Panel(server, title, ended)
        self._world = WorldNodes(server, scenery, things)
        self._robot = RobotNodes(server, scenery.robot)
        self._follow = False
        self._outdoors = scenery.outdoors
        self._at: Array | None = None

    def add_layers(self) -> None:
        """Check boxes for what may be hidden, and whether the eye goes along with the robot."""
        gui = self._server.gui
        with gui.add_folder("Show", expand_by_default=False):
            for label, names in LAYERS.items():
                self._add_layer(label, [getattr(self._world, name) for name in names])
            self._add_layer(ESTIMATE, [self._world.cloud, self._world.ellipse])
            follow = gui.add_checkbox("follow the robot", self._follow)

            @follow.on_update
            def _(_: object) -> None:
                self._follow = bool(follow.value)

    def draw(
        self,
        frame: Frame,
        action: PastAction | None,
        actions: Sequence[PastAction],
        span: tuple[float, float],
        at_once: bool = False,
    ) -> None:
        """Draw a frame; see `Panel.show`."""
        with self._server.atomic():
            self._draw(frame)
            self.panel.show(frame, action, actions, span, at_once)

    def _draw(self, frame: Frame) -> None:
        world, moment = self._world, frame.moment
        for shape in frame.new:
            world.add_thing(shape)
        world.place(frame.things)
        world.come_and_go(moment.world_time)
        self._robot.move(moment.base, moment.joints, moment.width)
        world.estimate(moment.pose, moment.covariance)
        if frame.rays is not None:
            world.rays.points = frame.rays[::FEWER].astype(np.float32)
            world.hits.points = frame.rays[:, 1].astype(np.float32)
        if frame.cloud is not None:
            flat = np.column_stack((frame.cloud[:, :2], np.full(len(frame.cloud), 0.03)))
            world.cloud.points = flat.astype(np.float32)
        if frame.bumped is not None:
            flat = np.column_stack((frame.bumped, np.full(len(frame.bumped), 0.03)))
            world.bumped.points = flat.astype(np.float32)
        if frame.planned is not None:
            world.draw(world.planned, frame.planned)
        if frame.driven is not None:
            back = frame.restored[1:]
            world.draw(world.driven, frame.driven, ~back)
            world.draw(world.restored, frame.driven, back)
        self._look(moment.base[:3])

    def _look(self, at: Array) -> None:
        """At first from behind and above; later along with the robot, where that is wanted."""
        if self._at is None:
            eye = at + AWAY * (OUTDOORS if self._outdoors else 1.0)
            self._server.initial_camera.position = tuple(eye.tolist())
            self._server.initial_camera.look_at = tuple((at + BEFORE * (eye - at)).tolist())
        elif self._follow and not np.array_equal(at, self._at):
            for client in self._server.get_clients().values():
                moved = at - self._at
                look_at = client.camera.look_at + moved
                client.camera.position = client.camera.position + moved
                client.camera.look_at = look_at
        self._at = at.copy()

    def _add_layer(self, label: str, nodes: Sequence[viser.SceneNodeHandle]) -> None:
        box = self._server.gui.add_checkbox(label, True)

        @box.on_update
        def _(_: object) -> None:
            for node in nodes:
                node.visible = bool(box.value)
