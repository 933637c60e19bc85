"""The settings of a bake and its errors: plain Python without bpy, shared by the driver and by Blender.

SPDX-License-Identifier: MIT
"""
import dataclasses
import json
import math
import os

import bake_directions

# Exit codes of the tools (decoder/include/openbtf/result.h).
USAGE, IO, BAD_FILE, INTERNAL, UNSUPPORTED, INTERRUPTED = 1, 2, 3, 4, 5, 130


class BakeError(Exception):
    """A message for the user, and the exit code that the driver ends with."""

    def __init__(self, code, message):
        super().__init__(message)
        self.code = code


@dataclasses.dataclass
class Settings:
    """All options of a bake. Lengths are in units of the scene."""
    output: str = ''          # folder of the data set, made if need be; empty: no data set is written
    collection: str = 'BTF'   # what is baked: the objects of this collection and of those in it,
    objects: tuple = ()       # or the objects of these names instead
    tile: tuple = (0.0, 0.0, 1.0, 1.0)  # x, y of the low corner, width, height
    z: float = 0.0            # height of the reference plane: images are rectified to it
    repeat: bool = True       # the tile is repeated around itself, so that neighbours shade and occlude
    texels: tuple = (64, 64)  # columns, rows
    directions: str = 'ubo'   # views and lights: a list as bake_directions.parse takes it
    views: str = ''           # views, where they differ
    lights: str = ''          # lights, where they differ
    pairs: str = ''           # a text file of pairs of view and light, to be rendered instead of a grid
    samples: int = 16         # paths a texel and image
    bounces: int = 4          # reflections that Cycles follows after the light's first; 0: direct light alone
    sun_angle: float = 0.5    # angular diameter of the light, degrees
    seed: int = 0             # of the random numbers: another seed gives other noise
    frame: int = -1           # of an animated scene; -1: the frame that the file was saved at
    threads: int = 0          # 0: all cores
    part: tuple = (1, 1)      # (i, n): only the i-th of every n images, so that n processes or machines share the work
    position: str = ''        # folder for the points that texels show, an EXR file a view; empty: none are written
    preview: str = ''         # PNG file of a few pairs instead of a data set
    strict: bool = False      # warnings about the scene end the bake

    def check(self):
        """Raises BakeError with a message that names option and value."""
        def need(right, text):
            if not right:
                raise BakeError(USAGE, text)

        numbers = [*self.tile, self.z, self.sun_angle]
        need(all(math.isfinite(number) for number in numbers), f'numbers must be finite: {numbers}')
        need(self.tile[2] > 0 and self.tile[3] > 0,
             f'--tile: a tile of {self.tile[2]:g} x {self.tile[3]:g} has no area')
        need(all(1 <= side <= 8192 for side in self.texels), f'--texels: {self.texels} are not within 1..8192')
        # The ratio of a texel's sides becomes Blender's pixel aspect, which has this limit.
        shape = self.tile[2] * self.texels[1] / (self.tile[3] * self.texels[0])
        need(1 / 200 <= shape <= 200, f'--tile, --texels: a texel is {shape:g} times as wide as high, not within 1/200..200')
        need(1 <= self.samples <= 65536, f'--samples: {self.samples} is not within 1..65536')
        need(0 <= self.bounces <= 1024, f'--bounces: {self.bounces} is not within 0..1024')
        need(0 <= self.sun_angle <= 30, f'--sun-angle: {self.sun_angle:g} is not within 0..30 degrees')
        need(0 <= self.seed < 2**31, f'--seed: {self.seed} is not within 0..2147483647')
        need(-1 <= self.frame <= 1048574, f'--frame: {self.frame} is not within 0..1048574')
        need(0 <= self.threads <= 1024, f'--threads: {self.threads} is not within 1..1024')
        need(1 <= self.part[0] <= self.part[1] <= 100000, f'--part: {self.part[0]}/{self.part[1]} is not 1/N..N/N')
        need(self.output or self.preview or self.position, 'no output: -o DIR, --position DIR or --preview FILE.png')
        if self.output and self.position:
            need(os.path.realpath(self.output) != os.path.realpath(self.position),
                 f'--position: {self.position} is the folder of the images: positions need one of their own')
        self.lists()

    def lists(self):
        """Returns (views, lights) of a grid, each a list of (theta, phi). Raises BakeError."""
        try:
            views = bake_directions.parse(self.views or self.directions)
            lights = bake_directions.parse(self.lights or self.directions)
        except ValueError as error:
            raise BakeError(USAGE, str(error)) from None
        return views, lights

    def images(self):
        """Returns [(name, view, light)] of all images of the data set, in the order in which they are rendered: view by
        view. Raises BakeError."""
        if self.pairs:
            try:
                found = bake_directions.pairs(self.pairs)
            except ValueError as error:
                raise BakeError(USAGE, str(error)) from None
            return [(bake_directions.pair_name(view, light), view, light) for view, light in found]
        views, lights = self.lists()
        return [(bake_directions.image_name(view, light, len(views) * l + v), view, light)
                for v, view in enumerate(views) for l, light in enumerate(lights)]

    def own_images(self):
        """The images of self.images() that belong to self.part."""
        return self.images()[self.part[0] - 1::self.part[1]]

    def record(self):
        """The settings on which the values of the images depend, for the file that says how a data set was made."""
        kept = ('collection', 'objects', 'tile', 'z', 'repeat', 'texels', 'samples', 'bounces', 'sun_angle', 'seed', 'frame')
        record = {name: getattr(self, name) for name in kept}
        if self.objects:
            record['collection'] = ''
        record['images'] = [name for name, _, _ in self.images()]
        return json.loads(json.dumps(record))  # tuples become lists, as they will be read back


def from_json(text):
    """Returns Settings from the text of a JSON object. Raises BakeError at a name that is no member of Settings."""
    values = json.loads(text)
    known = {field.name for field in dataclasses.fields(Settings)}
    if not known.issuperset(values):
        raise BakeError(INTERNAL, f'unknown settings: {", ".join(sorted(set(values) - known))}')
    return Settings(**{name: tuple(value) if isinstance(value, list) else value for name, value in values.items()})
