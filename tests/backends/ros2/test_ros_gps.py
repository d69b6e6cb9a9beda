"""A satellite receiver by `NavSatFix`."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import yaml

from handcart.backends.capabilities.gps import Fix, Gps
from handcart.backends.description.ros_spec import RosGpsSpec, RosSpec
from handcart.backends.kinematic.kinematic_backend import KinematicBackend
from handcart.backends.live.sensor_errors import StaleSensor
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.ros2.bench.bench_faults import BenchFaults, TopicFault
from handcart.backends.ros2.bench.bench_messages import fix_message
from handcart.backends.ros2.bench.local_air import LocalAir, LocalLink
from handcart.backends.ros2.bench.local_bench import LocalBench
from handcart.backends.ros2.ros_backend import RosBackend
from handcart.backends.ros2.ros_gps import RosGps
from handcart.backends.ros2.ros_topics import check_ros_section
from handcart.backends.ros2.wire.messages import set_stamp
from handcart.backends.ros2.wire.ros_errors import RosFault, WrongRosSection
from handcart.files.errors import InputError
from handcart.tasks.task_names import task_path

SPEC = RosGpsSpec(origin_lat_deg=36.11, origin_lon_deg=140.1)


def receiver() -> RosGps:
    gps = RosGps("the satellite receiver", SPEC, None, lambda: 100.0)
    gps.fit(SPEC)
    return gps


def message(**changed: Any) -> Any:
    """Return a fix 300 m east and 20 m south of the origin, with some fields changed."""
    link = LocalLink(LocalAir(), "test")
    fix = fix_message(link, 100.0, SPEC, Fix(np.array([300.0, -20.0]), 0.5))
    for name, value in changed.items():
        setattr(fix, name, value)
    return fix


def test_a_fix_is_metres_from_the_origin_and_counts_once() -> None:
    gps = receiver()
    gps.heard(message())
    gps.advance()
    fix = gps.fix()
    assert fix is not None
    assert fix.position == pytest.approx([300.0, -20.0], abs=1e-3)
    assert fix.sigma == pytest.approx(0.5)
    gps.advance()
    assert gps.fix() is None


def test_a_fix_without_covariance_has_the_usual_sigma() -> None:
    gps = receiver()
    gps.heard(message(position_covariance_type=0, position_covariance=[0.0] * 9))
    gps.advance()
    fix = gps.fix()
    assert fix is not None
    assert fix.sigma == 2.5


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"status": SimpleNamespace(status=-1)}, "no fix"),
        ({"latitude": math.nan}, "its place is nan"),
        ({"longitude": 200.0}, "its place is"),
        ({"position_covariance": [0.0] * 9}, "its sigma is 0 m"),
        ({"position_covariance": [math.nan] * 9}, "its sigma is nan m"),
    ],
)
def test_a_message_that_is_no_fix_is_dropped(changed: dict[str, Any], words: str) -> None:
    gps = receiver()
    gps.heard(message(**changed))
    gps.advance()
    assert gps.fix() is None
    assert gps.rejected == (words != "no fix")
    assert words in gps.doubt


def fixes_after(time: list[float], gps: RosGps, count: int, off_s: float, **changed: Any) -> list[Fix | None]:
    """Return the fixes of one second each, with stamps that are off by a time in [s]."""
    found = []
    for _ in range(count):
        time[0] += 1.0
        arrived = message(**changed)
        set_stamp(arrived.header, time[0] + off_s)
        gps.heard(arrived)
        gps.advance()
        found.append(gps.fix())
    return found


# Of a receiver with a clock of its own, only the order of its stamps counts.
@pytest.mark.parametrize(
    ("off_s", "has_same_clock"), [(-5.0, True), (-60.0, True), (60.0, True), (-5.0, False), (-60.0, False)]
)
def test_a_receiver_whose_time_is_set_stops_the_robot(off_s: float, has_same_clock: bool) -> None:
    time = [100.0]
    clock = lambda: time[0]  # noqa: E731
    gps = RosGps("the satellite receiver", SPEC, clock if has_same_clock else None, clock)
    gps.fit(SPEC)
    assert None not in fixes_after(time, gps, 3, 0.0)
    assert fixes_after(time, gps, 2, off_s) == [None] * 2
    with pytest.raises(StaleSensor, match=r"the satellite receiver \(fix\): .* ms old.*its stamp is"):
        fixes_after(time, gps, 1, off_s)
    assert None not in fixes_after(time, gps, 3, 60.0 if not has_same_clock else 0.0)


def test_a_receiver_without_a_fix_is_no_fault_however_long() -> None:
    time = [100.0]
    gps = RosGps("the satellite receiver", SPEC, None, lambda: time[0])
    gps.fit(SPEC)
    assert fixes_after(time, gps, 60, 0.0, status=SimpleNamespace(status=-1)) == [None] * 60
    gps.advance()
    assert gps.fix() is None
    assert gps.rejected == 0
    with pytest.raises(StaleSensor, match="its place is nan"):
        fixes_after(time, gps, 60, 0.0, latitude=math.nan)


@pytest.mark.parametrize("has_fix", [True, False])
def test_a_dead_driver_is_named_whether_it_had_a_fix_or_not(has_fix: bool) -> None:
    time = [100.0]
    gps = RosGps("the satellite receiver", SPEC, None, lambda: time[0])
    gps.fit(SPEC)
    fixes_after(time, gps, 5, 0.0, status=SimpleNamespace(status=0 if has_fix else -1))
    time[0] += 2.0
    gps.advance()
    assert gps.fix() is None
    time[0] += 0.1
    gps.advance()
    with pytest.raises(StaleSensor, match=r"\(fix\): its last reading is 2100 ms old; allowed: 2000 ms"):
        gps.fix()


def test_a_receiver_slower_than_its_stale_time_is_not_silent() -> None:
    time = [100.0]
    gps = RosGps("the satellite receiver", SPEC, None, lambda: time[0])
    gps.fit(SPEC, period_s=5.0)
    fixes_after(time, gps, 1, 0.0)
    time[0] += 9.9
    gps.advance()
    assert gps.fix() is None
    time[0] += 0.2
    gps.advance()
    with pytest.raises(StaleSensor, match="allowed: 10000 ms"):
        gps.fix()


def test_silence_is_no_fault_of_a_driver_that_is_silent_without_a_fix() -> None:
    time, spec = [100.0], SPEC.model_copy(update={"silent_without_fix": True})
    gps = RosGps("the satellite receiver", spec, None, lambda: time[0])
    gps.fit(spec)
    fixes_after(time, gps, 3, 0.0)
    for _ in range(60):
        time[0] += 1.0
        gps.advance()
        assert gps.fix() is None
    with pytest.raises(StaleSensor, match="its place is nan"):
        fixes_after(time, gps, 5, 0.0, latitude=math.nan)


def test_a_receiver_without_an_origin_is_refused() -> None:
    with pytest.raises(WrongRosSection, match="needed: origin_lat_deg and origin_lon_deg"):
        check_ros_section(load_robot("el_verde"), RosSpec())


WORLD = task_path("deploy_straight").parent / "world.yaml"


def test_fixes_of_an_outdoor_robot_come_by_topic() -> None:
    robot, world = load_robot("el_verde"), WORLD
    with RosBackend.build_on_bench(robot, world, 0, KinematicBackend) as backend:
        own, inner = backend.get(Gps), backend.inner.get(Gps)  # type: ignore[type-abstract,union-attr]
        assert isinstance(own, RosGps)
        assert inner is not None
        seen = 0
        for _ in range(round(2.0 / backend.period)):
            backend.step()
            true, read = inner.fix(), own.fix()
            assert (true is None) == (read is None)
            if true is not None and read is not None:
                seen += 1
                assert read.position == pytest.approx(true.position, abs=1e-3)
        assert seen == 2


def rover(world: Path, *faults: str, **changed: object) -> RosBackend:
    """Return an outdoor robot over the bench, with faults of topics and changed keys of its receiver."""
    robot = load_robot("el_verde")
    assert robot.ros2 is not None and robot.ros2.gps is not None
    spec = robot.ros2.model_copy(update={"gps": robot.ros2.gps.model_copy(update=changed)})
    robot = robot.model_copy(update={"ros2": spec}).read_in(robot.folder)
    planned = BenchFaults(robot.period_s, tuple(map(TopicFault.read, faults)))
    return RosBackend(robot, LocalBench(robot, spec, KinematicBackend.build(robot, world, 0), planned))


def count_fixes(backend: RosBackend, seconds: float) -> int:
    """Let some seconds pass, and return the number of fixes."""
    gps = backend.get(Gps)  # type: ignore[type-abstract]
    assert gps is not None
    found = 0
    for _ in range(round(seconds / backend.period)):
        backend.step()
        found += gps.fix() is not None
    return found


@pytest.mark.parametrize("fault", ["silent", "nan", "frozen", "old-stamps", "wrong-frame"])
def test_a_spoiled_topic_of_fixes_is_named_within_three_seconds(fault: str) -> None:
    with rover(WORLD, f"{fault}@fix@3") as backend:
        assert count_fixes(backend, 2.0) == 2
        with pytest.raises(StaleSensor, match=r"the satellite receiver \(fix\): its last reading is"):
            count_fixes(backend, 4.0)


@pytest.mark.parametrize("is_silent", [False, True])
def test_an_outage_of_the_simulated_sky_is_no_dead_driver(tmp_path: Path, is_silent: bool) -> None:
    content = yaml.safe_load(WORLD.read_text())
    content["sky"] = {**content.get("sky", {}), "outages": [{"from_s": 3.0, "to_s": 13.0}]}
    world = tmp_path / "world.yaml"
    world.write_text(yaml.safe_dump(content))
    with rover(world, silent_without_fix=is_silent) as backend:
        assert count_fixes(backend, 16.0) == 6
        assert "rejected_messages" not in backend.figures()


def test_a_driver_that_may_be_silent_but_ended_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    with rover(WORLD, silent_without_fix=True) as backend:
        count_fixes(backend, 2.0)
        published = LocalLink.publishers
        monkeypatch.setattr(
            LocalLink, "publishers", lambda link, topic: [] if topic == "fix" else published(link, topic)
        )
        with pytest.raises(RosFault, match=r"\(fix\): nobody publishes it any more"):
            count_fixes(backend, 2.0)


def test_nan_in_pictures_is_refused_as_a_fault() -> None:
    planned = BenchFaults(0.05, (TopicFault.read("nan@camera/image_raw"),))
    with pytest.raises(InputError, match="has no effect on pictures"):
        planned.check({"camera/image_raw": "sensor_msgs/Image"}, [])
