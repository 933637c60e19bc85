"""Checks the scenes of encoder/bake/scenes as Blender reads them.

    blender -b --factory-startup --python-exit-code 1 -P check_scene.py -- FILE...

Prints a line for each check in the form that tests/summary.py counts, and exits 1 where one fails. Each check is also
made on a copy that is broken on purpose, where it has to fail.

SPDX-License-Identifier: MIT
"""
import os
import sys

import bpy
import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree

FAILED = []


def report(name, complaint):
    """Prints the result of a check. complaint: the fault, empty where there is none."""
    print(f'[ RUN      ] {name}')
    if complaint:
        print(complaint)
        FAILED.append(name)
    print(f'[{"  FAILED  " if complaint else "       OK "}] {name}', flush=True)


def meshes():
    """(name, vertices (n, 3) in the world, triangles (m, 3)) of each mesh of the collection BTF."""
    found = []
    for each in bpy.data.collections['BTF'].all_objects:
        mesh = each.data
        mesh.calc_loop_triangles()
        vertices = np.empty(3 * len(mesh.vertices), np.float32)
        mesh.vertices.foreach_get('co', vertices)
        triangles = np.empty(3 * len(mesh.loop_triangles), np.int32)
        mesh.loop_triangles.foreach_get('vertices', triangles)
        matrix = np.array(each.matrix_world)
        found.append((each.name, vertices.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3], triangles.reshape(-1, 3)))
    return found


def wrong_size(parts):
    count = sum(len(triangles) for _, _, triangles in parts)
    if not 10000 <= count <= 60000:
        return f'{count} triangles'
    vertices = np.concatenate([vertices for _, vertices, _ in parts])
    if abs(vertices[:, 2].max()) > 1e-6:
        return f'the highest point is at z = {vertices[:, 2].max()}'
    if not -0.25 <= vertices[:, 2].min() <= -0.05:
        return f'the lowest point is at z = {vertices[:, 2].min()}'
    if vertices[:, :2].min() < -0.5 or vertices[:, :2].max() > 1.5:
        return 'reaches further than half a tile into a neighbour'
    return ''


def open_edges(triangles):
    """Vertices on open edges: those that belong to one triangle alone."""
    edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    edges, times = np.unique(edges, axis=0, return_counts=True)
    return np.unique(edges[times == 1])


def welded(vertices, triangles):
    """The triangles with corners at the same place merged into one vertex."""
    _, first, which = np.unique(np.round(vertices, 6), axis=0, return_index=True, return_inverse=True)
    return vertices[first], which.reshape(-1)[triangles]


def wrong_ends(parts):
    """Complaints about bodies that are cut open where the copy in the next tile does not go on: an open end at x needs
    one at x + 1 or x - 1."""
    for name, vertices, triangles in parts:
        vertices, triangles = welded(vertices, triangles)
        ends = vertices[open_edges(triangles)]
        if len(ends) == 0:
            continue
        tree = np.concatenate([ends + [dx, dy, 0] for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1))])
        for end in ends:
            nearest = np.abs(tree - end).sum(axis=1).min()
            if nearest > 1e-5:
                return f'{name} ends at {end}, and nothing goes on there in the next tile'
    return ''


def heights(parts, side):
    """(side, side) heights at the centres of cells of the tile, found by rays from above; its eight neighbours are
    there too."""
    vertices, triangles, count = [], [], 0
    for dx in (-1, 0, 1):
        for dy in (-1, 0, 1):
            for _, at, corners in parts:
                vertices.append(at + [dx, dy, 0])
                triangles.append(corners + count)
                count += len(at)
    tree = BVHTree.FromPolygons(np.concatenate(vertices).tolist(), np.concatenate(triangles).tolist(), all_triangles=True)
    found = np.full((side, side), np.nan)
    for i in range(side):
        for j in range(side):
            hit = tree.ray_cast(Vector(((i + 0.5) / side, (j + 0.5) / side, 1)), Vector((0, 0, -1)))[0]
            if hit:
                found[i, j] = hit.z
    return found


def wrong_seam(parts):
    """Complaints about holes, and about a seam: at the edges of the tile the surface must be as high and as rough as
    elsewhere."""
    seen = heights(parts, 96)
    if np.isnan(seen).any():
        return f'{np.isnan(seen).sum()} of {seen.size} rays from above meet nothing'
    deviation = seen.std()
    for axis in (0, 1):
        lines = seen.mean(axis=1 - axis)
        # Means of strips of 8 lines, about as wide as a faulty seam; the seam lies in the middle of the first.
        strips = np.roll(lines, 4).reshape(12, 8).mean(axis=1)
        if abs(strips[0] - strips[1:].mean()) > max(3.5 * strips[1:].std(), 0.15 * deviation):
            return f'mean height {strips[0]:.4f} at the edge across {"xy"[axis]}, elsewhere {strips[1:].mean():.4f}'
        steps = np.abs(np.diff(seen, axis=axis, append=seen[:1] if axis == 0 else seen[:, :1])).mean(axis=1 - axis)
        if steps[-1] > 1.3 * steps[:-1].max():
            return f'steps of {steps[-1]:.4f} across the edge in {"xy"[axis]}, elsewhere at most {steps[:-1].max():.4f}'
    return ''


def loose(vertices, triangles, size):
    """Yields (vertices, triangles) of the bodies of a mesh that holds bodies of `size` vertices one after the other."""
    assert len(vertices) % size == 0
    for first in range(0, len(vertices), size):
        mine = (triangles[:, 0] >= first) & (triangles[:, 0] < first + size)
        yield vertices[first:first + size], triangles[mine] - first


def wrong_contact(parts, most):
    """Complaints about stones, or copies in neighbouring tiles, that run into one another by more than `most`."""
    stones = next((v, t) for name, v, t in parts if name.startswith('stones'))
    bodies = [(vertices, BVHTree.FromPolygons(vertices.tolist(), triangles.tolist(), all_triangles=True))
              for vertices, triangles in loose(*stones, 162)]
    boxes = [(vertices.min(axis=0), vertices.max(axis=0)) for vertices, _ in bodies]
    for i, (vertices, _) in enumerate(bodies):
        for j, (_, tree) in enumerate(bodies):
            middle = (boxes[i][0] + boxes[i][1] - boxes[j][0] - boxes[j][1]) / 2
            shift = -np.round(middle) * [1, 1, 0]  # to the copy that is nearest
            if i == j or (boxes[i][0] + shift > boxes[j][1]).any() or (boxes[i][1] + shift < boxes[j][0]).any():
                continue
            moved = vertices + shift
            for vertex in moved[((moved > boxes[j][0]) & (moved < boxes[j][1])).all(axis=1)]:
                place, normal, _, distance = tree.find_nearest(Vector(vertex))
                if distance > most and (Vector(vertex) - place).dot(normal) < 0:
                    return f'stone {i} is {distance:.4f} deep in stone {j}'
    return ''


def with_part(parts, change):
    """A copy of the parts in which `change` was applied to the largest mesh, the first of that size."""
    largest = max(range(len(parts)), key=lambda k: len(parts[k][2]))
    return [(name, change(at.copy()), t) if k == largest else (name, at, t) for k, (name, at, t) in enumerate(parts)]


def shrunk(vertices):
    vertices[:, :2] = 0.5 + 0.93 * (vertices[:, :2] - 0.5)
    return vertices


def raised(vertices):
    return vertices + [0, 0, 0.01]


def jammed(vertices):
    """The vertices with one stone moved to where the next one lies."""
    vertices[:162] += vertices[162:324].mean(axis=0) - vertices[:162].mean(axis=0)
    return vertices


def notices(check, parts):
    return '' if check(parts) else 'a scene that is broken on purpose is taken'


def main():
    for path in sys.argv[sys.argv.index('--') + 1:]:
        name = os.path.basename(path)[:-len('.blend')]
        bpy.ops.wm.open_mainfile(filepath=path)
        parts = meshes()
        report(f'{name}-size', wrong_size(parts))
        report(f'{name}-size-notices', notices(wrong_size, with_part(parts, raised)))
        report(f'{name}-ends', wrong_ends(parts))
        report(f'{name}-seam', wrong_seam(parts))
        report(f'{name}-seam-notices', notices(wrong_seam, with_part(parts, shrunk)))
        if name == 'knit':
            report('knit-ends-notices', notices(wrong_ends, with_part(parts, shrunk)))
        if name == 'gravel':
            report('gravel-contact', wrong_contact(parts, 0.006))
            report('gravel-contact-notices', notices(lambda p: wrong_contact(p, 0.006), with_part(parts, jammed)))
        materials = [slot.material for each in bpy.data.collections['BTF'].all_objects for slot in each.material_slots]
        report(f'{name}-materials', '' if materials and all(materials) else 'a mesh without material')
        others = [each.name for each in bpy.data.objects if each.type != 'MESH']
        report(f'{name}-alone', f'holds {others} too' if others else '')
    sys.exit(1 if FAILED else 0)


main()
