"""Read the folder of a run, and draw the driven path over the map."""

import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")  # no window: the picture goes into a file
import matplotlib.pyplot as plt

import handcart
from handcart.files.maps.map_file import load_map


def main() -> None:
    if len(sys.argv) > 1:
        folder = Path(sys.argv[1])
    else:
        folder = handcart.run("drive_map", robot="cart", set={"tour": ["desk"]}).folder
    run = handcart.load_run(folder)
    map_file = handcart.load_task("drive_map").path("knowledge", "map")
    grid, _ = load_map(map_file)
    rows, columns = grid.occupied.shape
    left, low, cell = grid.origin_x, grid.origin_y, grid.resolution
    extent = (left, left + columns * cell, low, low + rows * cell)
    figure, axes = plt.subplots(figsize=(8, 5))
    axes.imshow(grid.occupied, cmap="Greys", origin="lower", extent=extent)
    axes.plot(run.track.pose[:, 0], run.track.pose[:, 1], label="estimated pose of the base")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    axes.legend()
    figure.savefig("path.png", dpi=100)
    plt.close(figure)
    print(f"{len(run.track.time)} poses over {run.track.time[-1]:.1f} s, drawn into path.png")


if __name__ == "__main__":
    main()
