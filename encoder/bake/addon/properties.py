"""The settings of a bake as properties of a scene, which are saved with the file. Names and defaults are those of
bake_settings.Settings, where each is explained.

SPDX-License-Identifier: MIT
"""
import math

import bpy
from bake_settings import Settings

DEFAULTS = Settings()
# Set otherwise: the selected objects, the frame that is shown, and the operator for the preview.
NO_PROPERTIES = {'objects', 'frame', 'preview'}


def _lists(description):
    return bpy.props.StringProperty(description=description + ': ubo, ubo2014, small, tiny, a number of directions, rings '
                                    'such as 0:1,30:6,60:12, or the path of a text file')


class BTFSettings(bpy.types.PropertyGroup):
    """scene.btf_bake"""
    output: bpy.props.StringProperty(name='Images', subtype='DIR_PATH', default='//btf/',
                                     description='Folder of the data set. A bake that was stopped goes on there')
    collection: bpy.props.StringProperty(name='Collection', default=DEFAULTS.collection, description='What is baked')
    selected: bpy.props.BoolProperty(name='Selected objects', description='Bakes the selected objects instead')
    tile: bpy.props.FloatVectorProperty(name='Tile', size=4, default=DEFAULTS.tile, precision=3,
                                        description='x and y of the low corner, width, height: what the texture shows')
    z: bpy.props.FloatProperty(name='Reference height', default=DEFAULTS.z, precision=3,
                               description='z of the plane to which images are rectified; best the top of the surface')
    repeat: bpy.props.BoolProperty(name='Repeat', default=DEFAULTS.repeat,
                                   description='Copies of the tile all around shade it and stand in its way')
    texels: bpy.props.IntVectorProperty(name='Texels', size=2, default=DEFAULTS.texels, min=1, max=8192,
                                        description='Columns and rows of each image')
    directions: bpy.props.StringProperty(name='Directions', default=DEFAULTS.directions,
                                         description='Of views and lights: ubo (81), ubo2014 (151), small (19), tiny (5), a '
                                         'number, rings such as 0:1,30:6,60:12, or the path of a text file')
    views: _lists('Views, where they differ from the directions')
    lights: _lists('Lights, where they differ from the directions')
    pairs: bpy.props.StringProperty(name='Pairs', subtype='FILE_PATH',
                                    description='Instead of all views and lights: a text file of pairs, theta and phi of the '
                                    'view and of the light on each line')
    samples: bpy.props.IntProperty(name='Samples', default=DEFAULTS.samples, min=1, max=65536,
                                   description='Paths for each texel of an image')
    bounces: bpy.props.IntProperty(name='Bounces', default=DEFAULTS.bounces, min=0, max=1024,
                                   description='Reflections after the first')
    sun_angle: bpy.props.FloatProperty(name='Sun', subtype='ANGLE', default=math.radians(DEFAULTS.sun_angle), min=0,
                                       max=math.radians(30), description='Angular diameter of the light')
    seed: bpy.props.IntProperty(name='Seed', default=DEFAULTS.seed, min=0, description='Another seed, other noise')
    threads: bpy.props.IntProperty(name='Threads', default=DEFAULTS.threads, min=0, max=1024, description='0: all cores')
    part: bpy.props.IntVectorProperty(name='Part', size=2, default=DEFAULTS.part, min=1, max=100000,
                                      description='(i, n): of every n images the i-th, so that n machines share the work')
    position: bpy.props.StringProperty(name='Positions', subtype='DIR_PATH',
                                       description='Folder for the place that each texel looks at, an image for each view')
    strict: bpy.props.BoolProperty(name='Strict', default=DEFAULTS.strict,
                                   description='Warnings about the scene end the bake')
    encoder: bpy.props.StringProperty(name='btf-encode', subtype='FILE_PATH', default='btf-encode',
                                      description='The program that makes the material of the images')

    def settings(self, context, **changed):
        """Returns these properties as a Settings; members given in `changed` override them."""
        values = {name: tuple(value) if hasattr(value, '__len__') and not isinstance(value, str) else value
                  for name, value in ((name, getattr(self, name)) for name in self.names())}
        values['sun_angle'] = math.degrees(self.sun_angle)
        values['frame'] = context.scene.frame_current
        if self.selected:
            values['objects'] = tuple(sorted(each.name for each in context.selected_objects))
        for name in ('output', 'position', 'pairs'):
            if values[name]:
                values[name] = bpy.path.abspath(values[name])
        return Settings(**{**values, **changed})

    @staticmethod
    def names():
        """The names of the properties that are members of Settings."""
        return [name for name in Settings.__dataclass_fields__ if name not in NO_PROPERTIES]


def register():
    bpy.utils.register_class(BTFSettings)
    bpy.types.Scene.btf_bake = bpy.props.PointerProperty(type=BTFSettings)


def unregister():
    del bpy.types.Scene.btf_bake
    bpy.utils.unregister_class(BTFSettings)
