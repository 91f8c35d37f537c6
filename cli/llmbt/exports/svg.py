"""A tree as a picture that stands on its own: SVG, laid out here, in the paper's shapes."""

from __future__ import annotations

from collections.abc import Iterator

from llmbt.exports.layout import arrange
from llmbt.picture import Box, Picture, Shape
from llmbt_ir.quoting import escape

__all__ = ["svg"]

WIDE = 1_600
"""Pixels: a tree that would be wider is drawn from left to right."""
CHARACTER, HEIGHT, GAP, MARGIN, LONGEST = 6.6, 26.0, 10.0, 16.0, 60
LEVEL_DOWN, LEVEL_RIGHT = 56.0, 20.0
FILL = {"SUCCESS": "#d7f0d8", "FAILURE": "#f8d7d7", "RUNNING": "#fdeec4", "": "#ffffff"}
STROKE = {"SUCCESS": "#2e7d32", "FAILURE": "#b3261e", "RUNNING": "#b26a00", "": "#3c4858"}
STYLE = (
    "text{font:11px ui-monospace,SFMono-Regular,Menlo,Consolas,monospace;text-anchor:middle;dominant-baseline:central;"
    "fill:#1c2733}.e{fill:none;stroke:#8a97a6;stroke-width:1}.n{stroke-width:1.3}"
)


def svg(picture: Picture, *, title: str = "", direction: str = "auto") -> str:
    """The picture; `direction` is down, right, or auto: down unless that is too wide to be seen at once."""
    boxes = {b.id: b for b in picture.preorder()}
    children = {i: b.children for i, b in boxes.items()}
    width = {i: _width(b) for i, b in boxes.items()}
    if direction != "right":
        places = arrange(picture.tops, children, width, GAP)
        left = min((p.across - width[i] / 2 for i, p in places.items()), default=0.0)
        right = max((p.across + width[i] / 2 for i, p in places.items()), default=0.0)
        if direction == "down" or right - left + 2 * MARGIN <= WIDE:
            at = {i: (p.across - left + MARGIN, p.level * LEVEL_DOWN + MARGIN + HEIGHT / 2) for i, p in places.items()}
            return _document(boxes, at, width, title, down=True)
    return _document(boxes, _rows(picture, boxes, width), width, title, down=False)


def _rows(picture: Picture, boxes: dict[str, Box], width: dict[str, float]) -> dict[str, tuple[float, float]]:
    """Centres for a tree from left to right: a row for each leaf, inner nodes in the row of their first leaf. Each
    level begins where the widest inner node of the one before it ends, so that nothing lies on anything."""
    level: dict[str, int] = dict.fromkeys(picture.tops, 0)
    inner: list[float] = []
    for id_, box in boxes.items():
        level.update(dict.fromkeys(box.children, level[id_] + 1))
        if box.children:
            inner.extend([0.0] * (level[id_] + 1 - len(inner)))
            inner[level[id_]] = max(inner[level[id_]], width[id_])
    start = [MARGIN]
    for wide in inner:
        start.append(start[-1] + wide + LEVEL_RIGHT)
    row, at = MARGIN + HEIGHT / 2, {}
    for id_, box in boxes.items():
        at[id_] = (start[level[id_]] + width[id_] / 2, row)
        row += 0.0 if box.children else HEIGHT + GAP / 2
    return at


def _text(box: Box) -> str:
    text = {"->": "→", "->*": "→*", "->**": "→**"}.get(box.text, box.text)
    return text if len(text) <= LONGEST else text[: LONGEST - 1] + "…"


def _width(box: Box) -> float:
    slack = 24.0 if box.shape in (Shape.CONDITION, Shape.DECORATOR) else 16.0
    return max(HEIGHT, CHARACTER * len(_text(box)) + slack)


def _document(
    boxes: dict[str, Box], at: dict[str, tuple[float, float]], width: dict[str, float], title: str, *, down: bool
) -> str:
    right = max((x + width[i] / 2 for i, (x, _) in at.items()), default=0.0) + MARGIN
    bottom = max((y for _, y in at.values()), default=0.0) + HEIGHT / 2 + MARGIN
    size = f'width="{right:.0f}" height="{bottom:.0f}" viewBox="0 0 {right:.0f} {bottom:.0f}"'
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" {size}>',
        f"<title>{escape(_clean(title))}</title>" if title else "",
        f"<style>{STYLE}</style>",
        f'<rect width="{right:.0f}" height="{bottom:.0f}" fill="#ffffff"/>',
    ]
    lines += [_edge(at[b.id], at[c], width[b.id], width[c], down) for b in boxes.values() for c in b.children]
    for box in boxes.values():
        lines.extend(_node(box, *at[box.id], width[box.id]))
    lines.append("</svg>")
    return "\n".join(line for line in lines if line) + "\n"


def _edge(a: tuple[float, float], b: tuple[float, float], wide: float, wide_b: float, down: bool) -> str:
    if down:
        y, end = a[1] + HEIGHT / 2, b[1] - HEIGHT / 2
        middle = (y + end) / 2
        curve = f"M{a[0]:.1f} {y:.1f}C{a[0]:.1f} {middle:.1f} {b[0]:.1f} {middle:.1f} {b[0]:.1f} {end:.1f}"
    else:
        end = b[0] - wide_b / 2
        bend = end - LEVEL_RIGHT / 2
        curve = f"M{a[0] + wide / 2:.1f} {a[1]:.1f}H{bend:.1f}V{b[1]:.1f}H{end:.1f}"
    return f'<path class="e" d="{curve}"/>'


def _node(box: Box, x: float, y: float, width: float) -> Iterator[str]:
    """A condition is an ellipse, an action a box, a decorator a rhombus, a subtree a box with a double rim."""
    paint = f'class="n" fill="{FILL[box.status]}" stroke="{STROKE[box.status]}"'
    left, top = x - width / 2, y - HEIGHT / 2
    rect = f'<rect x="{left:.1f}" y="{top:.1f}" width="{width:.1f}" height="{HEIGHT:.0f}"'
    yield f"<g><title>{escape(_clean(f'{box.text} {box.status}'.strip()))}</title>"
    if box.shape is Shape.CONDITION:
        yield f'<ellipse cx="{x:.1f}" cy="{y:.1f}" rx="{width / 2:.1f}" ry="{HEIGHT / 2:.0f}" {paint}/>'
    elif box.shape is Shape.DECORATOR:
        right, bottom = x + width / 2, top + HEIGHT
        yield f'<path d="M{left:.1f} {y:.1f}L{x:.1f} {top:.1f}L{right:.1f} {y:.1f}L{x:.1f} {bottom:.1f}Z" {paint}/>'
    else:
        yield f'{rect} rx="{0 if box.shape in (Shape.SEQUENCE, Shape.FALLBACK) else 4}" {paint}/>'
        if box.shape is Shape.SUBTREE:
            inside = f'x="{left + 3:.1f}" y="{top + 3:.1f}" width="{width - 6:.1f}" height="{HEIGHT - 6:.0f}"'
            yield f'<rect {inside} fill="none" stroke="{STROKE[box.status]}"/>'
    bold = ' font-weight="bold"' if box.shape in (Shape.SEQUENCE, Shape.FALLBACK) else ""
    yield f'<text x="{x:.1f}" y="{y:.1f}"{bold}>{escape(_clean(_text(box)))}</text></g>'


def _clean(text: str) -> str:
    """Text that XML can hold."""
    return "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in text)
