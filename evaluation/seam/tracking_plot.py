"""Plot of the tool's distance from its path, as in figure 5 of Shin (2005)."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from handcart.evaluation.viewing.drawing.figure_file import save_figure
from handcart.evaluation.viewing.drawing.palette import BLACK, BLUE, GREY, VERMILION
from handcart.robotics.numerics.arrays import FloatArray

PAPER_MM = ((1.0, "Shin (2005), figure 5a, standing: below 1 mm"), (25.0, "figure 5b, moving: above 25 mm"))
LOG_FROM = 10.0  # where the largest of the errors is that many times the smallest of the panels'


def draw_tracking_errors(
    runs: Sequence[tuple[str, FloatArray, FloatArray]], target: Path, limit_mm: float | None = None
) -> None:
    """Draw the distance of the tool from its path over time, one panel for each run, all of one scale.

    Args:
        runs: title, times (k,) in [s] and errors (k,) in [m] of each run.
        target: file to write.
        limit_mm: largest allowed error, in [mm]; None: no limit is drawn.

    Raises:
        OSError: the file cannot be written.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 1.0 + 2.2 * len(runs)), layout="constrained")
    axes = figure.subplots(len(runs), 1, squeeze=False, sharey=True)[:, 0]
    most = [1e3 * float(errors.max()) for _, _, errors in runs]
    for axis, (title, times, errors), highest in zip(axes, runs, most, strict=True):
        millimetres = 1e3 * errors
        axis.plot(times, millimetres, color=BLUE, lw=0.8, label="the tool's distance from the seam")
        if limit_mm is not None:
            axis.axhline(limit_mm, color=VERMILION, lw=1.2, label=f"limit {limit_mm:.2f} mm")
        for value, label in PAPER_MM:
            style = {"color": BLACK, "lw": 1.0, "ls": "--" if value < 2.0 else ":"}
            if value < 3.0 * max(most):
                axis.axhline(value, label=label, **style)
            else:
                axis.plot([], [], label=f"{label}, beyond the picture", **style)
        rms = np.sqrt(np.mean(millimetres**2))
        axis.set_title(f"{title}: at most {highest:.2f} mm, rms {rms:.2f} mm", fontsize=10)
        axis.set_ylabel("error [mm]")
        axis.grid(alpha=0.3, color=GREY)
    if max(most) > LOG_FROM * min(most):
        axes[0].set_yscale("log")
        axes[0].set_ylim(bottom=0.01)
    else:
        axes[0].set_ylim(bottom=0.0)
    axes[-1].set_xlabel("time [s]")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=2, fontsize=8)
    save_figure(figure, target, dpi=110)
