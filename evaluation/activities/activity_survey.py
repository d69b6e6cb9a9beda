"""Two verdicts on the end of an activity: that of BEHAVIOR-1K's evaluator, and our own."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from typing_extensions import override

from handcart.backends.simulation.world.thing import Rest, Thing
from handcart.evaluation.judging.survey import Survey, SurveyedRun
from handcart.files.errors import InputError
from handcart.primitives.activities.activity import Activity, ActivityFile
from handcart.primitives.objects.knowledge.object_names import name_in_world
from handcart.primitives.objects.knowledge.objects import Objects
from handcart.robotics.geometry.footprint import polygon_gap
from handcart.robotics.kinematics.shapes import Box, corners
from handcart.robotics.numerics.arrays import FloatArray

from .bddl_judge import Verdict, judge_goal
from .definition import NoBddl, load_definition
from .true_things import true_things

FOOT_M = 0.006  # of a foot over its surface


class ActivitySurvey(Survey):
    """Evaluation of the end of a run of a BEHAVIOR-1K activity by two independent verdicts.

    The first verdict compares the true place of each moved thing with the surfaces that the task names for
    it. The second verdict, that of BEHAVIOR-1K, evaluates the activity's goal in BDDL by relations between
    bodies.
    """

    name = "activities"

    @override
    @classmethod
    def applies(cls, run: SurveyedRun) -> bool:
        return run.scene is not None and _file(run) is not None

    @override
    def figures(self) -> dict[str, Any]:
        ours, theirs = list(self.misplaced()), self._verdict()
        figures: dict[str, Any] = {"activity_ours": not ours, "activity_ours_wrong": ours}
        if isinstance(theirs, Verdict):
            return figures | {
                "activity_bddl": theirs.holds,
                "activity_bddl_wrong": list(theirs.unsatisfied),
                "activity_agreed": theirs.holds == (not ours),
            }
        return figures | {"activity_bddl": None, "activity_bddl_wrong": [theirs]}

    @override
    def faults(self) -> list[str]:
        """Return a message for each misplaced thing, and for each BDDL condition of the activity's goal that
        does not hold.
        """
        wrong, theirs = list(self.misplaced()), self._verdict()
        if isinstance(theirs, Verdict) and not theirs.holds:
            wrong += [f"bddl: not so: {text}" for text in theirs.unsatisfied]
        return wrong

    def misplaced(self) -> Iterator[str]:
        """Yield a message for each thing of the activity that is not where the activity's goal wants it.

        The goal wants a thing on one of some surfaces, or next to another thing.
        """
        file = _file(self.run)
        things = {item.name: item for item in self.run.world.things()}
        for name, surfaces in (file.goal if file else {}).items():
            thing = things.get(name_in_world(name))
            if thing is None or not any(self._is_on(thing, surface) for surface in surfaces):
                yield f"{name} isn't on {' or '.join(surfaces)}"
        for name, term in (file.beside if file else {}).items():
            thing, parts = things.get(name_in_world(name)), self._bodies(term)
            if thing is None or not _are_near(thing.box(), parts):
                yield f"{name} isn't next to {term}"

    def _is_on(self, thing: Thing, name: str) -> bool:
        surface = self.run.model.of(Objects).objects.surfaces.get(name)
        x, y, z = thing.pose[:3, 3].tolist()
        at_rest = thing.rest not in (Rest.HAND, Rest.FLOOR, Rest.TRAY, Rest.PERSON)
        return (
            surface is not None
            and at_rest
            and surface.margin(x, y) >= 0.0
            and abs(z - surface.height_m) <= FOOT_M
        )

    def _bodies(self, term: str) -> list[Box]:
        """Return the solid boxes of what a term means: an object, or parts of furniture."""
        file = _file(self.run)
        assert file is not None  # it applies
        if term in file.objects:
            name = name_in_world(file.objects[term])
            return [thing.box() for thing in self.run.world.things() if thing.name == name]
        parts = set(file.furniture.get(term, ()))
        return [solid.box for solid in self.run.world.solids if solid.box.name in parts]

    def _verdict(self) -> Verdict | str:
        """Return the verdict of BEHAVIOR-1K's evaluator, or the reason why it gives none."""
        file = _file(self.run)
        assert file is not None  # it applies
        try:
            definition = load_definition(file.activity, file.definition)
        except (NoBddl, InputError) as error:
            return str(error)
        return judge_goal(definition, true_things(definition, file, self.run.world))


def _are_near(one: Box, parts: Sequence[Box]) -> bool:
    """Return whether the gap between two outlines is at most a sixth of the mean size of both.

    Args:
        one: a body.
        parts: boxes that another body consists of.
    """
    if not parts:
        return False
    points = np.vstack([corners(part) for part in parts])
    mean = (sum(one.size) + float(np.ptp(points, axis=0).sum())) / 3
    return min(polygon_gap(_outline(one), _outline(part)) for part in parts) <= mean / 6


def _outline(box: Box) -> FloatArray:
    """Return the corners (4, 2) of an upright box, seen from above, on the world's floor in [m]."""
    half = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) * np.array(box.size[:2]) / 2
    return np.asarray(half @ box.pose[:2, :2].T + box.pose[:2, 3])


def _file(run: SurveyedRun) -> ActivityFile | None:
    return run.model.of(Activity).activity if "activities" in run.model.sections else None
