"""A pytest plugin: fixtures that run single primitives, and the conformance kit, in a user's own tests."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from handcart.evaluation.conformance.report import KitReport
    from handcart.evaluation.trials.rig import Rig, RigFiles
    from handcart.primitives.contract.action_primitive import ActionPrimitive
    from handcart.primitives.outcomes.outcome import Outcome


@pytest.hookimpl(tryfirst=True)
def pytest_load_initial_conftests(early_config: pytest.Config) -> None:
    """Exclude handcart from the rewriting of asserts, which pytest does for the package of every plugin.

    It would parse and compile more than a thousand modules that have no asserts. This plugin itself is
    imported earlier and is rewritten.
    """
    marked: set[str] = getattr(early_config.pluginmanager.rewrite_hook, "_must_rewrite", set())
    marked.discard("handcart")


@pytest.fixture
def build_rig() -> Iterator[Callable[..., Rig]]:
    """Provide a function as a fixture that builds rigs: test set-ups of a robot in a world, without a task.

    It is `handcart.evaluation.trials.rig.build_rig`; the rigs are closed after the test.

    def test_there_and_back(build_rig):
        rig = build_rig(seed=3)
        for place in ("shelf_1", "home"):
            assert isinstance(rig.do(MoveTo(place=place)), Success)
    """
    from handcart.evaluation.trials.rig import build_rig as build

    rigs: list[Rig] = []

    def make(*args: Any, **options: Any) -> Rig:
        rigs.append(build(*args, **options))
        return rigs[-1]

    yield make
    for rig in rigs:
        rig.backend.close()


@pytest.fixture
def do_primitive(build_rig: Callable[..., Rig]) -> Callable[..., Outcome]:
    """Provide a function as a fixture that runs a single primitive, as `handcart do` does, and returns its
    outcome.

    def test_forward(do_primitive):
        assert isinstance(do_primitive(Forward(distance_m=0.5), seed=3), Success)
    """

    def do(
        primitive: ActionPrimitive,
        *,
        files: RigFiles | None = None,
        robot: str = "librarian",
        backend: str = "kinematic",
        seed: int = 0,
    ) -> Outcome:
        given = {} if files is None else {"files": files}
        return build_rig(robot=robot, backend=backend, seed=seed, **given).do(primitive)

    return do


@pytest.fixture
def conformance() -> Callable[..., KitReport]:
    """Provide a fixture with the checks of `handcart conformance`: a function that asserts that a backend
    passes them.

    `tasks` are task files to test with, `primitives` the names of primitives to test. Examples of tests:

        def test_my_backend(conformance):
            conformance("my_backend", robot="my_robot/robot.yaml", quick=True)

        def test_my_primitive(conformance):
            conformance("kinematic", tasks=["my_task.yaml"], parts=["faults"], primitives=["WATER"])
    """
    from handcart.evaluation.conformance.kit import KitSetting, default_robot, run_kit

    def check(
        backend: str,
        *,
        robot: str | None = None,
        quick: bool = True,
        parts: Sequence[str] = (),
        primitives: Sequence[str] = (),
        instants: int | None = None,
        processes: int = 2,
        tasks: Sequence[Path | str] = (),
    ) -> KitReport:
        own = [Path(task) for task in tasks]
        named = robot or default_robot(own)
        setting = KitSetting(backend, named, quick, parts, primitives, instants, own_tasks=own)
        report = run_kit(setting, processes)
        assert report.ok, "\n".join(report.lines())
        return report

    return check
