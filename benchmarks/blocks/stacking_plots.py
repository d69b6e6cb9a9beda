"""Plots like figures 4 and 5 of Hatano et al. (2000)."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from handcart.evaluation.viewing.drawing.figure_file import save_figure

from .stacking_experiment import Experiment

# In plain words: mathematical letters are drawn one by one, and browsers overlap them.
AXIS_LABELS = ("error in x [mm]", "error in y [mm]", "processed error in x [mm]", "processed error in y [mm]")


def plot_against_motion(experiment: Experiment, path: Path) -> None:
    """Figure 4: errors against how the base had turned and leaned when the block was let go."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 7.0), layout="constrained")
    axes = figure.subplots(2, 2, sharex=True, sharey=True)
    for column, (axis, label) in enumerate(
        zip(axes.T.ravel(), (AXIS_LABELS[0], AXIS_LABELS[2], AXIS_LABELS[1], AXIS_LABELS[3]), strict=True)
    ):
        which = (0, 2, 1, 3)[column]
        yaw, lean, error = (experiment.errors[..., i].ravel() for i in (4, 5, which))
        dots = axis.scatter(yaw, error, c=lean, s=14, cmap="cividis")
        axis.axhline(0.0, color="0.7", linewidth=0.8)
        axis.set_ylabel(label)
        if axis in axes[1]:
            axis.set_xlabel("turn of the base Δψ [mrad]")
    figure.colorbar(dots, ax=axes, label="lean of the base Δφ [mrad]")
    save_figure(figure, path)


def plot_by_block(experiment: Experiment, path: Path) -> None:
    """Figure 5: errors over trials and blocks."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 6.5), layout="constrained")
    axes = figure.subplots(2, 2, sharex=True, sharey=True)
    most = float(np.nanmax(np.abs(experiment.errors[..., 0:2])))
    pictures = []
    for which, axis in zip((0, 1, 2, 3), axes.ravel(), strict=True):
        values = experiment.errors[..., which].T
        shown = axis.imshow(values, cmap="RdBu_r", vmin=-most, vmax=most, aspect="auto", origin="lower")
        pictures.append(shown)
        axis.set_title(AXIS_LABELS[which], fontsize=10)
        axis.set_yticks(range(values.shape[0]), [str(i + 1) for i in range(values.shape[0])])
    for axis in axes[1]:
        axis.set_xlabel("trial")
        axis.xaxis.get_major_locator().set_params(integer=True)
    for axis in axes[:, 0]:
        axis.set_ylabel("block")
    figure.colorbar(pictures[0], ax=axes, label="[mm]")
    save_figure(figure, path)
