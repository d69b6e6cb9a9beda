"""Plot of the blocks' errors, block by block, as figures 4 and 5 of Hatano et al. (2000)."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from handcart.evaluation.viewing.drawing.figure_file import save_figure
from handcart.evaluation.viewing.drawing.palette import BLACK, BLUE, GREY, ORANGE, VERMILION

if TYPE_CHECKING:
    from .block_error import BlockError

PAPER_MM = 1.5  # within which all processed errors of figure 4 are


def draw_stacking_errors(
    errors: Sequence[BlockError], target: Path, limit_mm: float, processed: bool
) -> None:
    """Plot the true errors of blocks along x and y over the blocks' numbers, and as points from above.

    Args:
        errors: errors of the placed blocks.
        target: file to write.
        limit_mm: maximum allowed error, in [mm].
        processed: True to plot also the errors without the effect of the base's turn and tilt (Hatano et al.
            2000, eq. 12).

    Raises:
        OSError: the file cannot be written.
    """
    from matplotlib.figure import Figure
    from matplotlib.patches import Circle

    figure = Figure(figsize=(10.0, 4.6), layout="constrained")
    axes = figure.subplot_mosaic([["x", "above"], ["y", "above"]], width_ratios=[1.3, 1.0])
    numbers = [error.number for error in errors]
    reach = max(2.0 * PAPER_MM, *(1.2 * abs(value) for error in errors for value in (error.x, error.y)))
    limit = f"limit {limit_mm:g} mm{', beyond the picture' if limit_mm > reach else ''}"
    for name in "xy":
        axis = axes[name]
        axis.plot(
            numbers, [getattr(error, name) for error in errors], "o", color=BLUE, label="where it stands"
        )
        if processed:
            values = [getattr(error, f"processed_{name}") for error in errors]
            axis.plot(numbers, values, "s", mfc="none", color=ORANGE, label="processed (eq. 12)")
        for sign in (-1.0, 1.0):
            axis.axhline(sign * limit_mm, color=VERMILION, lw=1.2, label=limit if sign > 0 else None)
            label = f"processed ones of the paper's figure 4: within {PAPER_MM} mm" if sign > 0 else None
            axis.axhline(sign * PAPER_MM, color=BLACK, lw=1.0, ls="--", label=label)
        axis.axhline(0.0, color=GREY, lw=0.6)
        axis.set_ylabel(f"error in {name} [mm]")
        axis.set_ylim(-reach, reach)
        axis.set_xticks(numbers[:: 1 + len(numbers) // 20])
    axes["y"].set_xlabel("number of the block")
    above = axes["above"]
    above.plot([error.x for error in errors], [error.y for error in errors], "o", color=BLUE)
    above.add_patch(Circle((0.0, 0.0), limit_mm, fill=False, color=VERMILION, lw=1.2))
    above.plot(0.0, 0.0, "+", color=BLACK, ms=10.0)
    above.set(aspect="equal", xlim=(-reach, reach), ylim=(-reach, reach), xlabel="x [mm]", ylabel="y [mm]")
    above.set_title(f"from above: at most {max(error.size for error in errors):.2f} mm off", fontsize=10)
    figure.legend(*axes["x"].get_legend_handles_labels(), loc="outside lower center", ncols=2, fontsize=8)
    save_figure(figure, target)
