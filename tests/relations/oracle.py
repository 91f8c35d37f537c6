"""The same relations computed another way: corners and matrices in numpy, angles for slopes, and no shared code.

Written from docs/relations.md. Where a figure lies within EDGE of a margin both answers are right, and `near` says so.
"""

from __future__ import annotations

import itertools

import numpy as np

EDGE = 1e-7


class Oracle:
    """The viewer's coordinates (right, ahead, up) of every corner of every object, and of every place's centre."""

    def __init__(self, semantic_map):
        view = semantic_map.viewpoint
        heading = view.yaw_rad
        ahead = np.array([np.cos(heading), np.sin(heading), 0.0])
        up = np.array([0.0, 0.0, 1.0])
        self.basis = np.stack([np.cross(ahead, up), ahead, up])
        self.eye = np.array([*view.xyz_m[:2], 0.0])
        self.centre, self.low, self.high, self.volume = {}, {}, {}, {}
        for o in semantic_map.objects:
            corners = np.array(list(itertools.product(*[(-s / 2, s / 2) for s in o.size_m])))
            turned = corners @ self.rotation(o.pose.quat_xyzw).T + np.array(o.pose.xyz_m)
            seen = (turned - self.eye) @ self.basis.T
            self.low[o.id], self.high[o.id] = seen.min(axis=0), seen.max(axis=0)
            self.centre[o.id] = (np.array(o.pose.xyz_m) - self.eye) @ self.basis.T
            self.volume[o.id] = float(np.prod(o.size_m))
        self.margins: list[float] = []

    @staticmethod
    def rotation(quat):
        """By the sandwich product q v q*, on the three unit vectors."""

        def times(a, b):
            (av, aw), (bv, bw) = (a[:3], a[3]), (b[:3], b[3])
            return np.array([*(aw * bv + bw * av + np.cross(av, bv)), aw * bw - av @ bv])

        q = np.array(quat) / np.linalg.norm(quat)
        back = q * np.array([-1, -1, -1, 1])
        return np.stack([times(times(q, np.array([*e, 0.0])), back)[:3] for e in np.eye(3)], axis=1)

    def at_least(self, value, bound):
        """value >= bound, and a note of how near it was."""
        self.margins.append(abs(value - bound))
        return value >= bound

    def near(self):
        """Whether anything asked so far lay on the edge; asks anew afterwards."""
        close = any(m < EDGE for m in self.margins)
        self.margins = []
        return close

    def toward(self, a, b, direction):
        """Whether a lies from b towards a unit direction: 25 mm along it, within arctan 0.7 of it."""
        way = (self.centre[a] - self.centre[b])[:2]
        along = float(way @ direction)
        angle = float(np.arccos(np.clip(along / max(np.linalg.norm(way), 1e-300), -1, 1)))
        return self.at_least(along, 0.025) & self.at_least(np.arctan(0.7), angle)

    def left_of(self, a, b):
        return self.toward(a, b, np.array([-1.0, 0.0]))

    def right_of(self, a, b):
        return self.toward(a, b, np.array([1.0, 0.0]))

    def in_front_of(self, a, b):
        return self.toward(a, b, np.array([0.0, -1.0]))

    def behind(self, a, b):
        return self.toward(a, b, np.array([0.0, 1.0]))

    def above(self, a, b):
        return self.at_least(self.low[a][2] - self.low[b][2], 0.025)

    def on_top_of(self, a, b):
        """The centre over the box, the bottom within 15 mm of its top."""
        middle = (self.low[b] + self.high[b]) / 2
        half = (self.high[b] - self.low[b]) / 2
        inside = [self.at_least(half[i], abs(self.centre[a][i] - middle[i])) for i in (0, 1)]
        return all(inside) & self.at_least(0.015, abs(self.low[a][2] - self.high[b][2]))

    def beside(self, a, b):
        if a == b or not self.at_least(0.035, abs(self.low[a][2] - self.low[b][2])):
            return False
        gap = np.maximum(0, np.maximum(self.low[a] - self.high[b], self.low[b] - self.high[a]))[:2]
        if not self.at_least(0.205, float(np.linalg.norm(gap))):
            return False
        middle = (self.centre[a] + self.centre[b])[:2] / 2
        radius = np.linalg.norm((self.centre[a] - self.centre[b])[:2]) / 2 + 0.025
        free = True
        for c in self.centre:
            if c in (a, b):
                continue
            level = self.at_least(0.035, abs(self.low[c][2] - self.low[a][2]))
            away = self.at_least(float(np.linalg.norm(self.centre[c][:2] - middle)), radius)
            free &= bool(away) or not level
        return free

    def between(self, a, b, c):
        p, q, r = (self.centre[x][:2] for x in (a, b, c))
        way = r - q
        length = float(np.linalg.norm(way))
        if not self.at_least(length, 0.05):
            return False
        along = float(np.linalg.norm(p - q) ** 2 + length**2 - np.linalg.norm(p - r) ** 2) / (2 * length)
        aside = np.sqrt(max(0.0, float(np.linalg.norm(p - q) ** 2 - along**2)))
        return all(
            [self.at_least(along, 0.025), self.at_least(length - 0.025, along), self.at_least(0.45 * length, aside)]
        )

    def groups(self, ids, value, margin):
        """The connected parts of the graph of things whose values are within the margin, in the order of their least
        values."""
        value = {i: float(value(i)) for i in ids}
        left, found = set(ids), []
        while left:
            part, border = set(), [min(left)]
            while border:
                here = border.pop()
                part.add(here)
                left.discard(here)
                for other in list(left):
                    if not self.at_least(abs(value[other] - value[here]), margin):
                        left.discard(other)
                        border.append(other)
            found.append(sorted(part))
        return tuple(tuple(g) for g in sorted(found, key=lambda g: min(value[i] for i in g)))
