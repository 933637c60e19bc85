"""Finds where rays end, and what in a scene a BTF would show wrongly. Runs inside Blender.

SPDX-License-Identifier: MIT
"""
import numpy

import bake_exr
import bake_scene
from bake_settings import BAD_FILE, BakeError

MISSED = 1e9          # a depth above this means that the ray met nothing
GLOWS = 1e-5          # radiance without the sun above this counts as emission
ASIDE = 1e-3          # texels by which rays pass beside the centres, where edges of meshes on the same grid lie
SUNK = 0.02           # of a tile's longer side: a surface that lies deeper below the reference plane is warned of
LEAST_PROBE = 64      # pixels along the shorter side of a probe


class Probe:
    """The points that the rays of one view meet: depth and position of each, and the radiance of the scene without the sun."""

    def __init__(self, baking, view, path, factor=1):
        scene, s = baking.scene, baking.settings
        baking.set_view(view, ASIDE)
        baking.shine(False)
        bake_scene.write_passes(scene)
        bake_scene.set_size(scene, s, factor)
        scene.cycles.samples = 1
        try:
            baking.render(path, 0)
        finally:
            baking.shine(True)
            bake_scene.write_image(scene, s.samples)
            bake_scene.set_size(scene, s)
        found = bake_exr.read(path)
        layer = bake_scene.LAYER
        self.missed = found[layer + '.Depth.Z'] > MISSED
        # Relative to the low corner of the tile on the reference plane, in lengths of the scene.
        self.position = numpy.stack([found[f'{layer}.Position.{axis}'] for axis in 'XYZ'], 2)
        self.position -= numpy.array([s.tile[0], s.tile[1], s.z], numpy.float32)
        self.position[self.missed] = numpy.nan
        self.glow = max(float(found[f'{layer}.Combined.{channel}'].max()) for channel in 'RGB')


def _percent(mask):
    return f'{100 * mask.mean():.2g} %'


def _outside(baking):
    """Warnings about geometry that reaches beyond the sides of the tile."""
    x, y, width, height = baking.settings.tile
    slack = 1e-4 * max(width, height)
    edges = {(0, -1): x, (0, 1): x + width, (1, -1): y, (1, 1): y + height}
    names = {(0, -1): '-x', (0, 1): '+x', (1, -1): '-y', (1, 1): '+y'}
    for side, edge in edges.items():
        reached, name = baking.bounds.furthest[side]
        if side[1] * (reached - edge) > slack:
            yield (f"'{name}' reaches {side[1] * (reached - edge):.3g} beyond the tile at {names[side]}, where the copies "
                   'around it lie: right for parts that cross the edge and stand in the scene once, wrong for ground or '
                   'duplicates beyond the edge; --no-repeat makes no copies')


def check(baking, views, lights, path, report):
    """Looks at the scene before it is rendered, sets up the copies, and reports what is not as it should be.

    path: a scratch file, which is written and read back. Raises BakeError where no BTF could be made of the scene."""
    s = baking.settings
    found = []
    factor = -(-LEAST_PROBE // min(s.texels))
    top = Probe(baking, (0.0, 0.0), path, factor)
    if top.missed.all():
        low, high = baking.bounds.low, baking.bounds.high
        raise BakeError(BAD_FILE, f'nothing lies within the tile {s.tile[0]:g},{s.tile[1]:g},{s.tile[2]:g},{s.tile[3]:g}: '
                        f'objects fill x {low[0]:.4g} to {high[0]:.4g}, y {low[1]:.4g} to {high[1]:.4g} (--tile)')
    heights = top.position[~top.missed][:, 2]
    lowest, highest = float(heights.min()), float(heights.max())
    # The heights that rays met, and those of the mesh before displacement by its material: the camera can be as low.
    baking.heights = (min(lowest + s.z, float(baking.bounds.low[2])), max(highest + s.z, float(baking.bounds.high[2])))
    above = float(baking.bounds.high[2]) - s.z
    if max(above, highest) > 1e-4 * max(s.tile[2:]):
        found.append(f"'{baking.bounds.furthest[2, 1][1]}' protrudes by {max(above, highest):.4g} above the reference plane "
                     f'at z = {s.z:g}: what lies in that plane stays where it is from view to view, so it should be the '
                     f'top; --z {s.z + max(above, highest):.4g}')
    elif max(above, highest) < -SUNK * max(s.tile[2:]):
        found.append(f'all lies {-max(above, highest):.4g} or more below the reference plane at z = {s.z:g}, and so moves from '
                     f'view to view; --z {s.z + max(above, highest):.4g} rests on it')
    tiles = ''
    if s.repeat:
        found += _outside(baking)
        # Through an opening of the tile, surfaces of neighbouring tiles that lie deeper may be visible.
        deepest = float(baking.bounds.low[2]) - s.z if top.missed.any() else lowest
        x, y, needed = baking.repeat(min(deepest, lowest), max(highest, 0), views, lights)
        if top.missed.any():
            top = Probe(baking, (0.0, 0.0), path, factor)
        tiles = f', {2 * x + 1} x {2 * y + 1} tiles'
        if needed > bake_scene.MOST_RINGS:
            found.append(f'heights of {lowest:.4g} to {highest:.4g} in a tile of {s.tile[2]:g} x {s.tile[3]:g} would need '
                         f'{needed} rings of copies around it; {bake_scene.MOST_RINGS} are made, and what lies beyond neither '
                         'shades nor occludes')
    report('info', text=f'{baking.bounds.triangles} triangles in {len(baking.objects)} objects{tiles}, heights {lowest:.4g} '
           f'to {highest:.4g}')
    if baking.lamps:
        found.append(f"lights of the scene do not shine: '{baking.lamps[0]}'"
                     + (f' and {len(baking.lamps) - 1} more' if baking.lamps[1:] else ''))
    steepest = max(theta for theta, _ in views)
    probes = [('from above', top)]
    if steepest > 0:
        probes += [(f'from theta {steepest:g}, phi {phi:g}', Probe(baking, (steepest, phi), path, factor))
                   for phi in (0.0, 90.0, 180.0, 270.0)]
    glow = max(probe.glow for _, probe in probes)
    if glow > GLOWS:
        raise BakeError(BAD_FILE, f'the scene emits light: a radiance of {glow:.3g} is seen with the sun out. A BTF holds what '
                        'a surface makes of a light; take emission out of the materials')
    open_views = [(where, probe.missed) for where, probe in probes if probe.missed.any()]
    if open_views:
        where, missed = max(open_views, key=lambda each: each[1].mean())
        row, column = (int(i[0]) for i in numpy.nonzero(missed))
        found.append(f'open below: {_percent(missed)} of the texels seen {where} show no surface and become black, the first '
                     f'at x {s.tile[0] + (column + .5) / missed.shape[1] * s.tile[2]:.3g}, '
                     f'y {s.tile[1] + (1 - (row + .5) / missed.shape[0]) * s.tile[3]:.3g}; put a ground under it')
    for text in found:
        report('warning', text=text)
    if found and s.strict:
        raise BakeError(BAD_FILE, f'{len(found)} warnings, and --strict is given: {found[0]}')
