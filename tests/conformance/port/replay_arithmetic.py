"""The arithmetic of FORMAT.md, section 8, and its random numbers: for replay.py. A number is a Python float that
holds a binary32 value.

SPDX-License-Identifier: MIT
"""
import math
import struct


def f32(x):
    """The nearest binary32."""
    try:
        return struct.unpack("<f", struct.pack("<f", x))[0]
    except OverflowError:
        return math.inf if x > 0 else -math.inf


def of_bits(bits):
    """The float of these bits."""
    return struct.unpack("<f", struct.pack("<I", bits & 0xFFFFFFFF))[0]


def to_bits(x):
    """The bits of a float."""
    return struct.unpack("<I", struct.pack("<f", x))[0]


def mul(a, b):
    """One rounding: the product of two binary32 is exact in binary64."""
    return f32(a * b)


def add(a, b):
    """One rounding: binary64 has more than twice the digits."""
    return f32(a + b)


LOG = [of_bits(b) for b in (0x3FB8AA39, 0xBF38AAD4, 0x3EF63D91, 0xBEB85F87, 0x3E92CDF0, 0xBE7FEC0F, 0x3E726D64,
                            0xBE157E27)]
EXP = [of_bits(b) for b in (0x3F317218, 0x3E75FDF0, 0x3D63576E, 0x3C1D94D9, 0x3AAFA1B1, 0x392245AA)]


def log2(x):
    """Normal, positive x."""
    i = to_bits(x) - 0x3F3504F3
    f = add(of_bits((i & 0x7FFFFF) + 0x3F3504F3), -1.0)
    p = LOG[7]
    for j in range(6, -1, -1):
        p = add(mul(p, f), LOG[j])
    return add(float(i >> 23), mul(f, p))


def exp2(x):
    """-60 <= x <= 40."""
    i = math.floor(add(x, 0.5))
    f = add(x, -float(i))
    p = EXP[5]
    for j in range(4, -1, -1):
        p = add(mul(p, f), EXP[j])
    return of_bits(to_bits(add(mul(f, p), 1.0)) + (i << 23))


def power(b, n):
    """b^n."""
    if not b >= 2.0 ** -24:
        return 0.0
    t = mul(n, log2(b))
    if t < -60:
        return 0.0
    return exp2(min(t, 40.0))


def reciprocal(x):
    """0.5 <= x <= 4."""
    r = of_bits(0x7EF311C7 - to_bits(x))
    for _ in range(4):
        r = mul(r, add(2.0, -mul(x, r)))
    return r


def inner(p, q):
    """The inner product, summed in order."""
    return add(add(mul(p[0], q[0]), mul(p[1], q[1])), mul(p[2], q[2]))


def random_numbers(counter):
    """Three random numbers of a counter (section 9, Stochastic decode)."""
    x, y, z = ((c * 1664525 + 1013904223) & 0xFFFFFFFF for c in counter)
    for last in (False, True):
        x = (x + y * z) & 0xFFFFFFFF
        y = (y + z * x) & 0xFFFFFFFF
        z = (z + x * y) & 0xFFFFFFFF
        if not last:
            x, y, z = x ^ (x >> 16), y ^ (y >> 16), z ^ (z >> 16)
    return x, y, z


def owner(weights, number):
    """Which of some weights a number below their sum falls on."""
    for i, weight in enumerate(weights):
        if number < weight:
            return i
        number -= weight
    raise ValueError("weights that do not reach a number")


def kept(value):
    """Within 0 and 2^32, 0 below 2^-30."""
    return min(value, 2.0 ** 32) if value >= 2.0 ** -30 else 0.0
