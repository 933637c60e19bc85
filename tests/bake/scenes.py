"""Writes the scenes of the tests of btf-bake: blender --background --factory-startup --python scenes.py -- FOLDER

white      a plane, albedo 1
axes       the relief `axes` of btf-sample (tests/sample/relief.h) as a mesh: a post, a ridge and a wedge, diffuse
waves      a smooth coloured relief, periodic in the tile, from z = -0.2 to 0; in frame 2 half a tile further along x
nowhere    a scene without the collection BTF
empty      one in which the collection has nothing to render
bare       one with a face without a material
glowing    one with an emitting face
faults     one with a hole, a part above the reference plane, a part beyond the tile, and a lamp

SPDX-License-Identifier: MIT
"""
import math
import os
import sys

import bpy

FOLDER = sys.argv[-1]


def material(name, colour, emission=0.0):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    nodes = made.node_tree.nodes
    nodes.clear()
    output = nodes.new('ShaderNodeOutputMaterial')
    shader = nodes.new('ShaderNodeEmission' if emission else 'ShaderNodeBsdfDiffuse')
    shader.inputs['Color'].default_value = (*colour, 1)
    if emission:
        shader.inputs['Strength'].default_value = emission
    made.node_tree.links.new(shader.outputs[0], output.inputs['Surface'])
    return made


def mesh(name, points, faces, materials, of_face=None, smooth=False):
    data = bpy.data.meshes.new(name)
    data.from_pydata(points, [], faces)
    for each in materials:
        data.materials.append(each)
    for i, polygon in enumerate(data.polygons):
        polygon.material_index = of_face[i] if of_face else 0
        polygon.use_smooth = smooth
    made = bpy.data.objects.new(name, data)
    collection = bpy.data.collections.get('BTF')
    (collection or bpy.context.scene.collection).objects.link(made)
    return made


def plane(name, z, materials, low=(0, 0), high=(1, 1)):
    points = [(low[0], low[1], z), (high[0], low[1], z), (high[0], high[1], z), (low[0], high[1], z)]
    return mesh(name, points, [(0, 1, 2, 3)], materials)


def box(name, low, high, slope, materials):
    """A box without a floor. slope: how much lower the top is at the low y. materials: that of the top, that of the
    walls."""
    points = [(x, y, z - (slope if z == high[2] and y == low[1] else 0)) for z in (low[2], high[2])
              for y in (low[1], high[1]) for x in (low[0], high[0])]
    faces = [(4, 5, 7, 6), (0, 1, 5, 4), (1, 3, 7, 5), (3, 2, 6, 7), (2, 0, 4, 6)]
    return mesh(name, points, faces, materials, [0, 1, 1, 1, 1])


def start():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    collection = bpy.data.collections.new('BTF')
    bpy.context.scene.collection.children.link(collection)


def save(name):
    bpy.context.preferences.filepaths.save_version = 0
    bpy.ops.wm.save_as_mainfile(filepath=os.path.join(FOLDER, name + '.blend'), check_existing=False)


def white():
    start()
    plane('white', 0, [material('white', (1, 1, 1))])
    save('white')


def axes():
    start()
    depth = 0.125
    ground = material('ground', (.5, .5, .5))
    plane('ground', -depth, [ground], (0, 0), (60 / 64, 60 / 64))
    plane('red', -depth, [material('red', (.5, .1, .1))], (60 / 64, 0), (1, 1))
    plane('green', -depth, [material('green', (.1, .5, .1))], (0, 60 / 64), (60 / 64, 1))
    # The walls have the colour of the ground, because in btf-sample they belong to the cells around the post.
    box('post', (29 / 64, 29 / 64, -depth), (35 / 64, 35 / 64, 0), 0, [material('bright', (.9, .9, .9)), ground])
    box('ridge', (51 / 64, 10 / 64, -depth), (54 / 64, 32 / 64, -depth / 2), 0, [ground, ground])
    box('wedge', (10 / 64, 42 / 64, -depth), (22 / 64, 54 / 64, -depth / 2), depth / 2, [ground, ground])
    save('axes')


def waves():
    start()
    n = 48

    def height(x, y):
        turn = 2 * math.pi
        return -0.1 + 0.06 * math.sin(turn * x) * math.cos(turn * y) + 0.04 * math.sin(turn * (2 * y + x))

    points = [(i / n, j / n, height(i / n, j / n)) for j in range(n + 1) for i in range(n + 1)]
    corner = [j * (n + 1) + i for j in range(n) for i in range(n)]
    faces = [(c, c + 1, c + n + 2, c + n + 1) for c in corner]
    colours = [(.8, .3, .2), (.2, .6, .3), (.25, .3, .8)]
    made = mesh('waves', points, faces, [material(f'colour {i}', c) for i, c in enumerate(colours)],
         [(3 * (c % (n + 1)) // n + 2 * (c // (n + 1) * 2 // n)) % 3 for c in corner])
    made.keyframe_insert('location', frame=1)
    made.location = 0.5, 0, 0
    made.keyframe_insert('location', frame=2)
    bpy.context.scene.frame_set(1)
    save('waves')


def faulty():
    start()
    bpy.data.collections.remove(bpy.data.collections['BTF'])
    plane('ground', 0, [material('white', (1, 1, 1))])
    save('nowhere')

    start()
    plane('ground', 0, [material('white', (1, 1, 1))]).hide_render = True
    save('empty')

    start()
    plane('ground', 0, [material('white', (1, 1, 1))])
    plane('patch', 0.01, [], (.4, .4), (.6, .6))
    save('bare')

    start()
    plane('ground', 0, [material('white', (1, 1, 1))])
    plane('lamp of lava', 0.01, [material('lava', (1, .3, .1), 2)], (.4, .4), (.6, .6))
    save('glowing')

    start()
    grey = material('grey', (.5, .5, .5))
    plane('ground', -.1, [grey], (0, 0), (1, .75))
    plane('leaf', .05, [grey], (.8, .2), (1.25, .4))
    lamp = bpy.data.objects.new('lamp', bpy.data.lights.new('lamp', 'POINT'))
    bpy.data.collections['BTF'].objects.link(lamp)
    save('faults')


white()
axes()
waves()
faulty()
