"""The panel in the material tab, and the line in the menu File > Export.

SPDX-License-Identifier: MIT
"""
import bpy

from . import operators


class MATERIAL_PT_btf_bake(bpy.types.Panel):
    bl_label = 'BTF'
    bl_space_type = 'PROPERTIES'
    bl_region_type = 'WINDOW'
    bl_context = 'material'
    bl_options = {'DEFAULT_CLOSED'}

    def draw(self, context):
        own, layout = context.scene.btf_bake, self.layout
        layout.use_property_split, layout.use_property_decorate = True, False
        row = layout.row()
        row.active = not own.selected
        row.prop_search(own, 'collection', bpy.data, 'collections')
        layout.prop(own, 'selected')
        column = layout.column(align=True)
        for name in ('tile', 'z', 'repeat'):
            column.prop(own, name)
        column = layout.column(align=True)
        for name in ('texels', 'directions', 'samples', 'bounces', 'sun_angle', 'seed'):
            column.prop(own, name)
        layout.label(text=operators.foreseen(context))
        row = layout.row(align=True)
        row.operator('btf.preview', icon='IMAGE_DATA')
        row.operator('btf.bake', icon='RENDER_STILL')
        row.operator('btf.export', text='Material', icon='EXPORT')
        if operators.running():
            layout.label(text=operators.said(), icon='TIME')
        picture = operators.picture()
        if picture:
            layout.template_icon(icon_value=picture, scale=12)


class MATERIAL_PT_btf_bake_more(bpy.types.Panel):
    bl_label = 'More'
    bl_space_type = 'PROPERTIES'
    bl_region_type = 'WINDOW'
    bl_context = 'material'
    bl_parent_id = 'MATERIAL_PT_btf_bake'
    bl_options = {'DEFAULT_CLOSED'}

    def draw(self, context):
        own, layout = context.scene.btf_bake, self.layout
        layout.use_property_split, layout.use_property_decorate = True, False
        for name in ('output', 'views', 'lights', 'pairs', 'position', 'part', 'threads', 'strict', 'encoder'):
            layout.prop(own, name)


def menu(self, context):
    self.layout.operator('btf.export', text='BTF material (.btf.exr)')


CLASSES = (MATERIAL_PT_btf_bake, MATERIAL_PT_btf_bake_more)


def register():
    for each in CLASSES:
        bpy.utils.register_class(each)
    bpy.types.TOPBAR_MT_file_export.append(menu)


def unregister():
    bpy.types.TOPBAR_MT_file_export.remove(menu)
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)
