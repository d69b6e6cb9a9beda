"""Report of `handcart check` on a CAN bus, without opening one."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import can
import pytest

from tests.tools.conftest import Said

CART = Path(__file__).resolve().parents[3] / "backends" / "robots" / "cart"
IMU_LINK = """<link name="imu"/><joint name="imu_mount" type="fixed"><parent link="base"/><child link="imu"/>
</joint></robot>"""


@pytest.fixture
def cart(tmp_path: Path) -> Callable[..., Path]:
    """The cart's file, changed."""

    def changed(**pairs: str) -> Path:
        for item in CART.iterdir():
            (tmp_path / item.name).write_bytes(item.read_bytes())
        path = tmp_path / "robot.yaml"
        text = path.read_text(encoding="utf-8")
        for key, value in pairs.items():
            lines = [
                f"  {key}: {value}" if line.startswith(f"  {key}:") else line for line in text.splitlines()
            ]
            text = "\n".join(lines) + "\n"
        path.write_text(text, encoding="utf-8")
        return path

    return changed


def test_each_frame_is_told_with_its_bits(handcart: Callable[..., Said], cart: Callable[..., Path]) -> None:
    said = handcart("check", cart())
    assert said.status == 0
    assert "181h    left wheel: answer 1        7       125             50 ms   0.50%" in said.out
    assert "CAN bus: 4.0% of 500 kbit/s" in said.out
    bus = json.loads(handcart("check", cart(), "--json").out)["robot"]["bus"]
    assert bus["share"] == pytest.approx(0.04, abs=1e-3)
    assert sum(frame["share"] for frame in bus["frames"]) == pytest.approx(bus["share"], abs=1e-4)


def test_c19_an_overloaded_bus_is_refused(handcart: Callable[..., Said], cart: Callable[..., Path]) -> None:
    """C19: more than 70 % by what goes over it each period."""
    path = cart(bitrate_kbit_s="20")
    said = handcart("check", path)
    assert said.status == 2
    line = next(
        n for n, text in enumerate(path.read_text().splitlines(), 1) if text.startswith("  bitrate_kbit_s")
    )
    wrong = "cyclic frames take 100% of the bus at this bit rate and 0.05 s a period; allowed: at most 70%"
    assert said.err.strip() == f"{path}:{line}:19: {wrong}"


def test_localizer_by_gyros_without_a_connected_imu_is_refused(
    handcart: Callable[..., Said], cart: Callable[..., Path]
) -> None:
    path = cart(interface="socketcan")
    urdf, text = path.parent / "cart.urdf", path.read_text(encoding="utf-8")
    urdf.write_text(urdf.read_text(encoding="utf-8").replace("</robot>", IMU_LINK), encoding="utf-8")
    imu = "ground: {}\nimu: {accelerometer_sigma_m_s2: 0.05, angle_random_walk_deg_rt_s: 0.02}\n"
    path.write_text(text.replace("localizer: scan", "localizer: gyro") + imu, encoding="utf-8")
    said = handcart("check", path)
    assert said.status == 2
    assert "`localizer: gyro` asks the gyros, and no IMU is connected; needed: the key `imu` of" in said.err
    path.write_text(path.read_text(encoding="utf-8").replace("socketcan", "virtual"), encoding="utf-8")
    assert handcart("check", path).status == 0


@pytest.mark.parametrize("words", [("check",), ("run", "--dry-run")])
def test_nothing_is_opened(
    handcart: Callable[..., Said],
    cart: Callable[..., Path],
    monkeypatch: pytest.MonkeyPatch,
    tour: Path,
    words: tuple[str, ...],
) -> None:
    """No drive is spoken to, let alone enabled."""

    def opened(*_: object, **__: object) -> None:
        raise AssertionError("a bus was opened")

    monkeypatch.setattr(can, "Bus", opened)
    sensors = "\n  sensors: {range_sensor: {port: /dev/ttyUSB0}}"
    robot = cart(interface="socketcan", channel=f"can0{sensors}")
    tour.write_text(tour.read_text().replace("robot: librarian", f"robot: {robot.name}\nbackend: can"))
    command, *options = words
    said = handcart(command, tour, *options)
    assert (said.status, said.err) == (0, "")


def test_what_the_robot_lacks_is_told_without_opening_it(
    handcart: Callable[..., Said], cart: Callable[..., Path], tour: Path
) -> None:
    robot = cart(interface="socketcan", channel="can0")
    tour.write_text(tour.read_text().replace("robot: librarian", f"robot: {robot.name}\nbackend: can"))
    said = handcart("check", tour)
    assert said.status == 2
    assert "MOVE_TO needs what the robot doesn't have: RangeSensor; it has: " in said.err


def test_a_makers_file_is_read(
    handcart: Callable[..., Said], cart: Callable[..., Path], tmp_path: Path
) -> None:
    """Its faults are reported at their places, together with those of the robot's file."""
    own = (CART.parents[1] / "can" / "drives" / "drive.eds").read_text(encoding="utf-8")
    wheel = "{node: 1, counts_per_rev: 16384, gear_ratio: 20, sign: 1, eds: maker.eds}"
    robot = cart(left=wheel)
    assert "missing file 'maker.eds'" in handcart("check", robot).err
    maker = tmp_path / "maker.eds"
    maker.write_text(own.replace("[60FF]", "[60FE]"), encoding="utf-8")
    said = handcart("check", robot)
    assert said.status == 2
    assert said.err.strip() == f"{maker}:1:1: it describes no 60FFh (for a PDO); needed: all of them"
    maker.write_text(own.replace("DataType=0x0006", "DataType=word", 1), encoding="utf-8")
    line = own[: own.index("DataType=0x0006")].count("\n") + 1
    assert f"{maker}:{line}:10: DataType in [" in handcart("check", robot).err
    maker.write_text(own, encoding="utf-8")
    assert handcart("check", robot).status == 0
