"""Parts that the scenes beside this file share: tubes and grids as arrays, materials, and the file that is written.

A scene is one tile of a surface that repeats for ever: the unit square of x and y, z up, the highest point at z = 0.
Everything that shall be baked is in the collection BTF. A body that crosses an edge of the tile stays whole: it reaches
into the neighbour, and the neighbour's copy of it reaches back, so that repeated tiles have no seam.

The modules of Blender are needed: blender -b --factory-startup -P knit.py -- -o knit.blend

SPDX-License-Identifier: MIT
"""
import argparse
import os
import sys

import bpy
import numpy as np

TRIANGLES = (10000, 60000)  # fewer look coarse in a picture of 64 texels a tile, more take longer for nothing seen
DEPTH = (0.05, 0.25)        # of the tile's side


class Part:
    """A mesh in the making.

    vertices, normals: arrays of (n, 3), float64; triangles: (m, 3) indices, counter-clockwise seen from outside;
    slots: (m) indices into materials, a list of Blender's materials. Normals are given and not left to Blender: at a cut
    on the tile's edge it would average the faces of one side only, and the seam would show.
    """

    def __init__(self, name, materials):
        self.name, self.materials = name, materials
        self.vertices, self.normals, self.triangles, self.slots = [], [], [], []
        self.count = 0

    def add(self, vertices, normals, triangles, slots):
        """Adds a piece. slots: one index, or one for each triangle."""
        self.vertices.append(np.asarray(vertices, float))
        self.normals.append(np.asarray(normals, float))
        self.triangles.append(np.asarray(triangles) + self.count)
        self.slots.append(np.broadcast_to(slots, len(triangles)))
        self.count += len(vertices)

    def joined(self):
        return [np.concatenate(each) for each in (self.vertices, self.normals, self.triangles, self.slots)]


def unit(vectors):
    """The vectors of the last axis, scaled to length 1."""
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def lattice(rows, columns, closed):
    """Triangles of rows x columns vertices in row-major order; closed joins the last column to the first."""
    at = np.arange(rows * columns).reshape(rows, columns)
    right = np.roll(at, -1, axis=1)
    a, b = (at, right) if closed else (at[:, :-1], at[:, 1:])
    quads = np.stack([a[:-1], b[:-1], b[1:], a[1:]], axis=-1).reshape(-1, 4)
    return np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


def ground(z, material):
    """The unit square at height z: what lies below everything, so that no ray falls through the surface."""
    part = Part('ground', [material])
    corners = np.array([[0, 0, z], [1, 0, z], [1, 1, z], [0, 1, z]], float)
    part.add(corners, np.tile([0.0, 0.0, 1.0], (4, 1)), np.array([[0, 1, 2], [0, 2, 3]]), 0)
    return part


def material(name, colour, roughness=0.6, metallic=0.0, specular=0.5, sheen=0.0):
    """Blender's Principled material of one colour, linear Rec. 709."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    made.diffuse_color = (*colour, 1)  # the colour that Blender's viewport shows in solid mode
    inputs = made.node_tree.nodes['Principled BSDF'].inputs
    inputs['Base Color'].default_value = (*colour, 1)
    inputs['Roughness'].default_value = roughness
    inputs['Metallic'].default_value = metallic
    for names, value in ((('Specular', 'Specular IOR Level'), specular), (('Sheen', 'Sheen Weight'), sheen)):
        # The second name is Blender 4's.
        inputs[next(n for n in names if n in inputs)].default_value = value
    return made


def arguments(description, seed=None):
    """Reads the options after '--' on Blender's command line: -o FILE, and --seed N where the scene has a seed."""
    parser = argparse.ArgumentParser(prog='blender -b -P ' + os.path.basename(sys.argv[sys.argv.index('-P') + 1]) + ' --',
                                     description=description)
    parser.add_argument('-o', '--output', metavar='FILE', required=True, help='the scene to write, *.blend')
    if seed is not None:
        parser.add_argument('--seed', type=int, default=seed, help=f'another arrangement (default {seed})')
    given = parser.parse_args(sys.argv[sys.argv.index('--') + 1:] if '--' in sys.argv else [])
    if not given.output.endswith('.blend'):
        parser.error(f"--output: '{given.output}' does not end in .blend")
    folder = os.path.dirname(os.path.abspath(given.output))
    if not os.path.isdir(folder):
        parser.error(f"--output: there is no folder '{folder}'")
    return given


def mesh_object(part):
    """Makes a Blender object of a Part."""
    vertices, normals, triangles, slots = part.joined()
    mesh = bpy.data.meshes.new(part.name)
    mesh.from_pydata(vertices.tolist(), [], triangles.tolist())
    for each in part.materials:
        mesh.materials.append(each)
    mesh.polygons.foreach_set('material_index', np.ascontiguousarray(slots, np.int32))
    mesh.polygons.foreach_set('use_smooth', np.ones(len(triangles), bool))
    if hasattr(mesh, 'use_auto_smooth'):
        mesh.use_auto_smooth = True  # before Blender 4.1 given normals count only then
    mesh.normals_split_custom_set_from_vertices(normals.tolist())
    mesh.update()
    return bpy.data.objects.new(part.name, mesh)


def begin():
    """Begins an empty file, without the cube, light and camera of Blender's start-up scene."""
    bpy.ops.wm.read_factory_settings(use_empty=True)


def finish(parts, path):
    """Moves the parts so that the highest point is at z = 0, checks them, and writes the scene. The file is whole or
    absent."""
    top = max(np.concatenate(part.vertices)[:, 2].max() for part in parts)
    bottom = min(np.concatenate(part.vertices)[:, 2].min() for part in parts)
    triangles = sum(len(each) for part in parts for each in part.triangles)
    if not TRIANGLES[0] <= triangles <= TRIANGLES[1]:
        raise ValueError(f'{path}: {triangles} triangles, expected {TRIANGLES[0]} to {TRIANGLES[1]}')
    if not DEPTH[0] <= top - bottom <= DEPTH[1]:
        raise ValueError(f'{path}: {top - bottom:.3f} deep, expected {DEPTH[0]} to {DEPTH[1]} of the tile')
    collection = bpy.data.collections.new('BTF')
    bpy.context.scene.collection.children.link(collection)
    for part in parts:
        for vertices in part.vertices:
            vertices[:, 2] -= top
        collection.objects.link(mesh_object(part))
    # The temporary name ends in .blend too, since Blender would append it.
    beside = f'{os.path.abspath(path)[:-len(".blend")]}.part{os.getpid()}.blend'
    try:
        bpy.ops.wm.save_as_mainfile(filepath=beside, compress=True)
        os.replace(beside, path)
    finally:
        if os.path.exists(beside):
            os.unlink(beside)
    print(f'{path}: {triangles} triangles, {top - bottom:.3f} of the tile deep', flush=True)
