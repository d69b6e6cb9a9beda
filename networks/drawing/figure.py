"""A network's picture as PNG and PDF."""

from __future__ import annotations

from io import BytesIO
from typing import Any

from .layers import Point
from .network_picture import DrawnBox, DrawnFrame, DrawnLink, NetworkPicture, Text
from .styles import style_of_box, style_of_link
from .text_width import FONT_FAMILY

PX_PER_INCH = 72.0  # [px]: a letter's size in [px] is then that in points
PNG_DOTS_PER_INCH = 144.0  # [dots per inch] of PNG
MAX_SIDE_DOTS = 20_000.0


def to_png(picture: NetworkPicture) -> bytes:
    """Return the picture as PNG, at twice its size, or less if a side would exceed `MAX_SIDE_DOTS` pixels."""
    dense = min(PNG_DOTS_PER_INCH, PX_PER_INCH * MAX_SIDE_DOTS / max(picture.width, picture.height))
    return _saved(picture, format="png", dpi=dense)


def to_pdf(picture: NetworkPicture) -> bytes:
    """Return the picture of a network as the bytes of a PDF file with one page."""
    return _saved(picture, format="pdf", metadata={"CreationDate": None})


def figure_of(picture: NetworkPicture) -> Any:
    """Return the picture as a matplotlib figure."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(picture.width / PX_PER_INCH, picture.height / PX_PER_INCH), dpi=PX_PER_INCH)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set(xlim=(0.0, picture.width), ylim=(picture.height, 0.0))
    axes.set_axis_off()
    for frame in picture.frames:
        axes.add_patch(_rounded(frame, 6.0, facecolor="none", edgecolor="#5b6b7d", linewidth=1.0))
    for link in picture.links:
        _draw_link(axes, link)
    for box in picture.boxes:
        style = style_of_box(box)
        line = (0.0, style.dash) if style.dash else "-"
        edge = {"edgecolor": style.colour, "linewidth": style.width, "linestyle": line}
        axes.add_patch(_rounded(box, style.round, facecolor=style.fill, **edge))
    for text in picture.texts:
        _draw_text(axes, text)
    return figure


def _saved(picture: NetworkPicture, **options: Any) -> bytes:
    drawn = BytesIO()
    figure_of(picture).savefig(drawn, **options)
    return drawn.getvalue()


def _rounded(box: DrawnBox | DrawnFrame, radius: float, **style: Any) -> Any:
    from matplotlib.patches import FancyBboxPatch

    shape = f"round,pad=0,rounding_size={radius}"
    return FancyBboxPatch((box.x, box.y), box.width, box.height, boxstyle=shape, **style)


def _draw_link(axes: Any, link: DrawnLink) -> None:
    from matplotlib.patches import PathPatch, Polygon
    from matplotlib.path import Path

    points, codes = [link.points[0]], [Path.MOVETO]
    for bends in link.curves():
        points += bends
        codes += [Path.CURVE4] * 3
    style = style_of_link(link)
    line = (0.0, (5.0, 4.0)) if link.failed else "-"
    path = Path(points, codes)
    axes.add_patch(PathPatch(path, fill=False, edgecolor=style.colour, linewidth=style.width, linestyle=line))
    if link.arrow:
        end = link.points[-1]
        tip = [end, Point(end.x - 8.0, end.y - 4.0), Point(end.x - 8.0, end.y + 4.0)]
        axes.add_patch(Polygon(tip, facecolor=style.colour, edgecolor="none"))


def _draw_text(axes: Any, text: Text) -> None:
    axes.text(
        text.x,
        text.y,
        text.words,
        fontfamily=FONT_FAMILY,
        fontsize=text.size,
        fontweight="bold" if text.bold else "normal",
        color="#1d2733",
        ha="center" if text.centred else "left",
        va="baseline",
        parse_math=False,
    )
