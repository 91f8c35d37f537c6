"""A run as a strip: actions as bars in simulated time, disturbances and new versions of the tree as marks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from llmbt_ir.quoting import escape

__all__ = ["timeline"]

WIDTH, ROW, LEFT, RIGHT = 1_060.0, 17.0, 250.0, 20.0
COLOURS = {"SUCCESS": "#7fb685", "FAILURE": "#d1495b", "HALTED": "#e0b04e"}


def timeline(actions: Sequence[Mapping[str, Any]], marks: Sequence[tuple[float, str, str]], end_s: float) -> str:
    """The strip as SVG; `marks` are (time, kind, text), kind `disturbance` or `update`."""
    names = list(dict.fromkeys(_call(a) for a in actions))
    height = 34 + ROW * len(names) + 24
    scale = (WIDTH - LEFT - RIGHT) / max(end_s, 0.1)

    def x(time_s: float) -> float:
        return LEFT + time_s * scale

    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH:.0f} {height:.0f}" '
        'font-family="ui-monospace,Menlo,Consolas,monospace" font-size="11">'
    ]
    for time_s, kind, text in marks:
        colour = "#b26a00" if kind == "disturbance" else "#1b6ca8"
        lines.append(
            f'<g stroke="{colour}" fill="{colour}"><title>{escape(f"{time_s:.1f} s: {text}")}</title>'
            f'<line x1="{x(time_s):.1f}" x2="{x(time_s):.1f}" y1="14" y2="{height - 20:.0f}" stroke-dasharray="3 2"/>'
            f'<text stroke="none" x="{x(time_s) + 2:.1f}" y="{12 if kind == "disturbance" else 26}">'
            f"{escape(text if len(text) < 26 else text[:25] + '…')}</text></g>"
        )
    for k, name in enumerate(names):
        y = 34 + ROW * k
        lines.append(
            f'<text x="{LEFT - 8:.0f}" y="{y + 11:.1f}" text-anchor="end" fill="#1c2733">{escape(name)}</text>'
        )
    for action in actions:
        since, until = float(action["started_s"]), float(action["ended_s"])
        told = f"{_call(action)}: {action['result']} {action.get('reason', '')} ({since:.1f}-{until:.1f} s)"
        place = f'x="{x(since):.1f}" y="{34 + ROW * names.index(_call(action)):.1f}"'
        size = f'width="{max(1.5, (until - since) * scale):.1f}" height="{ROW - 4:.0f}"'
        colour = COLOURS.get(str(action["result"]), "#9aa5b1")
        lines.append(f'<rect {place} {size} rx="2" fill="{colour}"><title>{escape(told)}</title></rect>')
    base = height - 16
    lines.append(f'<line x1="{LEFT}" x2="{WIDTH - RIGHT}" y1="{base}" y2="{base}" stroke="#9aa5b1"/>')
    step = next(s for s in (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 10**6) if end_s / s <= 12)
    tick = f'y="{height - 4:.0f}" text-anchor="middle" fill="#66727f"'
    lines += [f'<text x="{x(i * step):.1f}" {tick}>{i * step} s</text>' for i in range(int(end_s / step) + 1)]
    return "\n".join([*lines, "</svg>"])


def _call(action: Mapping[str, Any]) -> str:
    return f"{action['name']}({', '.join(action['args'])})"
