"""The operators behind the buttons of the panel and File > Export.

SPDX-License-Identifier: MIT
"""
import os
import subprocess
import tempfile

import bpy
import bpy.utils.previews
import btf_bake
from bake_settings import BakeError
from bpy_extras.io_utils import ExportHelper

from . import job

_job = None       # the Job that runs now
_pictures = None  # the collection of icons that holds the preview's, for the panel


def running():
    return _job is not None


def said():
    return f'{_job.said} (Esc ends it, and a later bake goes on)' if _job else ''


def picture():
    """The icon of the last preview, or 0."""
    return _pictures['preview'].icon_id if _pictures and 'preview' in _pictures else 0


def foreseen(context):
    """A line for the panel: how many images a bake renders, or why it cannot."""
    try:
        settings = context.scene.btf_bake.settings(context, output='/')
        settings.check()
        if settings.pairs:
            count = len(settings.images())
        else:
            views, lights = settings.lists()  # called at each redraw; settings.images() would make all names
            count = len(views) * len(lights)
        if settings.part[1] > 1:
            count = len(range(settings.part[0] - 1, count, settings.part[1]))
        return f'{count} images of {settings.texels[0]} x {settings.texels[1]} texels'
    except BakeError as error:
        return str(error)


def _show(path):
    """Loads the preview into the panel, and as the image 'BTF preview' for an image editor."""
    _pictures.clear()
    _pictures.load('preview', path, 'IMAGE')
    old = bpy.data.images.get('BTF preview')
    if old:
        bpy.data.images.remove(old)
    image = bpy.data.images.load(path)
    image.name = 'BTF preview'
    image.pack()  # because the file is temporary


class _Bakes:
    """An operator that bakes: beside the window where there is one, else until it is done."""

    def asked(self, context):
        """Returns (Settings, the command that encodes the images or None). Raises BakeError."""
        raise NotImplementedError

    def finished(self, context):
        """Called after a bake that succeeded."""

    @classmethod
    def poll(cls, context):
        return _job is None

    def execute(self, context):
        try:
            settings, encode = self.asked(context)
            if bpy.app.background or os.name == 'nt':  # Windows hands no pipe to a process that it starts
                btf_bake.run(settings, self._print)
                if encode:
                    subprocess.run(encode, check=True)
                self.finished(context)
                return {'FINISHED'}
            settings.check()
            return self._begin(context, settings, encode)
        except BakeError as error:
            self.report({'ERROR'}, str(error))
        except (OSError, subprocess.CalledProcessError) as error:
            self.report({'ERROR'}, f'{error}')
        return {'CANCELLED'}

    def _print(self, kind, **values):
        if kind == 'warning':
            self.report({'WARNING'}, values['text'])

    def _begin(self, context, settings, encode):
        global _job
        _job = job.Job(settings, encode)
        context.window_manager.progress_begin(0, 100)
        self._timer = context.window_manager.event_timer_add(0.25, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {'RUNNING_MODAL'}

    def modal(self, context, event):
        if event.type == 'ESC':
            self._end(context)
            self.report({'INFO'}, 'Stopped: a later bake goes on with the images that are there')
            return {'CANCELLED'}
        if event.type != 'TIMER':
            return {'PASS_THROUGH'}
        if _job.poll():
            context.window_manager.progress_update(100 * _job.progress)
            for window in context.window_manager.windows:
                for area in window.screen.areas:
                    if area.type == 'PROPERTIES':
                        area.tag_redraw()
        if not _job.done:
            return {'RUNNING_MODAL'}
        error = _job.error
        self._end(context)
        if error:
            self.report({'ERROR'}, error)
            return {'CANCELLED'}
        self.finished(context)
        return {'FINISHED'}

    def cancel(self, context):
        """Called by Blender when it is closed or another file is opened."""
        self._end(context)

    def _end(self, context):
        global _job
        if _job:
            context.window_manager.event_timer_remove(self._timer)
            context.window_manager.progress_end()
            _job.close()
            _job = None


class BTF_OT_preview(_Bakes, bpy.types.Operator):
    """Renders a few views and lights as one picture, to see what a bake will show"""
    bl_idname = 'btf.preview'
    bl_label = 'Preview'

    def asked(self, context):
        self._folder = tempfile.TemporaryDirectory(prefix='btf-preview-')
        self._path = os.path.join(self._folder.name, 'preview.png')
        return context.scene.btf_bake.settings(context, output='', position='', preview=self._path), None

    def finished(self, context):
        _show(self._path)
        self._folder.cleanup()


class BTF_OT_bake(_Bakes, bpy.types.Operator):
    """Renders every view under every light into the folder of the images. Stopped, it goes on from there the next time"""
    bl_idname = 'btf.bake'
    bl_label = 'Bake'

    def asked(self, context):
        settings = context.scene.btf_bake.settings(context)
        _need_file(settings.output)
        return settings, None


class BTF_OT_export(_Bakes, bpy.types.Operator, ExportHelper):
    """Bakes into the folder of the images, and encodes these as a material that the shaders of OpenBTF read"""
    bl_idname = 'btf.export'
    bl_label = 'Export BTF'

    filename_ext = '.btf.exr'
    check_extension = None  # Blender cannot check '.btf.exr', since it has a dot within
    filter_glob: bpy.props.StringProperty(default='*.btf.exr', options={'HIDDEN'})

    def invoke(self, context, event):
        if not self.filepath:
            name = os.path.splitext(os.path.basename(bpy.data.filepath))[0] or 'untitled'
            self.filepath = bpy.path.abspath(f'//{name}.btf.exr') if bpy.data.filepath else f'{name}.btf.exr'
        context.window_manager.fileselect_add(self)
        return {'RUNNING_MODAL'}

    def asked(self, context):
        own = context.scene.btf_bake
        settings = own.settings(context)
        _need_file(settings.output)
        if settings.pairs:
            raise BakeError(1, f'{settings.pairs}: a material needs all views and lights, not pairs')
        path = self.filepath if self.filepath.endswith('.btf.exr') else self.filepath + '.btf.exr'
        return settings, [bpy.path.abspath(own.encoder), settings.output, '-o', path, '-q']


def _need_file(folder):
    """Refuses to bake a scene that was not saved: by the hash of its file a later bake knows that it goes on with the
    same scene, and a path that begins with // is relative to the file's folder."""
    if not bpy.app.background and (bpy.data.is_dirty or not bpy.data.filepath):
        raise BakeError(1, 'save the file first: the images belong to it, and a bake that was stopped goes on with the same file '
                        'alone')
    if not os.path.isabs(folder):
        raise BakeError(1, f"images '{folder}': save the file first, or choose a folder by its whole path")


CLASSES = (BTF_OT_preview, BTF_OT_bake, BTF_OT_export)


def register():
    global _pictures
    _pictures = bpy.utils.previews.new()
    for each in CLASSES:
        bpy.utils.register_class(each)


def unregister():
    global _job, _pictures
    if _job:
        _job.close()
        _job = None
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)
    bpy.utils.previews.remove(_pictures)
    _pictures = None
