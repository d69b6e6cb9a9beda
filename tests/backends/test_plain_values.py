"""Values of declared types as plain data, and back."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Annotated, Any, ClassVar, NamedTuple, TypeVar

import numpy as np
import pytest
from typing_extensions import TypeAliasType

from handcart.backends.plain_values import attributes, from_plain, set_attributes, to_plain
from handcart.backends.saved_state import NotAState, pack, unpack
from handcart.files.models.model import FileModel
from handcart.robotics.far import Far, FarArray
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.outdoors.gps_filter import GpsFilter
from handcart.robotics.navigation.outdoors.particle_filter import ParticleFilter
from handcart.robotics.numerics.arrays import FloatArray


class Colour(Enum):
    RED = "red"


class Point(NamedTuple):
    x: float
    name: str | None


class Spec(FileModel):
    width_mm: float


@dataclass
class Thing:
    pose: Annotated[FloatArray, (2, 2)]
    colour: Colour
    spec: Spec


class Inner:
    STATE: ClassVar = {"count": int}

    def __init__(self) -> None:
        self.count = 0


class Part:
    STATE: ClassVar = {
        "joints": FloatArray,
        "seen": FarArray,
        "until": Far,
        "points": tuple[Point, ...],
        "pairs": frozenset[tuple[str, str]],
        "by_number": dict[int, Thing],
        "made": list[tuple[int, int] | str],
        "inner": Inner,
        "last": Point | None,
    }

    def __init__(self) -> None:
        self.joints, self.seen, self.until = np.zeros(3), np.empty(0), 0.0
        self.points: tuple[Point, ...] = ()
        self.pairs: frozenset[tuple[str, str]] = frozenset()
        self.by_number: dict[int, Thing] = {}
        self.made: list[tuple[int, int] | str] = []
        self.inner, self.last = Inner(), None


def full() -> Part:
    part = Part()
    part.joints, part.seen, part.until = np.array([0.1, -2.0, 3e-17]), np.array([np.inf, 1.0]), np.inf
    part.points, part.pairs = (Point(1.0, "a"), Point(2.0, None)), frozenset({("b", "a"), ("a", "b")})
    part.by_number = {7: Thing(np.eye(2), Colour.RED, Spec(width_mm=2.5))}
    part.made, part.inner.count = [(1, -2), "book 3"], 5
    return part


def test_an_object_gets_back_what_it_had() -> None:
    part, again = full(), Part()
    set_attributes(again, Part.STATE, unpack(pack(attributes(part, Part.STATE))))
    assert pack(attributes(again, Part.STATE)) == pack(attributes(part, Part.STATE))
    assert (again.points, again.pairs, again.made, again.inner.count) == (
        part.points,
        part.pairs,
        part.made,
        5,
    )
    assert isinstance(again.points[0], Point)
    assert again.by_number[7].colour is Colour.RED
    assert again.by_number[7].spec == Spec(width_mm=2.5)


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("joints", np.zeros(4), r"\(4,\), needed: \(3,\)"),
        ("joints", np.zeros((3, 1)), "needed"),
        ("joints", np.array([0.0, np.nan, 0.0]), "isn't a number"),
        ("joints", np.array([0.0, np.inf, 0.0]), "isn't a number"),
        ("joints", np.zeros(3, np.float32), "no array of float64"),
        ("joints", [0.0, 0.0, 0.0], "no array"),
        ("seen", np.array([np.nan]), "isn't a number"),
        ("until", 1, "isn't a floating-point number"),
        ("until", float("nan"), "isn't a floating-point number"),
        ("points", [[1.0]], "shorter"),
        ("points", [["x", "a"]], "'x'"),
        ("points", {}, "no list"),
        ("pairs", [[1, 2]], "no str"),
        ("by_number", [[7, [np.eye(2), "blue", {"width_mm": 1.0}]]], "blue"),
        ("by_number", [[7, [np.eye(3), "red", {"width_mm": 1.0}]]], r"needed: \(2, 2\)"),
        ("by_number", [[7, [np.eye(2), "red", {"width_mm": 1.0, "os": "system"}]]], "validation error"),
        ("by_number", [["7", [np.eye(2), "red", {"width_mm": 1.0}]]], "no int"),
        ("made", [[2, "x"]], "none of 2 types"),
        ("made", [[True, "x"]], "none of 2 types"),
        ("inner", {"count": 1, "more": 2}, "needed: count"),
        ("inner", {"count": 2**200}, "128 bits"),
        ("last", 0, "no list"),
    ],
)
def test_anything_else_is_refused_with_its_name(name: str, value: Any, words: str) -> None:
    data = {**attributes(full(), Part.STATE), name: value}
    with pytest.raises(NotAState, match=words):
        set_attributes(Part(), Part.STATE, data)


def test_missing_and_unknown_attributes() -> None:
    data = attributes(full(), Part.STATE)
    wrong: Any
    for wrong in ({**data, "more": 1}, {k: v for k, v in data.items() if k != "made"}, [], None):
        with pytest.raises(NotAState, match="no state of a Part"):
            set_attributes(Part(), Part.STATE, wrong)


def test_beyond_all_sense() -> None:
    assert from_plain(to_plain(1e15, float), float, "x") == 1e15
    for value in (1e16, -1e300, float("inf")):
        with pytest.raises(NotAState, match="beyond"):
            from_plain(value, float, "x")


@pytest.mark.slow
@pytest.mark.parametrize("kind", [ParticleFilter, GpsFilter])
def test_a_filter_goes_on_as_the_one_that_was_kept(kind: type[ParticleFilter] | type[GpsFilter]) -> None:
    """Its random numbers, what it doubts and what it looks back on included."""
    rng = np.random.default_rng(3)

    def drive(localizer: ParticleFilter | GpsFilter, seed: int) -> Pose2:
        noise = np.random.default_rng(seed)
        for period in range(60):
            rates, felt = np.array([0.0, 0.0, 0.1]), np.array([0.0, 0.0, 9.81])
            localizer.predict(rates, felt, np.array([0.02, 0.021]), 0.025)
            if period % 20 == 0:
                localizer.fix(np.array(localizer.pose[:2]) + 0.3 * noise.standard_normal(2))
        return localizer.pose

    first, again = kind(Pose2(1.0, 2.0, 0.5)), kind(Pose2(0.0, 0.0, 0.0))
    drive(first, int(rng.integers(100)))
    parts = zip(first.parts, again.parts, strict=True)
    for part, other in ((first, again), (first.odometry, again.odometry), *parts):
        set_attributes(other, other.STATE, unpack(pack(attributes(part, part.STATE))))
    assert drive(first, 7) == drive(again, 7)


def test_an_alias_of_a_type_is_what_it_stands_for() -> None:
    """From numpy 2.5 on, `NDArray` is one (PEP 695)."""
    scalar = TypeVar("scalar", bound=np.generic)
    alias = TypeAliasType("alias", np.ndarray[tuple[int, ...], np.dtype[scalar]], type_params=(scalar,))
    for kind in (alias[np.float64], alias[np.float64] | None, Annotated[alias[np.float64], (3,)]):
        data = to_plain(np.arange(3.0), kind)
        assert from_plain(data, kind, "x").tolist() == [0.0, 1.0, 2.0]
    other = TypeAliasType("other", tuple[int, str])
    assert from_plain(to_plain((1, "a"), other), other, "x") == (1, "a")
