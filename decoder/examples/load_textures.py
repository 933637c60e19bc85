#!/usr/bin/env python3
"""Example 5: the textures of a folder that btf-shader wrote, as numpy arrays, whichever kind of file they are in.

    load_textures.py FOLDER     prints each level of each texture: name, format, shape, and a digest of its texels

Each reader takes what it needs of its format and no more: 2D textures, arrays of them, levels of detail, nothing
compressed. To show the material, make textures of the arrays in your API, bind them as manifest.json says, and call
btf_evaluate of the shader in the same folder.

SPDX-License-Identifier: MIT
"""
import hashlib
import json
import struct
import sys

import numpy

# Channels and the numpy type of each, by the names of formats in the manifest, by VkFormat and by DXGI_FORMAT.
FORMATS = {
    'R8UI': (1, 'u1'), 'RG8UI': (2, 'u1'), 'RGBA8UI': (4, 'u1'), 'RGBA8I': (4, 'i1'), 'RGBA16UI': (4, '<u2'),
    'RGBA16F': (4, '<f2'), 'RGBA32F': (4, '<f4'), 'RGBA32UI': (4, '<u4')}
VULKAN = {13: 'R8UI', 20: 'RG8UI', 41: 'RGBA8UI', 42: 'RGBA8I', 95: 'RGBA16UI', 97: 'RGBA16F', 107: 'RGBA32UI',
          109: 'RGBA32F'}
DXGI = {62: 'R8UI', 50: 'RG8UI', 30: 'RGBA8UI', 32: 'RGBA8I', 12: 'RGBA16UI', 10: 'RGBA16F', 3: 'RGBA32UI',
        2: 'RGBA32F'}


def pixels(data, offset, format, layers, height, width):
    """Texels [layer][row][column][channel], row 0 the top of the image."""
    channels, dtype = FORMATS[format]
    count = layers * height * width * channels
    return numpy.frombuffer(data, dtype, count, offset).reshape(layers, height, width, channels)


def load_ktx2(data):
    """Levels of a KTX 2.0 file, the finest first: an index in the header says where each lies, all layers together."""
    assert data[:12] == b'\xabKTX 20\xbb\r\n\x1a\n', 'no KTX 2.0 file'
    format, _, width, height, depth, layers, faces, levels, compression = struct.unpack_from('<9I', data, 12)
    assert (depth, faces, compression) == (0, 1, 0), 'not an uncompressed 2D texture'
    result = []
    for i in range(levels):
        offset, = struct.unpack_from('<Q', data, 80 + 24 * i)
        result.append(pixels(data, offset, VULKAN[format], max(layers, 1), max(height >> i, 1), max(width >> i, 1)))
    return result


def load_dds(data):
    """Levels of a DDS file with the header DX10: layers follow one another, each with all its levels."""
    assert data[:4] == b'DDS ' and data[84:88] == b'DX10', 'no DDS file with the header DX10'
    height, width = struct.unpack_from('<2I', data, 12)
    levels, = struct.unpack_from('<I', data, 28)
    format, dimension, _, layers = struct.unpack_from('<4I', data, 128)
    assert dimension == 3, 'not a 2D texture'
    offset, by_level = 148, [[] for _ in range(levels)]
    for _ in range(layers):
        for i in range(levels):
            layer = pixels(data, offset, DXGI[format], 1, max(height >> i, 1), max(width >> i, 1))
            by_level[i].append(layer)
            offset += layer.nbytes
    return [numpy.concatenate(level) for level in by_level]


def load_raw(data, texture):
    """Levels of a raw file, which only the manifest describes: `texture` is an entry of its `textures`."""
    return [pixels(data, level['offset'], texture['format'], texture['layers'], level['height'], level['width'])
            for level in texture['levels']]


def load(folder):
    """(manifest, {name of a texture: its levels})"""
    with open(folder + '/manifest.json') as file:
        manifest = json.load(file)
    textures = {}
    for texture in manifest['textures']:
        with open(f"{folder}/{texture['file']}", 'rb') as file:
            data = file.read()
        kind = manifest['texture_files']
        textures[texture['name']] = (load_ktx2(data) if kind == 'ktx2' else
                                     load_dds(data) if kind == 'dds' else load_raw(data, texture))
    return manifest, textures


if __name__ == '__main__':
    if len(sys.argv) != 2:
        sys.exit('usage: load_textures.py FOLDER')
    manifest, textures = load(sys.argv[1])
    formats = {t['name']: t['format'] for t in manifest['textures']}
    for name, levels in textures.items():
        for i, level in enumerate(levels):
            shape = 'x'.join(str(n) for n in level.shape)
            print(name, i, formats[name], shape, hashlib.sha256(level.tobytes()).hexdigest()[:16])
