/* The images that a material was made from. See original_texture.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "original_texture.h"

#include "decoder/toolkit/file.h"
#include <stdlib.h>

/* Writes the samples of a view, [channel][light] at each texel, as tiles [row][column][channel] of a layer. */
static void fill_layer(const btf_material_info *info, const float *samples, uint32_t view, int columns,
                       float *layer) {
    const size_t lights = info->n_lights, texels = (size_t)info->width * info->height;
    const size_t width = (size_t)columns * info->width;
    for (size_t i = 0; i < texels * lights; i++) {
        const size_t texel = i / lights, light = i % lights;
        const size_t x = light % (size_t)columns * info->width + texel % info->width;
        const size_t y = light / (size_t)columns * info->height + texel / info->width;
        const float *from = samples + ((texel * info->n_views + view) * 3) * lights + light;
        for (size_t c = 0; c < 3; c++) {
            layer[3 * (y * width + x) + c] = from[c * lights];
        }
    }
}

btf_result original_texture_create(const gl_api *gl, int unit, const btf_material *material,
                                   const original *images, const btf_log *log,
                                   original_texture *out_texture) {
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(material, &info);
    GLint most = 0, most_layers = 0;
    int columns = 1;
    while (columns * columns < (int)info.n_lights) {
        columns++;
    }
    const int rows = ((int)info.n_lights + columns - 1) / columns;
    const int width = columns * (int)info.width, height = rows * (int)info.height;
    *out_texture = (original_texture){.columns = columns};
    gl->GetIntegerv(GL_MAX_TEXTURE_SIZE, &most);
    gl->GetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &most_layers);
    if (width > most || height > most || (int)info.n_views > most_layers) {
        file_say(log,
                 "option --original: %d x %d texels in %u layers exceed GL's limits, %d texels a side and "
                 "%d layers",
                 width, height, (unsigned)info.n_views, most, most_layers);
        return BTF_ERROR_UNSUPPORTED;
    }
    float *layer = calloc((size_t)width * (size_t)height * 3, sizeof *layer);
    if (!layer) {
        file_say(log, "out of memory for the images of a view");
        return BTF_ERROR_MEMORY;
    }
    gl->ActiveTexture(GL_TEXTURE0 + (GLenum)unit);
    gl->GenTextures(1, &out_texture->name);
    gl->BindTexture(GL_TEXTURE_2D_ARRAY, out_texture->name);
    gl->TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl->TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    gl->TexImage3D(GL_TEXTURE_2D_ARRAY, 0, GL_RGB9_E5, width, height, (GLsizei)info.n_views, 0, GL_RGB,
                   GL_FLOAT, NULL);
    gl->PixelStorei(GL_UNPACK_ALIGNMENT, 4);
    for (uint32_t v = 0; v < info.n_views; v++) {
        fill_layer(&info, original_samples(images), v, columns, layer);
        gl->TexSubImage3D(GL_TEXTURE_2D_ARRAY, 0, 0, 0, (GLint)v, width, height, 1, GL_RGB, GL_FLOAT,
                          layer);
    }
    free(layer);
    const GLenum error = gl->GetError();
    if (error != GL_NO_ERROR) {
        file_say(log, "option --original: GL error 0x%04x while its images were uploaded", error);
        return error == GL_OUT_OF_MEMORY ? BTF_ERROR_MEMORY : BTF_ERROR_INTERNAL;
    }
    return BTF_OK;
}

void original_texture_clear(const gl_api *gl, original_texture *texture) {
    gl->DeleteTextures(1, &texture->name);
    *texture = (original_texture){0};
}
