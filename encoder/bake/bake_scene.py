"""The scene that is rendered: the tile and its copies, the sheared camera and the sun. Runs inside Blender.

A bake makes a scene of its own beside those of the file, which are left as they are, and removes it in the end.

**The camera.** Images have to be rectified: texel (c, r) shows what the ray through its centre on the reference plane
meets. An orthographic camera whose matrix has the columns (1, 0, 0), (0, 1, 0) and the direction to the viewer starts
parallel rays on a regular grid of a plane of constant height, and so renders the rectified image itself: nothing is
resampled, and the filter is a box of one texel for every view. Location, rotation and scale cannot express this shear;
matrix_parent_inverse, which is any matrix, can.

SPDX-License-Identifier: MIT
"""
import math

import bpy
import numpy
from mathutils import Matrix, Vector

import bake_directions
from bake_settings import BAD_FILE, IO, UNSUPPORTED, BakeError

OLDEST = 3, 0  # the first version of Blender whose Cycles has the position pass
GEOMETRY = {'MESH', 'CURVE', 'SURFACE', 'META', 'FONT', 'CURVES', 'POINTCLOUD', 'VOLUME', 'EMPTY'}
MOST_RINGS = 8  # of copies: 17 x 17 tiles
LAYER = 'bake'


def chosen_objects(settings):
    """The objects to bake, in the order of their names. Raises BakeError."""
    if settings.objects:
        missing = [name for name in settings.objects if name not in bpy.data.objects]
        if missing:
            raise BakeError(BAD_FILE, f"there is no object '{missing[0]}'; objects: {_some(bpy.data.objects)}")
        found = [bpy.data.objects[name] for name in settings.objects]
        where = 'of --object'
    else:
        collection = bpy.data.collections.get(settings.collection)
        if collection is None:
            raise BakeError(BAD_FILE, f"there is no collection '{settings.collection}'; put what is to be baked into one of "
                            f'this name, or name another by --collection; collections: {_some(bpy.data.collections)}')
        found, todo = set(), [collection]
        while todo:
            each = todo.pop()
            if not each.hide_render:
                found |= set(each.objects)
                todo += each.children
        where = f"in collection '{settings.collection}'"
    lamps = sorted(o.name for o in found if o.type == 'LIGHT' and not o.hide_render)
    kept = sorted((o for o in found if o.type in GEOMETRY and not o.hide_render), key=lambda o: o.name)
    if not any(o.type != 'EMPTY' or o.instance_type != 'NONE' for o in kept):
        raise BakeError(BAD_FILE, f'nothing to bake: no mesh, curve, text, volume or instance {where} that is rendered')
    return kept, lamps


def _some(names):
    names = [each.name for each in names]
    return ', '.join(f"'{name}'" for name in sorted(names)[:8]) + (', ...' if len(names) > 8 else '') or 'none'


def _material_missing(drawn):
    """Whether a face of an evaluated object has no material."""
    slots = [slot.material for slot in drawn.material_slots]
    own = list(getattr(drawn.data, 'materials', None) or [])
    slots += own[len(slots):]
    slots = [slot or (own[i] if i < len(own) else None) for i, slot in enumerate(slots)]
    if not slots:
        return True
    if drawn.type != 'MESH':
        return slots[0] is None
    used = numpy.zeros(len(drawn.data.polygons), numpy.int32)
    drawn.data.polygons.foreach_get('material_index', used)
    return any(slots[min(i, len(slots) - 1)] is None for i in numpy.unique(used))


class Bounds:
    """The box that the tile's own geometry fills, and the number of its triangles, as the viewport evaluates it."""

    def __init__(self, depsgraph):
        self.low, self.high = numpy.full(3, numpy.inf), numpy.full(3, -numpy.inf)
        self.triangles, self.bare = 0, []
        self.furthest = {}  # {(axis, sign): (coordinate, name of the object that reaches it)}
        cache = {}
        for instance in depsgraph.object_instances:
            drawn = instance.object
            if drawn.type not in GEOMETRY or drawn.type == 'EMPTY' or not instance.show_self:
                continue
            key = drawn.name_full, drawn.type
            if key not in cache:
                cache[key] = self._points(drawn)
            points, triangles = cache[key]
            if len(points) == 0:
                continue
            matrix = numpy.array(instance.matrix_world)
            placed = points @ matrix[:3, :3].T + matrix[:3, 3]
            self.triangles += triangles
            for axis in range(3):
                for sign, edge in ((-1, placed[:, axis].min()), (1, placed[:, axis].max())):
                    if sign * edge > sign * self.furthest.get((axis, sign), (-sign * math.inf, ''))[0]:
                        self.furthest[axis, sign] = float(edge), drawn.name
            self.low = numpy.minimum(self.low, placed.min(0))
            self.high = numpy.maximum(self.high, placed.max(0))

    def _points(self, drawn):
        """Returns (vertices of an object in its own space, number of its triangles)."""
        if drawn.type in ('MESH', 'CURVE', 'SURFACE', 'META', 'FONT'):
            mesh = drawn.to_mesh()
            if mesh is not None and len(mesh.polygons) > 0:
                if _material_missing(drawn):
                    self.bare.append(drawn.name)
                points = numpy.empty(3 * len(mesh.vertices), numpy.float32)
                mesh.vertices.foreach_get('co', points)
                triangles = len(mesh.loops) - 2 * len(mesh.polygons)
                drawn.to_mesh_clear()
                return points.reshape(-1, 3), triangles
            drawn.to_mesh_clear()
            return numpy.empty((0, 3), numpy.float32), 0
        return numpy.array(drawn.bound_box, numpy.float32), 0

    def empty(self):
        return not numpy.all(self.low <= self.high)


class BakeScene:
    """The scene of one bake. Use as a context manager: at the end it removes what it made."""

    def __init__(self, settings):
        self.settings, self._made, self._shown = settings, [], None
        self.objects, self.lamps = chosen_objects(settings)
        scenes = [bpy.context.scene, *bpy.data.scenes]
        source = next((s for s in scenes if any(o.name in s.objects for o in self.objects)), bpy.context.scene)
        self.scene = self._new(bpy.data.scenes, 'btf-bake')
        try:
            self._build(source)
        except BaseException:
            self.close()
            raise

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def _new(self, kind, *arguments):
        made = kind.new(*arguments)
        self._made.append((kind, made))
        return made

    def close(self):
        for kind, made in reversed(self._made):
            kind.remove(made)
        self._made = []
        if self._shown and self._shown[0].frame_current != self._shown[1]:
            self._shown[0].frame_set(self._shown[1])

    def _build(self, source):
        scene, s = self.scene, self.settings
        scene.view_layers[0].name = LAYER
        self.tile = self._new(bpy.data.collections, 'btf-bake tile')
        for each in self.objects:
            self.tile.objects.link(each)
        scene.collection.children.link(self.tile)
        configure(scene, s, source)
        scene.world = None  # black

        scene.view_layers[0].update()
        # Animated objects follow the frame of the scene that the file shows. Its frame is restored at the end.
        self._shown = source, source.frame_current
        frame = s.frame if s.frame >= 0 else source.frame_current
        if frame != source.frame_current:
            source.frame_set(frame)
        scene.frame_set(frame)
        self.bounds = Bounds(scene.view_layers[0].depsgraph)
        if self.bounds.empty():
            raise BakeError(BAD_FILE, f'nothing to bake: {_some(self.objects)}: no faces')
        if self.bounds.bare:
            raise BakeError(BAD_FILE, f"object '{self.bounds.bare[0]}' has faces without a material"
                            + (f', and so have {len(self.bounds.bare) - 1} more' if self.bounds.bare[1:] else ''))

        # The heights between which geometry may lie: those of the mesh, widened by its own extent on both sides, as a
        # material may displace it.
        low, high = float(self.bounds.low[2]), float(self.bounds.high[2])
        self.heights = low - (high - low), high + (high - low) + max(s.tile[2:])

        anchor = self._new(bpy.data.objects, 'btf-bake anchor', None)
        camera = self._new(bpy.data.cameras, 'btf-bake camera')
        camera.type, camera.sensor_fit, camera.ortho_scale = 'ORTHO', 'HORIZONTAL', s.tile[2]
        self.camera = self._new(bpy.data.objects, 'btf-bake camera', camera)
        self.camera.parent = anchor
        sun = self._new(bpy.data.lights, 'btf-bake sun', 'SUN')
        sun.angle = math.radians(s.sun_angle)
        self.light = sun
        self.sun = self._new(bpy.data.objects, 'btf-bake sun', sun)
        self.sun.rotation_mode = 'QUATERNION'
        for each in (anchor, self.camera, self.sun):
            scene.collection.objects.link(each)
        scene.camera = self.camera
        self.shine(True)
        self.set_view((0.0, 0.0))
        self.set_light((0.0, 0.0))

    def repeat(self, lowest, highest, views, lights):
        """Copies the tile around itself as far as rays and shadows between the heights `lowest` and `highest` reach.
        Returns (rings along x, rings along y, rings that would be needed)."""
        def reach(directions):
            return max(math.tan(math.radians(theta)) for theta, _ in directions)

        far = max(highest - lowest, 0) * (reach(views) + reach(lights))
        needed = [max(1, math.ceil(far / side)) for side in self.settings.tile[2:]]
        rings = [min(n, MOST_RINGS) for n in needed]
        for i in range(-rings[0], rings[0] + 1):
            for j in range(-rings[1], rings[1] + 1):
                if (i, j) != (0, 0):
                    copy = self._new(bpy.data.objects, 'btf-bake copy', None)
                    copy.instance_type, copy.instance_collection = 'COLLECTION', self.tile
                    copy.location = i * self.settings.tile[2], j * self.settings.tile[3], 0
                    self.scene.collection.objects.link(copy)
        return rings[0], rings[1], max(needed)

    def shine(self, on):
        """Turns the sun on or off. Its irradiance at normal incidence is its strength in Blender. With a strength of
        pi, the rendered radiance is the value that decoder/FORMAT.md defines (radiance x pi / irradiance), so that a
        white plane gives cos(theta_l)."""
        self.light.energy = math.pi if on else 0.0

    def set_light(self, light):
        self.sun.rotation_quaternion = Vector(bake_directions.vector(light)).to_track_quat('Z', 'Y')

    def set_view(self, view, aside=0.0):
        """Points the camera, so that its parallel rays pass through the reference plane at the centres of texels,
        shifted by `aside` texels."""
        x, y, z = bake_directions.vector(view)
        tile, low, high = self.settings.tile, *self.heights
        # Above all geometry, but not far above, so that float coordinates stay accurate.
        top = max(high, self.settings.z) + 0.05 * (high - low) + 0.01 * max(tile[2:])
        along = (top - self.settings.z) / z
        foot = (tile[0] + tile[2] * (0.5 + aside / self.settings.texels[0]),
                tile[1] + tile[3] * (0.5 + 0.7 * aside / self.settings.texels[1]), self.settings.z)
        self.camera.matrix_parent_inverse = Matrix(((1, 0, x, foot[0] + along * x), (0, 1, y, foot[1] + along * y),
                                                    (0, 0, z, foot[2] + along * z), (0, 0, 0, 1)))
        self.camera.data.clip_start = 1e-6 * max(tile[2:])
        self.camera.data.clip_end = 2 * (top - low + max(tile[2:])) / z

    def render(self, path, seed):
        """Renders an image with the camera and the sun as they are set, and writes it to `path`. Raises BakeError."""
        self.scene.cycles.seed = seed
        self.scene.render.filepath = path
        try:
            bpy.ops.render.render(write_still=True, scene=self.scene.name)
        except RuntimeError as error:
            raise BakeError(IO, str(error).strip().removeprefix('Error: ')) from None


def configure(scene, s, source):
    """Makes all settings of the renderer on which pixel values depend: none is left to the file or to Blender's
    defaults, which differ between versions."""
    r, c = scene.render, scene.cycles
    try:
        r.engine = 'CYCLES'
    except TypeError:
        raise BakeError(UNSUPPORTED, f'this Blender {bpy.app.version_string} has no Cycles') from None
    c.device, c.feature_set = 'CPU', 'SUPPORTED'
    c.shading_system = False  # Open Shading Language
    r.threads_mode, r.threads = ('FIXED', s.threads) if s.threads else ('AUTO', r.threads)
    r.use_persistent_data = True  # scene and hierarchy stay in memory from image to image
    # Pixels: texels of any shape, each the mean over its own area (a box filter).
    set_size(scene, s)
    r.use_border = False
    # Values: linear as rendered, nothing clamped, blurred or denoised.
    r.use_compositing = r.use_sequencer = r.use_motion_blur = r.film_transparent = False
    scene.view_settings.view_transform = 'Raw' if scene.display_settings.display_device == 'None' else 'Standard'
    scene.view_settings.look, scene.view_settings.exposure, scene.view_settings.gamma = 'None', 0, 1
    scene.view_settings.use_curve_mapping = False
    c.film_exposure, c.sample_clamp_direct, c.sample_clamp_indirect, c.blur_glossy = 1, 0, 0, 0
    c.light_sampling_threshold = 0
    c.use_denoising = c.use_adaptive_sampling = c.use_fast_gi = c.use_animated_seed = False
    c.caustics_reflective = c.caustics_refractive = True
    c.time_limit = 0
    c.max_bounces = c.diffuse_bounces = c.glossy_bounces = c.transmission_bounces = c.volume_bounces = s.bounces
    c.min_light_bounces = c.min_transparent_bounces = 0
    c.transparent_max_bounces = max(source.cycles.transparent_max_bounces, 8)
    # The output file: OpenEXR of one part, float.
    r.use_file_extension, r.use_overwrite, r.use_placeholder = False, True, False
    for name in dir(r):
        if name.startswith('use_stamp'):
            setattr(r, name, False)
    write_image(scene, s.samples)


def write_image(scene, samples):
    """Makes later renders write images of channels R, G, B with `samples` paths a pixel."""
    image = scene.render.image_settings
    if hasattr(image, 'media_type'):  # Blender 5
        image.media_type = 'IMAGE'
    image.file_format, image.color_mode, image.color_depth, image.exr_codec = 'OPEN_EXR', 'RGB', '32', 'NONE'
    layer = scene.view_layers[0]
    layer.use_pass_position = layer.use_pass_z = False
    scene.cycles.pixel_filter_type = 'BOX'
    # Cycles sends its very first path through the centre of the pixel. That point would weigh more than the others of the
    # box, and lies on edges of meshes laid on the same grid, where a ray may slip through. So samples begin at a power of
    # two, where a sequence is as even as at its start: noise is 4 to 5 % less than from sample 0 (8 and 16 samples of a
    # relief), while from sample 1 it would be 2 % more.
    scene.cycles.samples, scene.cycles.sample_offset = samples, 1 << (samples - 1).bit_length()


def write_passes(scene):
    """Makes later renders write the positions and depths that rays through the centres of pixels meet."""
    image = scene.render.image_settings
    if hasattr(image, 'media_type'):
        image.media_type = 'MULTI_LAYER_IMAGE'
    image.file_format, image.color_depth, image.exr_codec = 'OPEN_EXR_MULTILAYER', '32', 'NONE'
    layer = scene.view_layers[0]
    layer.use_pass_position = layer.use_pass_z = True
    scene.cycles.pixel_filter_type, scene.cycles.filter_width, scene.cycles.sample_offset = 'GAUSSIAN', 0.01, 0


def set_size(scene, s, factor=1):
    """factor: pixels along each side of a texel."""
    r = scene.render
    r.resolution_x, r.resolution_y, r.resolution_percentage = factor * s.texels[0], factor * s.texels[1], 100
    shape = s.tile[3] * s.texels[0] / (s.tile[2] * s.texels[1])  # height of a texel by its width
    r.pixel_aspect_x, r.pixel_aspect_y = max(1, 1 / shape), max(1, shape)
