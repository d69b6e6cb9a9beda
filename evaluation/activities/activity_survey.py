"""Two verdicts on the end of an activity: that of BEHAVIOR-1K's evaluator, and our own."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from typing_extensions import override

from handcart.backends.simulation.world.thing import Rest, Thing
from handcart.evaluation.judging.survey import Survey, SurveyedRun
from handcart.files.errors import InputError
from handcart.primitives.activities.activity import Activity, ActivityFile
from handcart.primitives.objects.object_names import name_in_world
from handcart.primitives.objects.objects import Objects

from .bddl_judge import Verdict, judge_goal
from .definition import NoBddl, load_definition
from .true_things import true_things

FOOT_M = 0.006  # of a foot over its surface


class ActivitySurvey(Survey):
    """Judge the end of a run by the activity's definition, and by the surfaces that things belong on.

    The two verdicts are independent: ours compares the true place of each moved thing with the surfaces that
    the task names; theirs evaluates the goal by relations between bodies.
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
        """Return a message for each verdict that the activity isn't done."""
        wrong, theirs = list(self.misplaced()), self._verdict()
        if isinstance(theirs, Verdict) and not theirs.holds:
            wrong += [f"bddl: not so: {each}" for each in theirs.unsatisfied]
        return wrong

    def misplaced(self) -> Iterator[str]:
        """Yield a message for each moved thing that is not on one of its surfaces."""
        file = _file(self.run)
        things = {each.name: each for each in self.run.world.things()}
        for name, surfaces in (file.goal if file else {}).items():
            thing = things.get(name_in_world(name))
            if thing is None or not any(self._is_on(thing, each) for each in surfaces):
                yield f"{name} isn't on {' or '.join(surfaces)}"

    def _is_on(self, thing: Thing, name: str) -> bool:
        surface = self.run.model.of(Objects).objects.surfaces.get(name)
        x, y, z = thing.pose[:3, 3].tolist()
        at_rest = thing.rest not in (Rest.HAND, Rest.FLOOR, Rest.TRAY)
        return (
            surface is not None
            and at_rest
            and surface.margin(x, y) >= 0.0
            and abs(z - surface.height_m) <= FOOT_M
        )

    def _verdict(self) -> Verdict | str:
        """Return their verdict, or why there is none."""
        file = _file(self.run)
        assert file is not None  # it applies
        try:
            definition = load_definition(file.activity, file.definition)
        except (NoBddl, InputError) as error:
            return str(error)
        return judge_goal(definition, true_things(definition, file, self.run.world))


def _file(run: SurveyedRun) -> ActivityFile | None:
    return run.model.of(Activity).activity if "activities" in run.model.sections else None
