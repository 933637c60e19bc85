"""OpenEXR files in plain Python: scan lines, one or more parts, no compression or ZIP: for replay.py and
tests/web/vectors.py.

SPDX-License-Identifier: MIT
"""
import struct
import zlib


class Part:
    """One part: attributes, size, and channels as rows of numbers (floats as bits, halves as numbers)."""

    def __init__(self, attributes):
        self.attributes = attributes
        x0, y0, x1, y1 = struct.unpack("<4i", attributes["dataWindow"])
        self.x0, self.y0, self.width, self.height = x0, y0, x1 - x0 + 1, y1 - y0 + 1
        self.channels = {}
        self.order = []
        data, at = attributes["channels"], 0
        while data[at]:
            end = data.index(0, at)
            name = data[at:end].decode()
            kind = struct.unpack_from("<i", data, end + 1)[0]
            at = end + 17
            self.order.append((name, kind))
            self.channels[name] = [None] * self.height
        self.compression = attributes["compression"][0]
        self.lines = {0: 1, 2: 1, 3: 16}[self.compression]

    def name(self):
        """The part's name; "" in a file of one part."""
        return self.attributes.get("name", b"").decode()

    def text(self, name):
        """A string attribute."""
        return self.attributes[name].decode()

    def integer(self, name, default=None):
        """An int attribute."""
        return struct.unpack("<i", self.attributes[name])[0] if name in self.attributes else default

    def floats(self, name):
        """A float or floatvector attribute."""
        data = self.attributes.get(name, b"")
        return list(struct.unpack("<%df" % (len(data) // 4), data))

    def decode(self, y, data):
        """Takes the chunk that begins at row y."""
        rows = min(self.lines, self.height - (y - self.y0))
        line = sum((2 if kind == 1 else 4) * self.width for _, kind in self.order)
        if self.compression != 0 and len(data) < rows * line:
            raw = bytearray(zlib.decompress(data))
            for i in range(1, len(raw)):
                raw[i] = (raw[i - 1] + raw[i] - 128) & 255
            half = (len(raw) + 1) // 2
            data = bytearray(len(raw))
            data[0::2] = raw[:half]
            data[1::2] = raw[half:]
        at = 0
        for row in range(y - self.y0, y - self.y0 + rows):
            for name, kind in self.order:
                code, size = {0: ("I", 4), 1: ("e", 2), 2: ("I", 4)}[kind]
                self.channels[name][row] = struct.unpack_from("<%d%s" % (self.width, code), data, at)
                at += size * self.width


def read_exr(path):
    """The parts of a file, by name."""
    with open(path, "rb") as file:
        data = file.read()
    magic, version = struct.unpack_from("<ii", data)
    assert magic == 20000630, path
    multi, at, parts = bool(version & 0x1000), 8, []
    while True:
        attributes = {}
        while data[at]:
            end = data.index(0, at)
            name = data[at:end].decode()
            at = data.index(0, end + 1) + 1
            size = struct.unpack_from("<i", data, at)[0]
            attributes[name] = data[at + 4:at + 4 + size]
            at += 4 + size
        at += 1
        if attributes:
            parts.append(Part(attributes))
        if not multi or not attributes:
            break
    chunks = [-(-part.height // part.lines) for part in parts]
    at += 8 * sum(chunks)
    for _ in range(sum(chunks)):
        number = 0
        if multi:
            number = struct.unpack_from("<i", data, at)[0]
            at += 4
        y, size = struct.unpack_from("<ii", data, at)
        parts[number].decode(y, data[at + 8:at + 8 + size])
        at += 8 + size
    return {part.name(): part for part in parts}
