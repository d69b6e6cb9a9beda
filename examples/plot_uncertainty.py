"""Drive down a corridor that has pillars in its first half alone, and draw how well the pose is known.

Along plain walls a lidar measures the distance to both walls and the heading, but not the position along
the corridor. There the covariance grows with the driven distance, in that direction alone.
"""

from __future__ import annotations

import json
from pathlib import Path

import matplotlib

matplotlib.use("Agg")  # no window: the picture goes into a file
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import Ellipse
from PIL import Image

from handcart.evaluation.trials.rig import Rig, RigFiles, build_rig
from handcart.primitives.contract.attempt import attempt
from handcart.primitives.driving.move_to import MoveTo

CELL_M, LENGTH_M, WIDTH_M = 0.05, 60.0, 3.2
ELLIPSE_SCALE = 10.0  # of the drawn ellipses
DRAWN_PLACES = {
    "home": (3.3, 40.0),
    "pillars": (15.0, 40.0),
    "plain": (45.0, 40.0),
    "plain_500": (45.0, 500.0),
}


def make_corridor(folder: Path) -> RigFiles:
    """Write a map, its places and a world; they are the files of a rig."""
    cells = np.full((round(WIDTH_M / CELL_M), round(LENGTH_M / CELL_M)), 254, np.uint8)
    cells[:2] = cells[-2:] = 0
    cells[:, :2] = cells[:, -2:] = 0
    for column in range(100, 420, 60):
        cells[2:8, column : column + 6] = cells[-8:-2, column : column + 6] = 0
    Image.fromarray(cells).save(folder / "corridor.png")
    (folder / "corridor.yaml").write_text(
        f"image: corridor.png\nresolution: {CELL_M}\norigin: [0, 0, 0]\nnegate: 0\n"
        "occupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )
    places = {
        name: {"x_m": x, "y_m": WIDTH_M / 2, "heading_deg": 0.0, "tolerance_mm": tolerance}
        for name, (x, tolerance) in DRAWN_PLACES.items()
    }
    (folder / "places.yaml").write_text(json.dumps({"format": "handcart-places/1", "places": places}))
    return RigFiles(folder / "corridor.yaml", folder / "corridor.yaml", folder / "places.yaml", {})


def drive(rig: Rig, place: str) -> tuple[list[tuple[float, float, np.ndarray]], str]:
    """Drive to a place; return x and y in [m] and their covariance of each period, and the outcome."""
    estimates = []
    periods = attempt(MoveTo(place=place), rig.robot, rig.model)
    while True:
        try:
            next(periods)
        except StopIteration as end:
            outcome = end.value
            return estimates, f"{type(outcome).__name__} {getattr(outcome, 'reason', '')}".strip()
        rig.robot.step()
        pose = rig.robot.pose
        estimates.append((pose.x, pose.y, rig.robot.localization.covariance[:2, :2]))


def draw(axes: plt.Axes, estimates: list[tuple[float, float, np.ndarray]]) -> None:
    """Draw an ellipse of 3 sigma every 1.5 m, enlarged."""
    drawn = -np.inf
    for x, y, covariance in estimates:
        if x - drawn >= 1.5:
            variances, directions = np.linalg.eigh(covariance)
            width, height = 2 * 3 * ELLIPSE_SCALE * np.sqrt(np.maximum(variances, 0.0))
            angle = np.degrees(np.arctan2(directions[1, 0], directions[0, 0]))
            axes.add_patch(Ellipse((x, y), width, height, angle=angle, fill=False, color="tab:red"))
            drawn = x


def main() -> None:
    folder = Path("corridor")
    folder.mkdir(exist_ok=True)
    files = make_corridor(folder)
    figure, axes = plt.subplots(figsize=(11, 1.3), layout="constrained")
    axes.imshow(plt.imread(folder / "corridor.png"), cmap="gray", extent=(0, LENGTH_M, 0, WIDTH_M))
    with build_rig(files, robot="cart", seed=1) as rig:
        for place in ("pillars", "plain", "plain_500"):
            estimates, ended = drive(rig, place)
            print(f"{place}: {ended}")
            if place != "plain_500":
                draw(axes, estimates)
    axes.set_title(f"ellipses: 3 sigma of the position, {ELLIPSE_SCALE:.0f} times as large", fontsize="small")
    axes.set_xlabel("x [m]")
    figure.savefig("uncertainty.png", dpi=110)
    plt.close(figure)


if __name__ == "__main__":
    main()
