"""A network's picture as SVG, without any external program."""

from __future__ import annotations

from collections.abc import Collection
from html import escape

from .network_picture import DrawnBox, DrawnFrame, DrawnLink, NetworkPicture, Text
from .styles import HIGHLIGHT_COLOUR, style_of_box, style_of_link

SVG_FONT_FAMILY = "'DejaVu Sans', Helvetica, Arial, sans-serif"


def to_svg(picture: NetworkPicture, lit: Collection[DrawnBox] = (), window: str | None = None) -> str:
    """Return the picture as a self-contained SVG document.

    Args:
        picture: the drawing of a network.
        lit: boxes to highlight.
        window: the visible part, in the form of `viewBox`; None: all.
    """
    size = 'width="100%"' if window else f'width="{picture.width:.0f}" height="{picture.height:.0f}"'
    seen = window or f"0 0 {picture.width:.0f} {picture.height:.0f}"
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" {size} '
        f'viewBox="{seen}" font-family="{SVG_FONT_FAMILY}" fill="#1d2733">'
        f'<rect class="paper" width="{picture.width:.0f}" height="{picture.height:.0f}" fill="#fff"/>'
    )
    parts = [
        *map(_frame, picture.frames),
        *map(_link, picture.links),
        *(_box(box, lit=box in lit) for box in picture.boxes),
        *map(_text, picture.words),
    ]
    return "\n".join([head, *parts, "</svg>"]) + "\n"


def _frame(frame: DrawnFrame) -> str:
    corners = f'x="{frame.x:.1f}" y="{frame.y:.1f}" width="{frame.width:.1f}" height="{frame.height:.1f}"'
    return f'<rect class="frame" {corners} rx="6" fill="none" stroke="#5b6b7d"/>\n{_text(frame.title)}'


def _link(link: DrawnLink) -> str:
    style = style_of_link(link)
    path = [f"M{link.points[0].x:.1f} {link.points[0].y:.1f}"]
    for number, (p, q, end) in enumerate(link.curves()):
        bend = "" if number % 2 == 0 else f"{p.x:.1f} {p.y:.1f} {q.x:.1f} {q.y:.1f} "
        path.append(f"{'C' if bend else 'L'}{bend}{end.x:.1f} {end.y:.1f}")
    dash = ' stroke-dasharray="5 4"' if link.failed else ""
    line = (
        f'<path class="link" d="{"".join(path)}" fill="none" stroke="{style.colour}" '
        f'stroke-width="{style.width:g}"{dash}/>'
    )
    if not link.arrow:
        return line
    x, y = link.points[-1]
    tip = f"M{x:.1f} {y:.1f}l-8 -4v8z"
    return f'{line}\n<path d="{tip}" fill="{style.colour}"/>'


def _box(box: DrawnBox, *, lit: bool) -> str:
    style = style_of_box(box)
    fill, stroke, width = (
        (HIGHLIGHT_COLOUR, "#1d2733", 2.5) if lit else (style.fill, style.colour, style.width)
    )
    dash = f' stroke-dasharray="{style.dash[0]:g} {style.dash[1]:g}"' if style.dash else ""
    shape = (
        f'<rect class="{box.kind}" x="{box.x:.1f}" y="{box.y:.1f}" width="{box.width:.1f}" '
        f'height="{box.height:.1f}" rx="{style.round:g}" fill="{fill}" stroke="{stroke}" '
        f'stroke-width="{width:g}"{dash}/>'
    )
    return "\n".join([shape, *map(_text, box.texts)])


def _text(text: Text) -> str:
    weight = ' font-weight="bold"' if text.bold else ""
    anchor = ' text-anchor="middle"' if text.centred else ""
    words = escape(text.words)
    return f'<text x="{text.x:.1f}" y="{text.y:.1f}" font-size="{text.size:g}"{weight}{anchor}>{words}</text>'
