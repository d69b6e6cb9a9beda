"""The planted liars, and whether the kit finds them: a kit that finds none proves nothing."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.camera import Camera
from handcart.backends.capabilities.capability import Capability
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.evaluation.conformance.checks import snapshot_checks
from handcart.evaluation.conformance.checks.all_checks import checks
from handcart.evaluation.conformance.checks.check import CheckResult
from handcart.evaluation.conformance.faults.fail_is_true import Batch
from handcart.evaluation.conformance.faults.fault import FaultKind
from handcart.evaluation.conformance.faults.rehearsal import RETURN_BOOK, Rehearsal, Solo
from handcart.evaluation.conformance.rig.bench import Bench
from handcart.evaluation.conformance.rig.parts import needed
from handcart.evaluation.conformance.rig.reach import Reach
from handcart.evaluation.conformance.rig.skipped import Skipped
from handcart.primitives.contract.action_primitive import ActionPrimitive

from . import primitive_liars

INSTANTS = 10  # of a liar's run in which something goes wrong; the first that gives it away is enough
SECONDS, HANG_SECONDS = 60.0, 15.0  # of CPU time that a liar gets
PICK_UP = 2  # its number among the actions of return_book


@dataclass(frozen=True)
class Mutant:
    """A liar of the kit's own, and the part of the kit that is to find it."""

    name: str
    lie: str
    look: Callable[[Bench], list[str]]
    """Function that returns the violations found on a bench."""
    needs: tuple[type[Capability], ...] = ()
    """Capabilities that the robot must have."""
    by_truth: bool = False
    """True if only the ground truth reveals the mutant."""


@dataclass(frozen=True)
class Caught:
    """Result for one mutant."""

    name: str
    lie: str
    by: str = ""
    """First violation found; empty if the mutant was missed."""
    skipped: str = ""
    """Why it couldn't be planted on this robot."""


def try_mutant(name: str, bench: Bench) -> Caught:
    """Plant a liar and look."""
    mutant = MUTANTS[name]
    try:
        _plantable(mutant, bench)
        wrong = mutant.look(bench)
    except Skipped as reason:
        return Caught(name, mutant.lie, skipped=str(reason))
    return Caught(name, mutant.lie, wrong[0] if wrong else "")


def _plantable(mutant: Mutant, bench: Bench) -> None:
    """Raise `Skipped` if the robot lacks a part that the mutant needs, or the ground truth is missing."""
    with bench.rig() as rig:
        for kind in mutant.needs:
            needed(rig.backend, kind)
        if mutant.by_truth and rig.backend.ground_truth() is None:
            raise Skipped("no ground truth is known")


def _backend(name: str, check: str, bench: Bench) -> list[str]:
    finding = checks()[check](replace(bench, liar=name))
    if finding.skipped:
        raise Skipped(finding.skipped)
    return [f"{check}: {each}" for each in finding.wrong]


def _primitive(kind: type[ActionPrimitive], fault: FaultKind, bench: Bench) -> list[str]:
    seconds = HANG_SECONDS if kind is primitive_liars.Hangs else SECONDS
    return _first(Batch(Solo(bench, kind()), 0, INSTANTS, kinds=(fault,), seconds=seconds))


def _holding(kind: type[ActionPrimitive], fault: FaultKind, bench: Bench) -> list[str]:
    """The liar takes the place of PICK_UP in the task return_book."""
    rehearsal = Rehearsal(RETURN_BOOK, bench.backend, instead={"PICK_UP": kind})
    return _first(Batch(rehearsal, PICK_UP, INSTANTS, kinds=(fault,), seconds=SECONDS))


def _first(batch: Batch) -> list[str]:
    """Return the violations of the first trial that has any."""
    found = ([f"{each.fault}: {wrong}" for wrong in each.ending.wrong] for each in batch.trials())
    return next((wrong for wrong in found if wrong), [])


def _drift(kind: type[Reach], bench: Bench) -> list[str]:
    finding = CheckResult("drift", "")
    snapshot_checks.drift(replace(bench, quick=True), finding, kind)
    return [f"drift: {each}" for each in finding.wrong]


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
    Mutant(
        "DropsObject",
        "opens the hand before it goes back",
        partial(_holding, primitive_liars.DropsObject, FaultKind.CANCEL),
        needs=(Arm, Gripper, Camera, RangeSensor),
    ),
    Mutant(
        "DeniesHold",
        "declares an empty hand after it took the book",
        partial(_holding, primitive_liars.DeniesHold, FaultKind.CANCEL),
        needs=(Arm, Gripper, Camera, RangeSensor),
        by_truth=True,
    ),
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
    _in_backend("WrongUnits", "tells wheel travel in mm", "base"),
    _in_backend("EchoesCommands", "encoders read what was commanded", "joints"),
    _in_backend("RollsDice", "ranges waver with the wall clock", "rates"),
    _in_backend("HalfPixel", "pictures are half a pixel off", "tag"),
    _in_backend("Undelayed", "tells where the base was as where it is", "positioning"),
    _in_backend("TurnsOtherWay", "its gyros' axes point down", "imu"),
    _in_backend("FixInMillimetres", "tells fixes in mm", "gps"),
)
MUTANTS: Mapping[str, Mutant] = {mutant.name: mutant for mutant in _ALL}
