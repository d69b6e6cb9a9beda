"""A pytest plugin: fixtures that run single primitives, and the conformance kit, in a user's own tests."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from handcart.evaluation.conformance.report import Report
    from handcart.evaluation.trials.stage import Stage, StageFiles
    from handcart.primitives.contract.action_primitive import ActionPrimitive
    from handcart.primitives.contract.outcome import Outcome


@pytest.fixture
def set_stage() -> Iterator[Callable[..., Stage]]:
    """Builds stages as `handcart.evaluation.trials.stage.set_stage` does, and closes them after the test.

    def test_there_and_back(set_stage):
        stage = set_stage(seed=3)
        for place in ("shelf_1", "home"):
            assert isinstance(stage.do(MoveTo(place=place)), Success)
    """
    from handcart.evaluation.trials.stage import set_stage as build

    stages: list[Stage] = []

    def make(*args: Any, **options: Any) -> Stage:
        stages.append(build(*args, **options))
        return stages[-1]

    yield make
    for stage in stages:
        stage.backend.close()


@pytest.fixture
def do_primitive(set_stage: Callable[..., Stage]) -> Callable[..., Outcome]:
    """Runs one primitive alone, as `handcart do` does, and gives its outcome.

    def test_forward(do_primitive):
        assert isinstance(do_primitive(Forward(distance_m=0.5), seed=3), Success)
    """

    def do(
        primitive: ActionPrimitive,
        *,
        files: StageFiles | None = None,
        robot: str = "librarian",
        backend: str = "kinematic",
        seed: int = 0,
    ) -> Outcome:
        given = {} if files is None else {"files": files}
        return set_stage(robot=robot, backend=backend, seed=seed, **given).do(primitive)

    return do


@pytest.fixture
def conformance() -> Callable[..., Report]:
    """Tries a backend by its name, as `handcart conformance` does, and asserts that all holds.

    def test_my_backend(conformance):
        conformance("my_backend", robot="my_robot/robot.yaml", quick=True)
    """
    from handcart.evaluation.conformance.kit import Setting, run_kit

    def check(
        backend: str,
        *,
        robot: str = "librarian",
        quick: bool = True,
        parts: Sequence[str] = (),
        primitives: Sequence[str] = (),
        instants: int | None = None,
        processes: int = 2,
    ) -> Report:
        report = run_kit(Setting(backend, robot, quick, parts, primitives, instants), processes)
        assert report.ok, "\n".join(report.lines())
        return report

    return check
