"""Page of the view: the world with the robot, and the panel."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from handcart.evaluation.viewing.playback.scenery import Scenery, ThingShape
from handcart.networks.past_runs.past_run import PastAction
from handcart.robotics.numerics.arrays import FloatArray

from .eye import eye_on
from .frame import Frame
from .panel import Panel
from .robot_nodes import RobotNodes
from .world_nodes import WorldNodes

if TYPE_CHECKING:
    import viser

WIDE_PICTURE = 1.6  # width over height of a window of unknown size
RAY_STRIDE = 2  # every second ray that hit something is drawn
LAYER_NODES = {
    "range sensor": ("rays", "hits"),
    "planned path": ("planned",),
    "what it ran into": ("bumped",),
    "people that it tracks": ("people",),
    "driven path": ("driven", "restored"),
}
ESTIMATE_LABEL = "where it believes to be"


class Page:
    """Page in the browser, on a viser server, that shows robot and world; each update draws a later state
    of both.
    """

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
        self._at: FloatArray | None = None
        server.on_client_connect(self._aim)

    def add_layers(self) -> None:
        """Add check boxes to the page that show or hide parts of the 3D view, and one that lets the view
        follow the robot.
        """
        gui = self._server.gui
        with gui.add_folder("Show", expand_by_default=False):
            for label, names in LAYER_NODES.items():
                self._add_layer(label, [getattr(self._world, name) for name in names])
            self._add_layer(ESTIMATE_LABEL, [self._world.cloud, self._world.ellipse])
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
        """Draw a frame onto the page and its panel.

        Args:
            frame: state of the run at the time to draw.
            action: action to describe, the running one or the one nearest in time; None if there is none.
            actions: all actions of the run, for the time line.
            span: start and end of the time line, in [s] of the robot's time.
            at_once: True to draw the time line again now, not only from time to time.
        """
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
            world.rays.points = frame.rays[::RAY_STRIDE].astype(np.float32)
            world.hits.points = frame.rays[:, 1].astype(np.float32)
        if frame.cloud is not None:
            flat = np.column_stack((frame.cloud[:, :2], np.full(len(frame.cloud), 0.03)))
            world.cloud.points = flat.astype(np.float32)
        if frame.bumped is not None:
            flat = np.column_stack((frame.bumped, np.full(len(frame.bumped), 0.03)))
            world.bumped.points = flat.astype(np.float32)
        if frame.people is not None:
            world.track(frame.people)
        if frame.planned is not None:
            world.draw(world.planned, frame.planned)
        if frame.driven is not None:
            back = frame.restored[1:]
            world.draw(world.driven, frame.driven, ~back)
            world.draw(world.restored, frame.driven, back)
        self._look(moment.base[:3])

    def _look(self, at: FloatArray) -> None:
        """Aim the camera at the robot's position (3,) in the world, in [m], at first; then move it along if
        following is on.
        """
        if self._at is None:
            camera = self._server.initial_camera
            eye = eye_on(at, camera.fov, WIDE_PICTURE, self._outdoors)
            camera.position, camera.look_at = tuple(eye.position.tolist()), tuple(eye.look_at.tolist())
        elif self._follow and not np.array_equal(at, self._at):
            for client in self._server.get_clients().values():
                moved = at - self._at
                look_at = client.camera.look_at + moved
                client.camera.position = client.camera.position + moved
                client.camera.look_at = look_at
        self._at = at.copy()

    def _aim(self, client: viser.ClientHandle) -> None:
        """Aim the camera of a newly connected browser at the robot; the view depends on the window's
        aspect ratio.
        """
        if self._at is None:
            return
        eye = eye_on(self._at, client.camera.fov, client.camera.aspect, self._outdoors)
        with client.atomic():
            client.camera.position = eye.position
            client.camera.look_at = eye.look_at

    def _add_layer(self, label: str, nodes: Sequence[viser.SceneNodeHandle]) -> None:
        box = self._server.gui.add_checkbox(label, True)

        @box.on_update
        def _(_: object) -> None:
            for node in nodes:
                node.visible = bool(box.value)
