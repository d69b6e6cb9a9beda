"""Description from which MuJoCo compiles a stage."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from handcart.backends.mujoco.body.robot_looks import PartLook
from handcart.backends.mujoco.engine.looks import BoxLook, Looks, TileLook
from handcart.backends.mujoco.engine.mujoco_module import mujoco
from handcart.backends.mujoco.engine.world_spec import ROBOT_PREFIX, where
from handcart.backends.physics.engine.form_mesh import form_mesh
from handcart.backends.physics.engine.thing_form import ThingForm, Uvs
from handcart.backends.simulation.world.material import Material
from handcart.backends.simulation.world.sheet import Sheet
from handcart.robotics.geometry.transform import transform
from handcart.robotics.numerics.arrays import ByteArray

from .ground_looks import FLOOR_SIDE, GRASS_SIDE, floor_picture, grass_picture
from .style import Style

LAMP_NAME = "lamp"
_DEEP = 18.0  # [m] from the lamp to the last thing that it shines on
GROUND_THINNING = 4  # rough ground is shown with one of so many points, along x and along y
_OFF = 4e-4  # [m] that a sheet lies above what it is painted on
_FLOOR_GREY, _GROUND_GREY = 95, 95
_SKY = (0.72, 0.82, 0.93), (0.93, 0.95, 0.97)
_NO_SKY = ((150 / 255,) * 3,) * 2
_FLAT = ((0.5, 0.5),) * 4
_WHOLE = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))
_SHEET_LEVEL = 1


class StageSpec:
    """Builder of the `MjSpec` (MuJoCo's editable model) of a `PictureStage`.

    The model has shapes without contacts, and movable bodies that are placed for each picture.
    """

    def __init__(self, looks: Looks, robot: Sequence[PartLook], style: Style) -> None:
        self.spec: Any = mujoco().MjSpec()
        self.moving: list[str] = []
        """Names of the bodies that are placed for each picture."""
        self._style, self._materials = style, dict[Material, str]()
        self._light()
        if looks.level:
            self._floor()
        for number, tile in looks.tiles.items():
            self._tile(number, tile)
        for number, box in looks.boxes.items():
            self._box(number, box)
        for number, sheet in enumerate(looks.sheets):
            self._sheet(number, sheet)
        for number, form in looks.things.items():
            self._thing(number, form)
        self._robot(robot)

    def _light(self) -> None:
        spec, style, kinds = self.spec, self._style, mujoco().mjtLightType
        spec.stat.extent, spec.stat.center = style.lit_m, (0.0, 0.0, 0.0)
        reach = spec.visual.map  # in extents
        reach.shadowclip, reach.znear, reach.zfar = 1.0, 0.02, _DEEP / style.lit_m
        spec.visual.quality.shadowsize, spec.visual.quality.offsamples = style.shadow_px, style.samples
        lamp = self._body(LAMP_NAME).add_light(name=LAMP_NAME)
        lamp.type, lamp.dir = kinds.mjLIGHT_DIRECTIONAL, style.beam
        lamp.castshadow, lamp.active = style.shadow_px > 0, style.lamp > 0.0
        lamp.diffuse, lamp.specular, lamp.ambient = (style.lamp,) * 3, (0.3,) * 3, (0.0,) * 3
        head = spec.visual.headlight
        head.active, head.ambient, head.diffuse, head.specular = 1, (style.even,) * 3, (0.0,) * 3, (0.0,) * 3
        head.diffuse = (0.22 * style.coloured,) * 3
        sky = spec.add_texture(name="sky", type=mujoco().mjtTexture.mjTEXTURE_SKYBOX)
        sky.builtin = mujoco().mjtBuiltin.mjBUILTIN_GRADIENT
        sky.rgb1, sky.rgb2 = _SKY if style.coloured else _NO_SKY
        sky.width = sky.height = 256

    def _body(self, name: str) -> Any:
        self.moving.append(name)
        return self.spec.worldbody.add_body(name=name, mocap=True)

    # Colours

    def _texture(self, name: str, picture: ByteArray) -> Any:
        """Return a material that shows a picture, grey (h, w) or in colour (h, w, 3)."""
        texture = self.spec.add_texture(name=name, type=mujoco().mjtTexture.mjTEXTURE_2D)
        texture.height, texture.width = picture.shape[:2]
        texture.nchannel = 3
        colours = picture if picture.ndim == 3 else np.repeat(picture[..., None], 3, axis=2)
        texture.data = np.ascontiguousarray(colours).tobytes()
        material = self.spec.add_material(name=name)
        material.textures[mujoco().mjtTextureRole.mjTEXROLE_RGB] = name
        material.specular = material.shininess = 0.1 if self._style.coloured else 0.0
        return material

    def _paint(self, geometry: Any, grey: int, material: Material) -> None:
        """Paint a shape without print."""
        geometry.rgba = (*material[:3], 1.0) if self._style.coloured else (*(grey / 255,) * 3, 1.0)
        if not self._style.coloured:
            geometry.material = self._dull()
            return
        if material not in self._materials:
            name = self._materials[material] = f"material {len(self._materials)}"
            made = self.spec.add_material(name=name)
            made.rgba, made.specular, made.shininess = (*material[:3], 1.0), material.shine, material.shine
        geometry.material = self._materials[material]

    def _dull(self) -> str:
        if self.spec.material("dull") is None:
            made = self.spec.add_material(name="dull")
            made.specular = made.shininess = 0.0
        return "dull"

    # Shapes

    def _shape(self, body: Any, **shape: Any) -> Any:
        return body.add_geom(contype=0, conaffinity=0, mass=0.0, **shape)

    def _floor(self) -> None:
        plane = mujoco().mjtGeom.mjGEOM_PLANE
        floor = self._shape(self.spec.worldbody, type=plane, size=(0.0, 0.0, 1.0))
        floor.castshadow = 0  # none falls on it but its own, as specks
        if not self._style.coloured:
            floor.rgba, floor.material = (*(_FLOOR_GREY / 255,) * 3, 1.0), self._dull()
            return
        made = self._texture("floor", floor_picture())
        made.texuniform, made.texrepeat = True, (1 / FLOOR_SIDE, 1 / FLOOR_SIDE)
        floor.material = "floor"

    def _tile(self, number: int, tile: TileLook) -> None:
        heights = tile.heights[::GROUND_THINNING, ::GROUND_THINNING]
        low, span = float(heights.min()), max(float(np.ptp(heights)), 1e-6)
        half = tile.cell * GROUND_THINNING * (len(heights) - 1) / 2
        self.spec.add_hfield(
            name=f"{number}",
            size=(half, half, span, 0.01),
            nrow=len(heights),
            ncol=len(heights),
            userdata=((heights - low) / span).ravel(),
        )
        kind, (x, y) = mujoco().mjtGeom.mjGEOM_HFIELD, tile.corner + half
        ground = self._shape(self.spec.worldbody, type=kind, hfieldname=f"{number}", pos=(x, y, low))
        ground.castshadow = 0  # hills are so low that theirs are specks
        if not self._style.coloured:
            ground.rgba, ground.material = (*(_GROUND_GREY / 255,) * 3, 1.0), self._dull()
            return
        if self.spec.material("grass") is None:
            made = self._texture("grass", grass_picture())
            made.texuniform, made.texrepeat = True, (1 / GRASS_SIDE, 1 / GRASS_SIDE)
        ground.material = "grass"

    def _box(self, number: int, look: BoxLook) -> None:
        body, placed = self.spec.worldbody, where(look.box.pose)
        if look.moves:
            body, placed = self._body(f"{number}"), {}
        half = [size / 2 for size in look.box.size]
        self._paint(
            self._shape(body, type=mujoco().mjtGeom.mjGEOM_BOX, size=half, **placed), look.grey, look.material
        )

    def _sheet(self, number: int, sheet: Sheet) -> None:
        picture, metres = sheet.levels[min(_SHEET_LEVEL, len(sheet.levels) - 1)]
        height, width = (size * metres for size in picture.shape)
        name = f"sheet {number}"
        self._texture(name, picture)
        uvs = (_FLAT, _FLAT, _FLAT, _FLAT, _WHOLE, _FLAT)
        self._printed_box(
            self.spec.worldbody,
            name,
            (width, height, _OFF),
            uvs,
            where(sheet.pose @ transform((0, 0, _OFF / 2))),
        )

    def _thing(self, number: int, form: ThingForm) -> None:
        body, name = self._body(f"{number}"), f"{number}"
        if self._style.coloured:
            picture = None if form.portrait is None else form.portrait()
        else:
            picture = form.picture if form.printed is None else form.printed()
        if picture is not None:
            self._texture(name, picture)
            self._printed_box(body, name, form.size, form.uvs, {}, form.is_round)
            return
        half, kinds = [size / 2 for size in form.size], mujoco().mjtGeom
        kind = kinds.mjGEOM_CYLINDER if form.is_round else kinds.mjGEOM_BOX
        size = (half[0], half[2], 0.0) if form.is_round else half
        self._paint(self._shape(body, type=kind, size=size), 0, form.material)

    def _printed_box(
        self,
        body: Any,
        name: str,
        size: Sequence[float],
        uvs: Sequence[Uvs],
        placed: dict[str, Any],
        is_round: bool = False,
    ) -> None:
        """Add a box or cylinder that shows parts of a picture, and the material of that name.

        Args:
            body: body of the `MjSpec`.
            name: name of the shape and of its material.
            size: (3,) lengths along x, y and z, in [m].
            uvs: four corners (u, v), 0 to 1, of each face in the picture; faces -x, +x, -y, +y, +z, -z.
            placed: pose of the shape, see `where`.
            is_round: True for a cylinder along z.
        """
        mesh = form_mesh(size, uvs, is_round)
        corners = 4 * np.arange(len(mesh.corners))[:, None]
        triangles = np.concatenate([corners + half for half in np.array(((0, 1, 2), (0, 2, 3)))])
        self.spec.add_mesh(
            name=name,
            uservert=mesh.corners.ravel(),
            usernormal=np.repeat(mesh.normals, 4, axis=0).ravel(),
            usertexcoord=(mesh.uvs * (1.0, -1.0) + (0.0, 1.0)).ravel(),
            userface=triangles.ravel(),
        )
        kind = mujoco().mjtGeom.mjGEOM_MESH
        self._shape(body, type=kind, meshname=name, material=name, **placed)

    def _robot(self, parts: Sequence[PartLook]) -> None:
        bodies = {
            link: self._body(ROBOT_PREFIX + link) for link in dict.fromkeys(part.link for part in parts)
        }
        for number, part in enumerate(parts):
            shape = {"type": part.kind, "pos": part.position, "quat": part.quaternion}
            if part.mesh is None:
                shape["size"] = part.size
            else:
                name = shape["meshname"] = f"robot {number}"
                self.spec.add_mesh(name=name, uservert=part.mesh[0].ravel(), userface=part.mesh[1].ravel())
            made = self._shape(bodies[part.link], **shape)
            red, green, blue, _ = (float(item) for item in part.rgba)
            self._paint(made, round(255 * green), Material(red, green, blue, 0.3))
