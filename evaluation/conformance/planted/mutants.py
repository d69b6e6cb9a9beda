"""The planted mutants, and whether the kit finds them: a kit that finds none proves nothing."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.capability import Capability
from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.evaluation.conformance.checks import snapshot_checks
from handcart.evaluation.conformance.checks.all_checks import checks
from handcart.evaluation.conformance.checks.check import CheckResult
from handcart.evaluation.conformance.faults.fail_is_true import Batch
from handcart.evaluation.conformance.faults.fault import FaultKind
from handcart.evaluation.conformance.faults.rehearsal import Solo
from handcart.evaluation.conformance.rig.bench import KitBench
from handcart.evaluation.conformance.rig.parts import needed
from handcart.evaluation.conformance.rig.reach import Reach
from handcart.evaluation.conformance.rig.skipped import Skipped
from handcart.primitives.contract.action_primitive import ActionPrimitive
from handcart.tasks.domain import domains, imported

from . import primitive_liars
from .mutant import FAULT_INSTANTS, TRIAL_LIMIT_S, Mutant, first_violations

HANG_LIMIT_S = 15.0
"""Limit of the CPU time of a trial of a mutant that hangs, in [s]."""


@dataclass(frozen=True)
class Caught:
    """Result of testing whether the conformance kit finds one mutant (backend or primitive with a planted
    fault).
    """

    name: str
    lie: str
    by: str = ""
    """First violation found; empty if the mutant was missed."""
    skipped: str = ""
    """Reason why the mutant could not be planted on this robot; empty if it was planted."""


def try_mutant(name: str, bench: KitBench) -> Caught:
    """Replace a primitive or backend by a mutant, and return whether the conformance kit finds it."""
    mutant = mutants()[name]
    try:
        _plantable(mutant, bench)
        wrong = mutant.look(bench)
    except Skipped as reason:
        return Caught(name, mutant.lie, skipped=str(reason))
    return Caught(name, mutant.lie, wrong[0] if wrong else "")


def _plantable(mutant: Mutant, bench: KitBench) -> None:
    """Raise `Skipped` if the robot lacks a part that the mutant needs, or the ground truth is missing."""
    with bench.rig() as rig:
        for kind in mutant.needs:
            needed(rig.backend, kind)
        if mutant.by_truth and rig.backend.ground_truth() is None:
            raise Skipped("no ground truth is known")


def _backend(name: str, check: str, bench: KitBench) -> list[str]:
    finding = checks()[check](replace(bench, liar=name))
    if finding.skipped:
        raise Skipped(finding.skipped)
    return [f"{check}: {item}" for item in finding.wrong]


def _primitive(kind: type[ActionPrimitive], fault: FaultKind, bench: KitBench) -> list[str]:
    seconds = HANG_LIMIT_S if kind is primitive_liars.Hangs else TRIAL_LIMIT_S
    return first_violations(Batch(Solo(bench, kind()), 0, FAULT_INSTANTS, kinds=(fault,), seconds=seconds))


def _drift(kind: type[Reach], bench: KitBench) -> list[str]:
    finding = CheckResult("drift", "")
    snapshot_checks.drift(replace(bench, quick=True), finding, kind)
    return [f"drift: {item}" for item in finding.wrong]


def _in_backend(name: str, lie: str, check: str) -> Mutant:
    return Mutant(name, lie, partial(_backend, name, check))


def _in_primitive(
    kind: type[Reach],
    lie: str,
    fault: FaultKind = FaultKind.CANCEL,
    needs: tuple[type[Capability], ...] = (),
    by_truth: bool = False,
) -> Mutant:
    return Mutant(kind.__name__, lie, partial(_primitive, kind, fault), needs, by_truth)


_ALL = (
    _in_primitive(primitive_liars.NotRestored, "leaves everything as it is", needs=(Arm,)),
    _in_primitive(primitive_liars.BaseAlone, "brings back the base, not arm and fingers", needs=(Arm,)),
    _in_primitive(primitive_liars.MovesLater, "comes back, and drives off later"),
    Mutant(
        "RelativeUndo",
        "goes back relative to where it is, always a little less",
        partial(_drift, primitive_liars.RelativeUndo),
        by_truth=True,
    ),
    _in_primitive(primitive_liars.EditsSnapshot, "moves the goal instead of coming back", by_truth=True),
    _in_primitive(primitive_liars.RaisesTolerance, "takes tolerances that forgive everything", by_truth=True),
    _in_primitive(
        primitive_liars.SwallowsFault, "takes a fault for the end", FaultKind.EXCEPTION, by_truth=True
    ),
    _in_primitive(primitive_liars.ClaimsSuccess, "does nothing and says that it is done", by_truth=True),
    _in_primitive(primitive_liars.FailsAfterNoReturn, "takes a point of no return back", FaultKind.EXCEPTION),
    _in_primitive(primitive_liars.Hangs, "never ends restoring, nor hands back control"),
    _in_primitive(
        primitive_liars.RunsIntoThings,
        "comes back by way of the wall, past the guard",
        needs=(RangeSensor,),
        by_truth=True,
    ),
    _in_backend("KeepsDriving", "a command lives on until there is another", "one period"),
    _in_backend("QueuesCommands", "sends after a stop what was queued before", "stop"),
    _in_backend("TakesAnything", "takes NaN and what is beyond a limit", "limits"),
    _in_backend("MovesAtOnce", "moves without a step", "after a step"),
    _in_backend("WrongUnits", "reports wheel travel in mm", "base"),
    _in_backend("EchoesCommands", "encoders read what was commanded", "joints"),
    _in_backend("RollsDice", "ranges waver with the wall clock", "rates"),
    _in_backend("HalfPixel", "pictures are half a pixel off", "tag"),
    _in_backend("Undelayed", "reports an old pose of the base as the current one", "positioning"),
    _in_backend("TurnsOtherWay", "its gyros' axes point down", "imu"),
    _in_backend("FixInMillimetres", "tells fixes in mm", "gps"),
    _in_backend("DropsScans", "loses four of five scans", "navigation"),
    _in_backend("DelaysScans", "delivers scans 200 ms late", "navigation"),
    _in_backend("MirrorsScans", "takes left for right in scans", "navigation"),
    _in_backend("StretchesTravel", "reports a quarter more travel than the wheels roll", "navigation"),
    _in_backend("SwapsWheels", "takes the left wheel for the right one", "navigation"),
)


def mutants() -> dict[str, Mutant]:
    """Return the mutants (faulty primitives and backends) of the kit itself and of all domains, by name."""
    listed = [mutant for domain in domains() if domain.mutants for mutant in imported(domain.mutants)]
    return {mutant.name: mutant for mutant in (*_ALL, *listed)}
