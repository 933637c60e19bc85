"""Directions drawn to the light, and their density, in plain Python, from decoder/SAMPLING.md: for replay.py.

SPDX-License-Identifier: MIT
"""
from replay_arithmetic import add, mul, of_bits, power, reciprocal

SINE = [of_bits(b) for b in (0x3FC90FDB, 0xBF255DE7, 0x3DA335E3, 0xBB996966, 0x39283C1A)]
COSINE = [of_bits(b) for b in (0x3F800000, 0xBF9DE9E6, 0x3E81E0F8, 0xBCAAE9E4, 0x3A70FA83)]
INVERSE_PI = of_bits(0x3EA2F983)


class Tables:
    """The tables of a material: rows of triangles (four words each), and of densities (floats)."""

    def __init__(self, words, triangles, n_views, n_lights):
        size = 4 * triangles
        self.rows = [[words[v * size + 4 * t:v * size + 4 * t + 4] for t in range(triangles)] for v in range(n_views + 1)]
        at = (n_views + 1) * size
        self.densities = [[of_bits(w) for w in words[at + v * (n_lights + 1):at + (v + 1) * (n_lights + 1)]]
                          for v in range(n_views)]


def unit(number):
    """Of the upper 24 bits."""
    return float(number >> 8) * 2.0 ** -24


def share(part, whole):
    """part / whole, below 1; a whole of 0 stands for 2^32."""
    if whole == 0:
        return unit(part)
    drop = max(0, whole.bit_length() - 24)
    p, w = float(part >> drop), float(whole >> drop)
    down = 2.0 ** (1 - int(w).bit_length())
    return min(mul(mul(p, down), reciprocal(mul(w, down))), 1 - 2.0 ** -24)


def polynomial(coefficients, x):
    """Horner's rule."""
    p = coefficients[4]
    for c in reversed(coefficients[:4]):
        p = add(mul(p, x), c)
    return p


def by_cosine(u1, u2):
    """A point of the disc, lifted."""
    quarters = mul(u2, 4.0)
    quarter = int(quarters)
    s = add(add(quarters, -float(quarter)), -0.5)
    square = mul(s, s)
    sine, cosine = mul(s, polynomial(SINE, square)), polynomial(COSINE, square)
    x, y = ((cosine, sine), (-sine, cosine), (-cosine, -sine), (sine, -cosine))[quarter]
    radius = power(u1, 0.5)
    return [mul(radius, x), mul(radius, y), power(add(1.0, -u1), 0.5)]


def weighted(l, values):
    """The sum of three products, in order."""
    return add(add(mul(l[0], values[0]), mul(l[1], values[1])), mul(l[2], values[2]))


def third_number(u1, u2):
    """Stirred of two."""
    h = (u1 * 747796405 + u2 * 2891336453 + 277803737) & 0xFFFFFFFF
    h = ((h >> 16 ^ h) * 277803737) & 0xFFFFFFFF
    return h >> 15 ^ h


def barycentric(u1, u2, u3, d):
    """Coordinates of a point whose density is linear between those at the corners."""
    if add(u1, u2) > 1.0:
        u1, u2 = add(1.0, -u1), add(1.0, -u2)
    l = [add(add(1.0, -u1), -u2), u1, u2]
    turns = [l, l[1:] + l[:1], l[2:] + l[:2]]
    height = mul(u3, add(add(d[0], d[1]), d[2]))
    first = weighted(turns[0], d)
    second = add(first, weighted(turns[1], d))
    return turns[0] if height < first else turns[1] if height < second else turns[2]


def is_above(direction):
    """Bits of a direction that there is light from, or a view."""
    return all((c & 0x7FFFFFFF) <= 0x40000000 for c in direction) and of_bits(direction[2]) >= 2.0 ** -24


def nearest_view(material, view):
    """The view of the largest weight, the first of equals."""
    return max(material.views.lookup([of_bits(c) for c in view]), key=lambda pair: pair[1])[0]


def pdf_light(material, tables, view, light):
    """The density of a light; arguments are bits."""
    if not is_above(view) or not is_above(light):
        return 0.0
    densities = tables.densities[nearest_view(material, view)]
    light = [of_bits(c) for c in light]
    n = material.lights.lookup(light)
    density = 0.0
    if n[0][0] != n[2][0]:
        weights = [add(float(n[0][1]), 0.5), add(float(n[1][1]), 0.5), add(float(n[2][1]), -1.0)]
        density = max(mul(weighted(weights, [densities[i] for i, _ in n]), 2.0 ** -12), 0.0)
    z = min(light[2], 1.0)
    k = reciprocal(add(z, 1.0))
    density = mul(mul(density, k), k)
    return add(density, mul(mul(densities[-1], z), INVERSE_PI))


def draw_light(material, tables, view, u1, u2):
    """A direction; the view is bits and above the horizon."""
    row = tables.rows[nearest_view(material, view)]
    end = row[-1][0]
    if u1 >= end:
        return by_cosine(share(u1 - end, -end & 0xFFFFFFFF), unit(u2))
    t = next(i for i, triangle in enumerate(row) if u1 < triangle[0])
    begin = row[t - 1][0] if t > 0 else 0
    b = barycentric(share(u1 - begin, row[t][0] - begin), unit(u2), unit(third_number(u1, u2)),
                    [of_bits(w) for w in row[t][1:]])
    corners = tables.rows[-1][t][:3]
    x, y = (mul(add(weighted(b, [float(c >> low & 0xFFFF) for c in corners]), -8192.0), 2.0 ** -13) for low in (0, 16))
    rr = add(mul(x, x), mul(y, y))
    k = reciprocal(add(1.0, rr))
    return [mul(x, add(k, k)), mul(y, add(k, k)), max(mul(add(1.0, -rr), k), 2.0 ** -20)]
