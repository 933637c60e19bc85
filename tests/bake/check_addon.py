"""Installs the add-on from its zip as a user does, and uses it: test_addon.sh starts it, in a folder of its own.

    BLENDER_USER_SCRIPTS=DIR blender -b SCENE.blend --python-exit-code 1 -P check_addon.py -- ADDON.zip BTF-ENCODE

Prints a line for each check in the form that tests/summary.py counts, and exits 1 where one fails.

SPDX-License-Identifier: MIT
"""
import glob
import os
import sys
import time
import types

import addon_utils
import bpy
import numpy

FAILED = []
MODULE = 'openbtf_bake'


def report(name, right, complaint=''):
    print(f'[ RUN      ] {name}')
    if not right:
        print(complaint)
        FAILED.append(name)
    print(f'[{"       OK " if right else "  FAILED  "}] {name}', flush=True)


def there():
    """Lists what the add-on has registered with Blender: a scene's settings, operators, panels, a menu entry."""
    menu = [each for each in bpy.types.TOPBAR_MT_file_export._dyn_ui_initialize() if each.__module__.startswith(MODULE)]
    classes = [name for name in ('MATERIAL_PT_btf_bake', 'MATERIAL_PT_btf_bake_more', 'BTF_OT_bake', 'BTF_OT_export',
                                 'BTF_OT_preview')
               if getattr(bpy.types, name, None) is not None]
    return hasattr(bpy.types.Scene, 'btf_bake'), len(classes), len(menu)


def refused(operator, **options):
    """Returns the message with which an operator refuses, or an empty text where it runs."""
    try:
        operator(**options)
    except RuntimeError as error:
        return str(error)
    return ''


def images(folder):
    return sorted(os.path.relpath(path, folder) for path in glob.glob(f'{folder}/**/*tl*.exr', recursive=True))


def values_of(folder):
    """All images of the folder, as one array."""
    import bake_exr
    return numpy.array([bake_exr.read_rgb(os.path.join(folder, name)) for name in images(folder)])


def check_settings():
    """Each setting of a bake can be set in Blender, and has the default of bake_settings.Settings."""
    from bake_settings import Settings
    from openbtf_bake import properties
    own, default = bpy.context.scene.btf_bake, Settings()
    fields = set(Settings.__dataclass_fields__)
    shown = {each.identifier for each in own.bl_rna.properties}
    lacking = fields - shown - properties.NO_PROPERTIES
    report('addon-has-every-setting', not lacking, f'not in the panel: {lacking}')
    report('addon-has-no-other', properties.NO_PROPERTIES < fields, f'{properties.NO_PROPERTIES - fields}')
    made = own.settings(bpy.context)
    other = [name for name in properties.BTFSettings.names() if name != 'output' and name != 'sun_angle' and
             getattr(made, name) != getattr(default, name)]
    report('addon-defaults', not other and abs(made.sun_angle - default.sun_angle) < 1e-6, f'{other} {made}')


class Layout:
    """Stands in for a panel's layout, which Blender has with a window only: keeps what a panel draws, and raises where
    that does not exist."""

    def __init__(self):
        self.drawn = set()

    def row(self, **_):
        return self

    column = row

    def prop(self, data, name, **_):
        assert name in data.bl_rna.properties, name
        self.drawn.add(name)

    def prop_search(self, data, name, within, collection, **_):
        assert hasattr(within, collection)
        self.prop(data, name)

    def operator(self, name, **_):
        family, own = name.split('.')
        getattr(getattr(bpy.ops, family), own).get_rna_type()  # raises where there is no such operator
        self.drawn.add(name)

    def label(self, text, **_):
        self.drawn.add(text)

    def template_icon(self, icon_value, **_):
        assert icon_value > 0
        self.drawn.add('picture')


def check_panel():
    """Draws the panels, and finds every setting in them."""
    from openbtf_bake import panel, properties
    layout = Layout()
    for each in panel.CLASSES:
        each.draw(types.SimpleNamespace(layout=layout), bpy.context)
    panel.menu(types.SimpleNamespace(layout=layout), bpy.context)
    lacking = set(properties.BTFSettings.names()) - layout.drawn
    report('addon-panel-has-every-setting', not lacking, f'not drawn: {lacking}')
    # The picture of the preview is not checked: without a window Blender makes no icons.
    report('addon-panel-draws', {'btf.preview', 'btf.bake', 'btf.export', '25 images of 8 x 8 texels'} <= layout.drawn,
           f'{layout.drawn}')


def check_bakes(encoder):
    own = bpy.context.scene.btf_bake
    own.texels, own.directions, own.samples, own.encoder = (8, 8), 'tiny', 1, encoder
    report('addon-preview', bpy.ops.btf.preview() == {'FINISHED'} and 'BTF preview' in bpy.data.images and
           min(bpy.data.images['BTF preview'].size) > 8, f'{list(bpy.data.images)}')

    own.output = os.path.abspath('within')
    report('addon-bake', bpy.ops.btf.bake() == {'FINISHED'} and len(images('within')) == 25, f'{images("within")}')
    report('addon-export', bpy.ops.btf.export(filepath=os.path.abspath('within.btf.exr')) == {'FINISHED'} and
           os.path.getsize('within.btf.exr') > 1000, 'no material')

    # The same bake beside the window: another process renders the same images.
    from openbtf_bake import job
    made = job.Job(own.settings(bpy.context, output=os.path.abspath('beside')),
                   [encoder, os.path.abspath('beside'), '-o', os.path.abspath('beside.btf.exr'), '-q'])
    said = set()
    while not made.done:
        made.poll()
        said.add(made.said)
        time.sleep(0.01)
    made.close()
    one, other = values_of('within'), values_of('beside')
    report('addon-job', not made.error and one.shape == other.shape == (25, 8, 8, 3) and (one == other).all(),
           f'{made.error} {one.shape} {other.shape}, furthest apart {abs(one - other).max() if one.shape == other.shape else ""}')
    report('addon-job-tells', any('25' in text for text in said), f'{said}')
    report('addon-job-encodes', os.path.exists('beside.btf.exr'), 'no material')
    report('addon-job-leaves-nothing', not os.path.exists(made._folder), made._folder)

    bad = job.Job(own.settings(bpy.context, output=os.path.abspath('bad'), collection='none'))
    while not bad.done:
        bad.poll()
        time.sleep(0.01)
    bad.close()
    report('addon-job-error', "'none'" in bad.error, bad.error)
    stopped = job.Job(own.settings(bpy.context, output=os.path.abspath('stopped'), samples=1024))
    while not stopped.done and '25' not in stopped.said:  # until images are rendered; then it is stopped, as by Esc
        stopped.poll()
        time.sleep(0.01)
    rendering = not stopped.done
    stopped.close()
    report('addon-job-stops', rendering and stopped.done and len(images('stopped')) < 25, f'{images("stopped")}')


def check_refusals():
    own = bpy.context.scene.btf_bake
    own.output = os.path.abspath('refused')
    own.collection = 'nowhere'
    text = refused(bpy.ops.btf.bake)
    report('addon-no-collection', "'nowhere'" in text, text)
    own.collection = 'BTF'
    own.directions = 'ubu'
    text = refused(bpy.ops.btf.bake)
    report('addon-no-directions', "'ubu'" in text, text)
    own.directions = 'tiny'
    own.encoder = '/nowhere/btf-encode'
    text = refused(bpy.ops.btf.export, filepath=os.path.abspath('none.btf.exr'))
    report('addon-no-encoder', '/nowhere/btf-encode' in text and not os.path.exists('none.btf.exr'), text)


def main():
    archive, encoder = sys.argv[sys.argv.index('--') + 1:]
    bpy.ops.preferences.addon_install(filepath=archive)
    report('addon-off-at-first', there() == (False, 0, 0), f'{there()}')
    for time_ in ('first', 'second'):
        addon_utils.enable(MODULE, default_set=True)
        report(f'addon-registers-{time_}', there() == (True, 5, 1), f'{there()}')
        if time_ == 'first':
            check_settings()
            check_bakes(encoder)
            check_panel()
            check_refusals()
        addon_utils.disable(MODULE, default_set=True)
        report(f'addon-unregisters-{time_}', there() == (False, 0, 0), f'{there()}')
    sys.exit(1 if FAILED else 0)


main()
