"""Areas of the floor that carry objects; elsewhere on the floor an object has fallen."""

from __future__ import annotations

import pytest

from handcart.backends.simulation.body.arm_contact import ArmContact
from handcart.backends.simulation.objects.object_props import ObjectProps
from handcart.backends.simulation.objects.spec import ObjectsSection
from handcart.backends.simulation.world.scene import Scene
from handcart.backends.simulation.world.thing import Rest
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import inverse, transform
from tests.primitives.objects.fetching import changed, rig_with, scene_of

AREA = "floor_areas:\n  - {name: mat, x_m: 3.0, y_m: 2.0, size_m: [0.6, 0.4]}\nobjects:"


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Scene:
    folder = tmp_path_factory.mktemp("mat")
    made: Scene = scene_of(rig_with(world=changed(folder, "world.yaml", ("objects:", AREA))))
    return made


@pytest.mark.parametrize(
    ("x", "height", "rest"),
    [(3.0, 0.005, Rest.TABLE), (3.0, 0.03, Rest.FLOOR), (3.4, 0.005, Rest.FLOOR)],
)
def test_area_carries_what_is_put_down_on_it(scene: Scene, x: float, height: float, rest: Rest) -> None:
    props = scene.of(ObjectProps)
    parcel = props.objects["parcel_1"]
    parcel.pose = transform((x, 2.0, height))
    props.let_go(parcel)
    assert parcel.rest is rest
    assert parcel.pose[2, 3] == pytest.approx(0.0, abs=1e-9)


def test_area_is_no_obstacle_of_the_base(scene: Scene) -> None:
    assert "mat" in {solid.box.name for solid in scene.solids}
    assert "mat" not in scene.full_plan.names


def test_held_object_touches_an_area_far_from_all_furniture(scene: Scene) -> None:
    parcel, arm, before = scene.of(ObjectProps).objects["parcel_1"], scene.arm, scene.base
    assert arm is not None
    contact = ArmContact(scene, arm)
    scene.base, scene.held, parcel.rest = Pose2(2.3, 2.0, 0.0), parcel, Rest.HAND
    scene.hand_T_held = inverse(scene.world_T("hand")) @ transform((3.0, 2.0, -0.01))
    touch = contact.deepest_of_arm(scene.joints)
    scene.base, scene.held = before, None
    assert touch.other == "mat"
    assert touch.depth == pytest.approx(0.01, abs=0.002)


@pytest.mark.parametrize(("y", "is_refused"), [(2.15, False), (2.25, True)])
def test_object_on_the_floor_beside_all_areas_is_refused(y: float, is_refused: bool) -> None:
    areas = [{"name": "mat", "x_m": 3.0, "y_m": 2.0, "heading_deg": 90.0, "size_m": [0.4, 0.6]}]
    cup = {"name": "cup", "x_m": 3.25, "y_m": y, "height_m": 0.0}
    data = {"floor_areas": areas, "objects": [cup]}
    if is_refused:
        with pytest.raises(ValueError, match=r"'cup' is on the floor outside of every floor area.*mat"):
            ObjectsSection.model_validate(data)
    else:
        ObjectsSection.model_validate(data)
    ObjectsSection.model_validate({**data, "floor_areas": []})
