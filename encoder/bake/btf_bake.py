"""Bakes a scene of Blender into a data set that btf-encode reads: every view under every light, by Cycles on the CPU.

btf-bake, the driver, starts Blender with this file and hands it the settings in JSON:

    blender --background SCENE.blend --python btf_bake.py -- SETTINGS.json SCENE.blend DESCRIPTOR

Within Blender, as an add-on does, put this folder on sys.path and call

    import btf_bake
    btf_bake.run(btf_bake.Settings(output='/tmp/cloth', texels=(32, 32), directions='small'))

for the file that is open. README.md beside this file explains what is baked, and how.

SPDX-License-Identifier: MIT
"""
import hashlib
import json
import os
import shutil
import socket
import sys
import tempfile
import time
import traceback
import zlib

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import bake_settings  # noqa: E402
from bake_directions import view_name  # noqa: E402
from bake_settings import BAD_FILE, INTERNAL, IO, UNSUPPORTED, BakeError, Settings  # noqa: E402

settings = Settings  # callers may use either name

RECORD = 'bake.json'  # in the folder of a data set or of positions: how it was made
PREVIEW_VIEWS = ((0.0, 0.0), (45.0, 60.0), (75.0, 300.0))
PREVIEW_LIGHTS = ((0.0, 0.0), (45.0, 180.0), (60.0, 90.0), (75.0, 0.0))


class Progress:
    """Reports what is done of a stage, and how long the rest takes at the pace of this run."""

    def __init__(self, report, stage, total, done=0):
        self.report, self.stage, self.total, self.done = report, stage, total, done
        self.before, self.start = done, time.monotonic()
        self.tell()

    def step(self):
        self.done += 1
        self.tell()

    def tell(self):
        made = self.done - self.before
        left = (time.monotonic() - self.start) / made * (self.total - self.done) if made else -1
        self.report('progress', stage=self.stage, done=self.done, total=self.total, left=left)


class Output:
    """A folder whose files are written beside and renamed: a file of its final name is whole."""

    def __init__(self, folder):
        self.folder = folder
        prefix = f'.bake-{socket.gethostname()}-'
        try:
            os.makedirs(folder, exist_ok=True)
            for name in os.listdir(folder):  # removes what runs left that were killed on this machine
                if name.startswith(prefix) and not _runs(name[len(prefix):].split('-')[0]):
                    os.remove(os.path.join(folder, name))
            self.beside = os.path.join(folder, f'{prefix}{os.getpid()}-{os.urandom(4).hex()}')
            with open(self.beside, 'wb'):
                pass
            os.remove(self.beside)
        except OSError as error:
            raise _unwritable(error, folder) from None

    def has(self, name):
        return os.path.isfile(os.path.join(self.folder, name))

    def write(self, name, data):
        """Writes the bytes of a file below the folder."""
        path = os.path.join(self.folder, name)
        try:
            with open(self.beside, 'wb') as file:
                file.write(data)
            os.makedirs(os.path.dirname(path), exist_ok=True)
            os.replace(self.beside, path)
        except OSError as error:
            raise _unwritable(error, path) from None

    def close(self):
        if os.path.exists(self.beside):
            os.remove(self.beside)


def _runs(pid):
    """Whether a process of this machine runs. Where that cannot be told it returns True, so that nothing is deleted."""
    if os.name == 'nt':  # on Windows os.kill ends the process, whatever the signal
        return True
    try:
        os.kill(int(pid), 0)
    except ProcessLookupError:
        return False
    except (PermissionError, ValueError):
        pass
    return True


def _unwritable(error, path):
    return BakeError(IO, f'{error.filename or path}: {error.strerror or error}')


class DoneList:
    """The list of the images that are there, a line each: seconds and name. One list for each part, so that processes that
    share a folder do not write into one file. The images themselves decide what is left to do."""

    def __init__(self, settings, output, there):
        i, n = settings.part
        self.path = os.path.join(output.folder, 'bake-done.txt' if n == 1 else f'bake-done-{i}of{n}.txt')
        seconds = {}
        try:
            if os.path.exists(self.path):
                with open(self.path, encoding='utf-8') as file:
                    seconds = {line.rstrip('\n').split('\t', 1)[1]: line.split('\t', 1)[0]
                               for line in file if line.endswith('\n') and '\t' in line}
            beside = os.path.join(output.folder, '.' + os.path.basename(self.path))
            with open(beside, 'w', encoding='utf-8') as file:
                for name in there:
                    file.write(f'{seconds.get(name, "?")}\t{name}\n')
            os.replace(beside, self.path)
            self.file = open(self.path, 'a', encoding='utf-8')  # opened after the renaming: Windows renames no open file
        except OSError as error:
            raise _unwritable(error, self.path) from None

    def add(self, name, seconds):
        try:
            self.file.write(f'{seconds:.3f}\t{name}\n')
            self.file.flush()
        except OSError as error:
            raise _unwritable(error, self.path) from None

    def close(self):
        self.file.close()


def _file_hash(path):
    digest = hashlib.sha256()
    with open(path, 'rb') as file:
        for block in iter(lambda: file.read(1 << 20), b''):
            digest.update(block)
    return digest.hexdigest()


def _record(settings):
    import bpy
    record = settings.record()
    record['blender'] = bpy.app.version_string
    record['scene'] = os.path.basename(bpy.data.filepath)
    # A scene that was changed since it was saved, as the add-on may meet one, has no hash.
    record['scene_sha256'] = '' if bpy.data.is_dirty or not bpy.data.filepath else _file_hash(bpy.data.filepath)
    record['linked_sha256'] = _linked_hash(bpy.utils.blend_paths(absolute=True))
    return record


def _linked_hash(paths):
    """One hash over the contents of all images, libraries and caches that a scene names; empty where it names none.
    Paths are not hashed, since they differ between machines."""
    found = sorted(_file_hash(path) for path in set(paths) if os.path.isfile(path))
    return hashlib.sha256(' '.join(found).encode()).hexdigest() if found else ''


def _position_record(record):
    """The parts of a record on which the points that texels show depend. `holds` tells a folder of positions from one
    of images."""
    kept = ('collection', 'objects', 'tile', 'z', 'repeat', 'texels', 'frame', 'blender', 'scene', 'scene_sha256',
            'linked_sha256')
    return {'holds': 'positions', **{name: record[name] for name in kept}}


def compare_record(record, output, report):
    """Compares the record of a bake with the one in the folder. Returns whether the folder has one. Raises BakeError
    where the folder holds another bake."""
    path = os.path.join(output.folder, RECORD)
    try:
        strangers = sorted(name for name in os.listdir(output.folder) if not name.startswith('.'))
        if not os.path.exists(path):
            if strangers:
                raise BakeError(IO, f"{output.folder}: holds '{strangers[0]}' and no {RECORD}: not a folder of a bake")
            return False
        with open(path, encoding='utf-8') as file:
            before = json.load(file)
    except OSError as error:
        raise _unwritable(error, path) from None
    except ValueError as error:
        raise BakeError(IO, f'{path}: {error}') from None
    if not isinstance(before, dict):
        raise BakeError(IO, f'{path}: not a record of a bake')
    before.setdefault('linked_sha256', '')  # records of older versions lack it
    differ = [name for name in record if before.get(name) != record[name]]
    if not (record['scene_sha256'] and before.get('scene_sha256')):
        report('warning', text=f'{path}: unsaved changes of the scene have no hash: nothing tells whether the files that are '
               'there are of the same scene')
        differ = [name for name in differ if name != 'scene_sha256']
    for name in [name for name in differ if name not in ('blender', 'scene')]:
        was, now = ('other ones', 'these') if name == 'images' else (before.get(name), record[name])
        raise BakeError(IO, f'{path}: begun with other settings: {name} was {was}, now {now}; take another folder, the settings '
                        'of before, or delete the folder')
    for name in differ:
        report('warning', text=f'{path}: {name} was {before.get(name)}, now {record[name]}')
    return True


def write_record(record, output):
    """Writes the record of a folder. Processes that bake other parts may do so at the same time, with the same
    bytes."""
    output.write(RECORD, (json.dumps(record, indent=1) + '\n').encode())


def image_seed(seed, view, light):
    """The seed of an image, so that no two have the same noise. It depends on the pair of directions and not on the
    list that the pair stands in."""
    return zlib.crc32(f'{seed} {view} {light}'.encode()) & 0x7fffffff


def render_images(settings, baking, output, rendered, report):
    """Renders the missing images of this part, view by view. rendered: path of the file that Blender writes. That file
    holds the time of the run, so its pixels are written anew to one whose bytes are the same in every run. Returns the
    number of images rendered."""
    import bake_exr
    own = settings.own_images()
    todo = [each for each in own if not output.has(each[0])]
    done = DoneList(settings, output, [name for name, _, _ in own if output.has(name)])
    try:
        if len(todo) < len(own):
            report('info', text=f'{output.folder}: {len(own) - len(todo)} of {len(own)} images are there')
        progress, at = Progress(report, 'render', len(own), len(own) - len(todo)), None
        for name, view, light in todo:
            start = time.monotonic()
            if view != at:
                baking.set_view(view)
                at = view
            baking.set_light(light)
            baking.render(rendered, image_seed(settings.seed, view, light))
            output.write(name, bake_exr.rgb_file(bake_exr.read_rgb(rendered)))
            done.add(name, time.monotonic() - start)
            progress.step()
    finally:
        done.close()
    return len(todo)


def render_positions(settings, baking, output, views, rendered, report):
    """Writes the point that each texel shows, an EXR file a view. rendered: path of the file that Blender writes."""
    import bake_checks
    import bake_exr
    comment = ('R, G, B: x, y, z of the point that the ray through the centre of a texel meets, from the low corner of the tile '
               'and the reference plane, in lengths of the scene; not a number where it meets nothing')
    own = views[settings.part[0] - 1::settings.part[1]]
    progress = Progress(report, 'positions', len(own))
    for view in own:
        name = view_name(view) + '.exr'
        if not output.has(name):
            probe = bake_checks.Probe(baking, view, rendered)
            output.write(name, bake_exr.rgb_file(probe.position, comment))
        progress.step()


def render_preview(settings, baking, rendered, report):
    """Writes a few pairs side by side: a row a light, a column a view. rendered: path of the file that Blender writes."""
    import bake_exr
    import numpy
    progress = Progress(report, 'preview', len(PREVIEW_VIEWS) * len(PREVIEW_LIGHTS))
    columns = []
    for view in PREVIEW_VIEWS:
        baking.set_view(view)
        column = []
        for light in PREVIEW_LIGHTS:
            baking.set_light(light)
            baking.render(rendered, image_seed(settings.seed, view, light))
            column.append(numpy.pad(bake_exr.read_rgb(rendered), ((1, 1), (1, 1), (0, 0))))
            progress.step()
        columns.append(numpy.concatenate(column, 0))
    try:
        bake_exr.write_png(settings.preview, numpy.concatenate(columns, 1))
    except OSError as error:
        raise _unwritable(error, settings.preview) from None


def run(settings, report=None):
    """Bakes the file that is open in Blender; the open file is left as it is.

    settings: a Settings; what is asked for of output, position and preview is written.
    report: called as report(kind, **values) from this thread: kind 'info' or 'warning' with text=; 'progress' with
    stage=, done=, total= and left=, the seconds until the end of the stage, negative where they are not known yet. What it
    raises ends the bake between two images, and passes through; a later run with the same settings goes on there.
    Returns {'images': of this part, 'rendered': by this run, 'missing': of the whole data set, 'seconds', 'triangles'}.
    Raises BakeError, whose text is for the user and whose code is an exit code of the tools."""
    import bpy
    try:
        import numpy  # noqa: F401
    except ImportError:
        raise BakeError(UNSUPPORTED, f'the Python {sys.version.split()[0]} of Blender {bpy.app.version_string} has no numpy: '
                        "install Debian's package python3-numpy") from None
    import bake_checks
    import bake_scene
    start = time.monotonic()
    report = report or (lambda kind, **values: None)
    settings.check()
    if bpy.app.version < bake_scene.OLDEST:
        raise BakeError(UNSUPPORTED, f'Blender {bpy.app.version_string} lacks the position pass: '
                        f'{bake_scene.OLDEST[0]}.{bake_scene.OLDEST[1]} is the oldest that can be used')
    images = settings.images()
    if settings.preview:
        views, lights = PREVIEW_VIEWS, PREVIEW_LIGHTS
    else:
        views, lights = (sorted({image[i] for image in images}) for i in (1, 2))
        if not any(theta <= 5 for theta, _ in views) and not settings.pairs:
            report('warning', text='no view lies within 5 degrees of the normal: btf-encode will not take the data set')
    output = position = None
    scratch = tempfile.mkdtemp(prefix='btf-bake-')
    path = os.path.join(scratch, 'rendered.exr')
    try:
        if settings.output or settings.position:
            record = _record(settings)
        if settings.output:
            output = Output(settings.output)
            begun = compare_record(record, output, report)
        if settings.position:
            position = Output(settings.position)
            places = _position_record(record)
            placed = compare_record(places, position, report)
        with bake_scene.BakeScene(settings) as baking:
            bake_checks.check(baking, views, lights, path, report)
            triangles, rendered = baking.bounds.triangles, 0
            if output and not begun:
                write_record(record, output)
            if position and not placed:
                write_record(places, position)
            if settings.preview:
                render_preview(settings, baking, path, report)
            if position:
                render_positions(settings, baking, position, views, path, report)
            if output:
                rendered = render_images(settings, baking, output, path, report)
    finally:
        for each in (output, position):
            if each:
                each.close()
        shutil.rmtree(scratch, ignore_errors=True)
    return {'images': len(settings.own_images()), 'rendered': rendered, 'triangles': triangles,
            'missing': sum(not output.has(name) for name, _, _ in images) if output else 0,
            'seconds': time.monotonic() - start}


def main():
    """Runs as the driver's child: writes reports as lines of JSON to a file descriptor, the last of kind 'end' or
    'error'."""
    path, scene, descriptor = sys.argv[sys.argv.index('--') + 1:]
    pipe = os.fdopen(int(descriptor), 'w', encoding='utf-8')

    def report(kind, **values):
        try:
            pipe.write(json.dumps({'kind': kind, **values}) + '\n')
            pipe.flush()
        except BrokenPipeError:  # the driver was killed before it could remove its folder
            folder = os.path.dirname(path)
            if os.path.basename(folder).startswith('btf-bake-'):  # only a folder that the driver made
                shutil.rmtree(folder, ignore_errors=True)
            os._exit(bake_settings.INTERRUPTED)

    try:
        with open(path, encoding='utf-8') as file:
            asked = bake_settings.from_json(file.read())
        import bpy
        if not (bpy.data.filepath and os.path.samefile(bpy.data.filepath, scene)):
            raise BakeError(BAD_FILE, f'{scene}: Blender {bpy.app.version_string} cannot read it')
        report('end', **run(asked, report))
    except BakeError as error:
        report('error', text=str(error), code=error.code)
    except MemoryError:
        report('error', text='out of memory', code=INTERNAL)
    except Exception:
        report('error', text='internal error: ' + traceback.format_exc(), code=INTERNAL)
    pipe.close()


if __name__ == '__main__':
    main()
