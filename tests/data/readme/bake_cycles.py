"""Pictures of a scene of encoder/bake/scenes by Cycles alone, for the documents and for the comparison with a material.

    blender -b SCENE.blend -P bake_cycles.py -- surface OUT.exr [OPTION...]   the repeated tile, seen at a slant
    blender -b SCENE.blend -P bake_cycles.py -- sphere OUT.exr [OPTION...]    the tile's own geometry wrapped round a sphere

The sphere is that of btf-render: radius 1, --repeat R puts 2 R tiles around it and R from pole to pole, a tile's x goes
east, its y north, its z outwards, all three in the same scale at the equator. z = 0 lies on the sphere. Camera and light
are those of btf-render --fov 0 --zoom Z --light THETA,PHI. Values are linear; a white diffuse surface that faces the
light is 1.

SPDX-License-Identifier: MIT
"""
import argparse
import math
import os
import sys

import bpy
import numpy as np
from mathutils import Vector


def options():
    parser = argparse.ArgumentParser(prog='bake_cycles.py')
    parser.add_argument('what', choices=('surface', 'sphere'))
    parser.add_argument('output')
    parser.add_argument('--size', type=int, default=256, help='pixels along a side')
    parser.add_argument('--samples', type=int, default=64)
    parser.add_argument('--light', default='40,120', help='theta,phi in degrees')
    parser.add_argument('--repeat', type=int, default=4)
    parser.add_argument('--zoom', type=float, default=0.9)
    parser.add_argument('--threads', type=int, default=0)
    return parser.parse_args(sys.argv[sys.argv.index('--') + 1:])


def direction(theta, phi):
    theta, phi = math.radians(theta), math.radians(phi)
    return Vector((math.sin(theta) * math.cos(phi), math.sin(theta) * math.sin(phi), math.cos(theta)))


def part_of(thing):
    """An object's vertices and normals (n, 3), polygons as lists of vertices, and their materials' slots."""
    mesh = thing.data
    vertices = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get('co', vertices)
    if hasattr(mesh, 'calc_normals_split'):
        mesh.calc_normals_split()  # before Blender 4.1
    of_loops, at = np.empty(3 * len(mesh.loops), np.float32), np.empty(len(mesh.loops), np.int32)
    mesh.loops.foreach_get('normal', of_loops)
    mesh.loops.foreach_get('vertex_index', at)
    normals = np.zeros((len(mesh.vertices), 3))
    normals[at] = of_loops.reshape(-1, 3)
    slots = np.empty(len(mesh.polygons), np.int32)
    mesh.polygons.foreach_get('material_index', slots)
    polygons = at.reshape(len(mesh.polygons), -1)  # triangles alone, or quadrilaterals alone
    return vertices.reshape(-1, 3).astype(float), normals, polygons, slots, list(mesh.materials)


def finer(steps):
    """The unit square at z = 0 as steps x steps squares: a rectangle has to bend, too."""
    x, y = np.meshgrid(np.arange(steps + 1) / steps, np.arange(steps + 1) / steps)
    vertices = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=-1)
    at = np.arange(x.size).reshape(x.shape)
    polygons = np.stack([at[:-1, :-1], at[:-1, 1:], at[1:, 1:], at[1:, :-1]], axis=-1).reshape(-1, 4)
    return vertices, np.tile([0.0, 0.0, 1.0], (x.size, 1)), polygons


def wrap(vertices, normals, column, row, repeat):
    """Points and normals of a tile at their places round the sphere, and which points lie between the poles."""
    size = math.pi / repeat  # of a tile at the equator
    longitude = ((vertices[:, 0] + column) / repeat - 1) * math.pi
    latitude = ((vertices[:, 1] + row) / repeat - 0.5) * math.pi
    east = np.stack([np.cos(longitude), 0 * longitude, -np.sin(longitude)], axis=-1)
    out = np.stack([np.cos(latitude) * np.sin(longitude), np.sin(latitude), np.cos(latitude) * np.cos(longitude)], axis=-1)
    north = np.cross(out, east)
    radius = 1 + size * vertices[:, 2]
    # Normals go with the inverse of the scales of the three axes.
    narrow = np.maximum(np.cos(latitude), 1e-6)
    turned = ((normals[:, 0] / (narrow * radius))[:, None] * east + (normals[:, 1] / radius)[:, None] * north +
              normals[:, 2:] * out)
    turned /= np.maximum(np.linalg.norm(turned, axis=1, keepdims=True), 1e-12)
    return radius[:, None] * out, turned, np.abs(latitude) < math.pi / 2


def wrapped(thing, repeat):
    """One object of all copies of `thing` on the half of the sphere that is seen."""
    vertices, normals, polygons, slots, materials = part_of(thing)
    if len(polygons) <= 2:  # a rectangle, such as the ground
        low, high = vertices.min(axis=0), vertices.max(axis=0)
        vertices, normals, polygons = finer(16)
        vertices = low + (high - low) * vertices
        slots = np.zeros(len(polygons), np.int32)
    every, count = [], 0
    for column in range(2 * repeat):
        longitude = ((column + 0.5) / repeat - 1) * 180
        if abs(longitude) >= 90 + 90 / repeat:
            continue
        for row in range(repeat):
            points, turned, there = wrap(vertices, normals, column, row, repeat)
            kept = there[polygons].all(axis=1)
            every.append((points, turned, polygons[kept] + count, slots[kept]))
            count += len(points)
    points, turned, polygons, slots = (np.concatenate(each) for each in zip(*every))
    mesh = bpy.data.meshes.new(thing.name)
    corners = polygons.shape[1]
    mesh.vertices.add(len(points))
    mesh.vertices.foreach_set('co', points.astype(np.float32).ravel())
    mesh.loops.add(polygons.size)
    mesh.loops.foreach_set('vertex_index', polygons.astype(np.int32).ravel())
    mesh.polygons.add(len(polygons))
    mesh.polygons.foreach_set('loop_start', np.arange(len(polygons), dtype=np.int32) * corners)
    mesh.polygons.foreach_set('loop_total', np.full(len(polygons), corners, np.int32))
    mesh.polygons.foreach_set('material_index', slots.astype(np.int32))
    mesh.polygons.foreach_set('use_smooth', np.ones(len(polygons), bool))
    for material in materials:
        mesh.materials.append(material)
    mesh.update(calc_edges=True)
    if hasattr(mesh, 'use_auto_smooth'):
        mesh.use_auto_smooth = True
    mesh.normals_split_custom_set_from_vertices(turned.tolist())
    return bpy.data.objects.new(thing.name, mesh)


def sphere(given):
    scene = bpy.context.scene
    things = list(bpy.data.collections['BTF'].all_objects)
    scene.collection.children.unlink(bpy.data.collections['BTF'])
    for thing in things:
        scene.collection.objects.link(wrapped(thing, given.repeat))
    camera = bpy.data.cameras.new('camera')
    camera.type = 'ORTHO'
    camera.ortho_scale = 2 / given.zoom
    thing = bpy.data.objects.new('camera', camera)
    thing.location = (0, 0, 5)  # a camera looks along -z, with y up
    scene.collection.objects.link(thing)
    scene.camera = thing


def surface(given):
    """Five by five tiles, of which the middle ones are seen."""
    scene = bpy.context.scene
    for x in range(-2, 3):
        for y in range(-2, 3):
            if x or y:
                copy = bpy.data.objects.new('copy', None)
                copy.instance_type = 'COLLECTION'
                copy.instance_collection = bpy.data.collections['BTF']
                copy.location = (x, y, 0)
                scene.collection.objects.link(copy)
    camera = bpy.data.cameras.new('camera')
    camera.lens = 85
    thing = bpy.data.objects.new('camera', camera)
    at = direction(48, -75)
    thing.location = Vector((0.5, 0.5, -0.07)) + 3.3 * at
    thing.rotation_euler = at.to_track_quat('Z', 'Y').to_euler()
    scene.collection.objects.link(thing)
    scene.camera = thing


def main():
    given = options()
    scene = bpy.context.scene
    {'sphere': sphere, 'surface': surface}[given.what](given)
    sun = bpy.data.lights.new('sun', 'SUN')
    sun.energy, sun.angle = math.pi, math.radians(0.5)
    thing = bpy.data.objects.new('sun', sun)
    thing.rotation_euler = direction(*map(float, given.light.split(','))).to_track_quat('Z', 'Y').to_euler()
    scene.collection.objects.link(thing)
    scene.world = bpy.data.worlds.new('black')
    scene.world.color = (0, 0, 0)
    scene.render.engine = 'CYCLES'
    scene.cycles.device = 'CPU'
    scene.cycles.samples = given.samples
    scene.cycles.use_adaptive_sampling = False
    scene.cycles.use_denoising = False
    scene.cycles.max_bounces = 4
    scene.cycles.pixel_filter_type = 'BOX'
    if given.threads:
        scene.render.threads_mode, scene.render.threads = 'FIXED', given.threads
    scene.render.resolution_x = scene.render.resolution_y = given.size
    scene.render.resolution_percentage = 100
    scene.render.film_transparent = False
    scene.render.image_settings.file_format = 'OPEN_EXR'
    scene.render.image_settings.color_mode = 'RGB'
    scene.render.image_settings.color_depth = '32'
    scene.render.image_settings.exr_codec = 'ZIP'
    beside = f'{os.path.abspath(given.output)[:-len(".exr")]}.part{os.getpid()}.exr'
    scene.render.filepath = beside
    bpy.ops.render.render(write_still=True)
    os.replace(beside, given.output)


main()
