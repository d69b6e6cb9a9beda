"""Check of the conformance kit: the tag on a book is seen where it projects."""

from __future__ import annotations

import numpy as np

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.camera import Camera
from handcart.backends.simulation.books.book_props import BookProps
from handcart.evaluation.conformance.checks.check import Check, CheckResult
from handcart.evaluation.conformance.rig.bench import KitBench
from handcart.evaluation.conformance.rig.parts import needed
from handcart.evaluation.conformance.rig.periods import move_joints
from handcart.evaluation.conformance.rig.skipped import Skipped
from handcart.evaluation.judging.survey import simulated_world
from handcart.robotics.geometry.transform import apply, inverse
from handcart.robotics.numerics.arrays import FloatArray
from handcart.robotics.perception.landmarks.tag_reader import read_tags

MAX_ERROR_PX = {"kinematic": 0.1}
OTHER_PIXELS = 0.25  # a renderer that draws triangles
TRIED_SEEDS = (0, 1, 2)
TAG_FROM_HEAD, HALF_TAG = 0.014, 0.005  # [m] on a spine
TRIED_TILTS_RAD = tuple((a, b) for a in (-0.03, -0.01, 0.01, 0.03) for b in (-0.03, 0.0, 0.03))  # [rad]


def tag(bench: KitBench, finding: CheckResult) -> None:
    """Check that the camera sees the tag of a book at the pixels computed from the true joints."""
    errors = np.vstack([_tag_errors(bench, seed) for seed in TRIED_SEEDS])
    if not len(errors):
        raise Skipped("no tag could be read")
    most = MAX_ERROR_PX.get(bench.backend, OTHER_PIXELS)
    for axis, mean in zip("xy", np.abs(errors.mean(axis=0)), strict=True):
        finding.at_most(f"off in {axis}", float(mean), most, "px")
    finding.measured.append(f"{len(errors)} pictures")


def _tag_errors(bench: KitBench, seed: int) -> FloatArray:
    """Return (n, 2) seen minus projected middle of the tag, in [px], in pictures from slightly different
    tilts.
    """
    with bench.rig(seed) as rig:
        backend, spec = rig.backend, rig.robot.spec
        scene, arm, camera = simulated_world(backend), needed(backend, Arm), needed(backend, Camera)
        book = None if scene is None else scene.of(BookProps).tray_book()
        if scene is None or book is None:
            raise Skipped("no book's true place is known")
        if spec.arm is None or "look_at_tag" not in spec.arm.postures:
            raise Skipped("the robot's file has no posture look_at_tag")
        posture = np.array(spec.posture("look_at_tag"))
        errors = []
        for bend, twist in TRIED_TILTS_RAD:
            goal = posture.copy()
            goal[-3], goal[-1] = goal[-3] + bend, goal[-1] + twist
            move_joints(backend, arm, goal)
            seen = [tag for tag in read_tags(camera.image()) if tag.id == book.accession]
            if seen:
                corners = _tag_corners(book.height)
                camera_T_book = inverse(scene.world_T("hand") @ camera.hand_T_camera) @ book.pose
                expected = camera.model.project(apply(camera_T_book, corners))
                errors.append((seen[0].corners - expected).mean(axis=0))
        return np.array(errors).reshape(-1, 2)


def _tag_corners(height: float) -> FloatArray:
    """Return the corners (4, 3) of the tag in the book's frame, in [m]."""
    middle = height - TAG_FROM_HEAD
    signs = ((1, 1), (-1, 1), (-1, -1), (1, -1))
    return np.array([[0.0, y * HALF_TAG, middle + z * HALF_TAG] for y, z in signs])


TAG_CHECKS = (Check("tag", "a tag is seen where it projects (OpenCV: a pixel's middle is whole)", tag),)
