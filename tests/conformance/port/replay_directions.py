"""The neighbours of a direction (FORMAT.md, section 6), and the directions of relief and gloss (section 9): for
replay.py.

SPDX-License-Identifier: MIT
"""
import math

from replay_arithmetic import add, inner, mul, power, reciprocal


def cross(p, q):
    """The cross product of integer vectors."""
    return p[0] * q[1] - p[1] * q[0]


def minus(p, q):
    """The difference of integer vectors."""
    return (p[0] - q[0], p[1] - q[1])


def dot(p, q):
    """The inner product of integer vectors."""
    return p[0] * q[0] + p[1] * q[1]


class Directions:
    """A list of directions with its triangulation."""

    def __init__(self, part, name):
        whole = [int(x) for x in part.floats("openbtf.%sVertices" % name)]
        self.vertices = list(zip(whole[0::2], whole[1::2]))
        whole = [int(x) for x in part.floats("openbtf.%sTriangles" % name)]
        self.triangles = list(zip(whole[0::3], whole[1::3], whole[2::3]))
        self.hull = [int(x) for x in part.floats("openbtf.%sHull" % name)]
        self.grid = part.integer("openbtf.%sGrid" % name)
        cells = [int(x) for x in part.floats("openbtf.%sCells" % name)]
        self.cells, at = [], 0
        while at < len(cells):
            self.cells.append(cells[at + 1:at + 1 + cells[at]])
            at += 1 + cells[at]

    def accept(self, record, q):
        """Three (index, weight) pairs, or None."""
        if record < len(self.triangles):
            i, j, k = self.triangles[record]
            a, b, c = (self.vertices[n] for n in (i, j, k))
            e0, e1 = cross(minus(b, q), minus(c, q)), cross(minus(c, q), minus(a, q))
            e2, area = cross(minus(a, q), minus(b, q)), cross(minus(b, a), minus(c, a))
            if min(e0, e1, e2) < 0:
                return None
            s = max(0, area.bit_length() - 19)
            w0, w1 = (((e >> s) << 12) // (area >> s) for e in (e0, e1))
            return (i, w0), (j, w1), (k, 4096 - w0 - w1)
        edge = record - len(self.triangles)
        i, j, k = (self.hull[(edge + n) % len(self.hull)] for n in range(3))
        a, b, c = (self.vertices[n] for n in (i, j, k))
        t, n = dot(minus(q, a), minus(b, a)), dot(minus(b, a), minus(b, a))
        if 0 <= t <= n and cross(minus(b, a), minus(q, a)) <= 0:
            s = max(0, n.bit_length() - 19)
            w1 = ((t >> s) << 12) // (n >> s)
            return (i, 4096 - w1), (j, w1), (i, 0)
        if t >= n and dot(minus(q, b), minus(c, b)) <= 0:
            return (j, 4096), (j, 0), (j, 0)
        return None

    def lookup(self, direction, k=None):
        """The three neighbours of a direction, weights of 4096; k in place of the reciprocal of its z and 1."""
        k = reciprocal(add(direction[2], 1.0)) if k is None else k
        q = []
        for c in direction[:2]:
            x = math.floor(add(mul(mul(c, k), 8192.0), 0.5))
            q.append(int(min(max(x, -8192), 8192)) + 8192)
        cell = (min(q[1], 16383) * self.grid >> 14) * self.grid + (min(q[0], 16383) * self.grid >> 14)
        for record in self.cells[cell]:
            answer = self.accept(record, q)
            if answer:
                return answer
        return ((0, 4096), (0, 0), (0, 0))

    def neighbours(self, direction, nearest, k=None):
        """Those neighbours of a direction that weigh, or the nearest one alone."""
        found = self.lookup(direction, k)
        if nearest:
            best = max(found, key=lambda pair: pair[1])
            found = ((best[0], 4096), (0, 0), (0, 0))
        return [pair for pair in found if pair[1] > 0]


def slope(direction):
    """Texels across for a texel of height, times 4096."""
    z = max(direction[2], 0.25)
    k = reciprocal(add(z, z))
    k = add(k, k)
    return [int(min(max(math.floor(add(mul(mul(c, k), 4096.0), 0.5)), -32767), 32767)) for c in direction[:2]]


def shared_light(light, view, sampled, share):
    """The direction looked up in place of a light for a sampled view, and its k: None where it is the light itself."""
    d = [add(a, -v) for a, v in zip(sampled, view)]
    if all(abs(c) < 2.0 ** -24 for c in d):
        return light, None
    h = [add(a, b) for a, b in zip(light, view)]
    hd = inner(h, d)
    k = mul(add(hd, hd), reciprocal(min(max(inner(h, h), 0.5), 4.0)))
    c = [add(a, mul(add(mul(b, k), -e), share * 0.25)) for a, b, e in zip(light, h, d)]
    c[2] = max(c[2], 0.0)
    n = power(inner(c, c), 0.5)
    return c, reciprocal(min(max(add(n, c[2]), 0.5), 4.0))
