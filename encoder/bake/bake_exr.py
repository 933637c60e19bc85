"""Reads the OpenEXR images that Blender's renderer writes as arrays, and writes arrays as OpenEXR and PNG images.

Needs numpy, which Blender brings along. It reads scan lines of float, half or unsigned channels, uncompressed or
compressed by ZIP, because Blender writes no others here. It is no reader for files of other programs.

SPDX-License-Identifier: MIT
"""
import os
import struct
import zlib

import numpy

MAGIC = 20000630
TYPES = {0: '<u4', 1: '<f2', 2: '<f4'}  # pixel types UINT, HALF, FLOAT


def _header(data):
    """Returns ({name: (type, value)}, offset of the first byte after the header) of a single-part file."""
    magic, version = struct.unpack_from('<II', data)
    if magic != MAGIC or version & 0x1a00:  # the flags of tiles (0x200), deep data (0x800) and several parts (0x1000)
        raise ValueError('no OpenEXR file of one part of scan lines')
    attributes, at = {}, 8

    def text():
        nonlocal at
        end = data.index(b'\0', at)
        word, at = data[at:end].decode(), end + 1
        return word

    while data[at]:
        name, kind = text(), text()
        size, = struct.unpack_from('<i', data, at)
        attributes[name] = kind, data[at + 4:at + 4 + size]
        at += 4 + size
    return attributes, at + 1


def _channels(value):
    found, at = [], 0
    while value[at]:
        end = value.index(b'\0', at)
        found.append((value[at:end].decode(), TYPES[struct.unpack_from('<i', value, end + 1)[0]]))
        at = end + 17
    return found


def _unzip(block, size):
    """Undoes OpenEXR's ZIP compression of a block: inflates it, adds up the differences, interleaves its two halves."""
    if len(block) == size:
        return block  # a block that compression would not have made smaller is stored as it is
    coded = numpy.frombuffer(zlib.decompress(block), numpy.uint8).astype(numpy.int64)
    coded[1:] -= 128
    summed = (numpy.cumsum(coded) & 255).astype(numpy.uint8)
    out = numpy.empty_like(summed)
    out[0::2], out[1::2] = numpy.split(summed, [(len(summed) + 1) // 2])
    return out.tobytes()


def read(path):
    """Returns {channel: array [row][column] of float32, row 0 at the top}. Raises OSError, ValueError."""
    with open(path, 'rb') as file:
        data = file.read()
    attributes, at = _header(data)
    left, top, right, bottom = struct.unpack('<4i', attributes['dataWindow'][1])
    width, height = right - left + 1, bottom - top + 1
    channels = _channels(attributes['channels'][1])
    compression = attributes['compression'][1][0]
    if compression not in (0, 2, 3):
        raise ValueError(f'{path}: compression {compression} is neither NONE nor ZIP')
    lines = 16 if compression == 3 else 1
    images = {name: numpy.empty((height, width), numpy.float32) for name, _ in channels}
    line_bytes = width * sum(numpy.dtype(kind).itemsize for _, kind in channels)
    for block in range(-(-height // lines)):
        offset, = struct.unpack_from('<Q', data, at + 8 * block)
        y, size = struct.unpack_from('<ii', data, offset)
        rows = min(lines, bottom - y + 1)
        pixels = data[offset + 8:offset + 8 + size]
        if compression:
            pixels = _unzip(pixels, rows * line_bytes)
        position = 0
        for row in range(y - top, y - top + rows):
            for name, kind in channels:
                images[name][row] = numpy.frombuffer(pixels, kind, width, position)
                position += width * numpy.dtype(kind).itemsize
    return images


def read_rgb(path):
    """Returns [row][column][3] of an image with channels R, G, B."""
    images = read(path)
    return numpy.stack([images[name] for name in 'RGB'], 2)


def _write_whole(path, data):
    """Writes the data to a file beside `path` and renames it, so that a file of this name is always whole."""
    folder, name = os.path.split(path)
    beside = os.path.join(folder, f'.{name}.{os.getpid()}.part')
    try:
        with open(beside, 'wb') as file:
            file.write(data)
        os.replace(beside, path)
    except BaseException:
        if os.path.exists(beside):
            os.remove(beside)
        raise


def rgb_file(rgb, comment=''):
    """The bytes of an OpenEXR file of [row][column][3]: float channels R, G, B, without compression."""
    height, width, _ = rgb.shape

    def attribute(name, kind, value):
        return name.encode() + b'\0' + kind.encode() + b'\0' + struct.pack('<i', len(value)) + value

    window = struct.pack('<4i', 0, 0, width - 1, height - 1)
    channels = b''.join(name + b'\0' + struct.pack('<iiii', 2, 0, 1, 1) for name in (b'B', b'G', b'R')) + b'\0'
    head = struct.pack('<II', MAGIC, 2)
    head += attribute('channels', 'chlist', channels)
    if comment:
        head += attribute('comments', 'string', comment.encode())
    head += attribute('compression', 'compression', b'\0')
    head += attribute('dataWindow', 'box2i', window) + attribute('displayWindow', 'box2i', window)
    head += attribute('lineOrder', 'lineOrder', b'\0')
    head += attribute('pixelAspectRatio', 'float', struct.pack('<f', 1))
    head += attribute('screenWindowCenter', 'v2f', struct.pack('<ff', 0, 0))
    head += attribute('screenWindowWidth', 'float', struct.pack('<f', 1)) + b'\0'
    lines = numpy.ascontiguousarray(rgb[:, :, ::-1].transpose(0, 2, 1), '<f4')  # [row][B, G, R][column]
    size = 12 * width
    first = len(head) + 8 * height
    offsets = b''.join(struct.pack('<Q', first + row * (8 + size)) for row in range(height))
    body = b''.join(struct.pack('<ii', row, size) + lines[row].tobytes() for row in range(height))
    return head + offsets + body


def srgb(linear):
    """8-bit codes of sRGB (IEC 61966-2-1) of linear values, clipped to 0..1."""
    value = numpy.clip(numpy.nan_to_num(linear), 0, 1)
    coded = numpy.where(value <= 0.0031308, 12.92 * value, 1.055 * value ** (1 / 2.4) - 0.055)
    return (255 * coded + 0.5).astype(numpy.uint8)


def write_png(path, rgb):
    """Writes [row][column][3] of linear values as an 8-bit sRGB PNG. Raises OSError."""
    height, width, _ = rgb.shape
    lines = numpy.zeros((height, 1 + 3 * width), numpy.uint8)  # filter 0 before each line
    lines[:, 1:] = srgb(rgb).reshape(height, 3 * width)

    def chunk(kind, data):
        return struct.pack('>I', len(data)) + kind + data + struct.pack('>I', zlib.crc32(kind + data))

    _write_whole(path, b'\x89PNG\r\n\x1a\n' + chunk(b'IHDR', struct.pack('>IIBBBBB', width, height, 8, 2, 0, 0, 0)) +
                 chunk(b'sRGB', b'\0') + chunk(b'IDAT', zlib.compress(lines.tobytes(), 9)) + chunk(b'IEND', b''))
