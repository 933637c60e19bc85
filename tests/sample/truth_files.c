/* Writes the truth of a sample as NumPy files.
 *
 * SPDX-License-Identifier: MIT
 */
#include "truth_files.h"

#include "decoder/toolkit/output.h"

#include <stdlib.h>
#include <string.h>

static const char README[] =
    "The truth of this BTF, known by construction. Read with numpy.load.\n"
    "\n"
    "Axes: x along +u (to the right), y along +v (up), z the surface normal; lengths in tiles; z = 0 is "
    "the plane\n"
    "of the highest points. Row 0 is the top of an image: x = (column + 0.5) / width,\n"
    "y = 1 - (row + 0.5) / height. theta from z, phi from x towards y, degrees. A surface point p shows in "
    "the\n"
    "rectified image of view v at p.xy - p.z * v.xy / v.z, wrapped to the tile.\n"
    "\n"
    "position.npy    float32 (views, rows, columns, 3)  the point that the ray through the texel's centre "
    "hits;\n"
    "                x and y are not wrapped: they may leave 0..1\n"
    "shift.npy       float32 (views, rows, columns, 2)  (columns, rows), not wrapped: the same point shows "
    "in the\n"
    "                view from the pole at (column, row) + shift\n"
    "hidden.npy      uint8 (views, rows, columns)  1 where the view from the pole does not show the point; "
    "a\n"
    "                height field has none\n"
    "shadow.npy      uint8 (views, lights, rows, columns)  1 where at least half of the texel's rays end "
    "at a point\n"
    "                that the light does not reach: it is occluded or faces away\n"
    "top_shadow.npy  uint8 (lights, rows, columns)  the same for the view from the pole\n"
    "views.npy, lights.npy  float64 (directions, 2)  theta, phi\n";

static btf_result open_in(const sample_scene *scene, const char *folder, const char *name,
                          output **out_file) {
    const enc_context *context = sample_scene_options(scene)->context;
    size_t size = strlen(folder) + strlen(name) + 2;
    char *path = malloc(size);
    if (!path) {
        return enc_fail(context, BTF_ERROR_MEMORY, "%s/%s: out of memory", folder, name);
    }
    snprintf(path, size, "%s/%s", folder, name);
    btf_result result = output_open(path, context ? context->log : (btf_log){0}, out_file);
    free(path);
    return result;
}

/* One array in format 1.0 of NumPy's .npy: a magic word, the length of a Python dictionary as text that
 * pads the header to a multiple of 64, the samples in C order. type: NumPy's, without the byte order, e.g.
 * "f4". */
static btf_result write_array(const sample_scene *scene, const char *folder, const char *name,
                              const char *type, const void *values, int dimensions, const size_t *shape) {
    const uint16_t one = 1;
    const char order = type[1] == '1' ? '|' : *(const char *)&one ? '<' : '>';
    size_t count = 1, element = (size_t)(type[1] - '0');
    char text[256];
    int length =
        snprintf(text, sizeof text, "{'descr': '%c%s', 'fortran_order': False, 'shape': (", order, type);
    for (int d = 0; d < dimensions; ++d) {
        length += snprintf(text + length, sizeof text - (size_t)length, "%zu, ", shape[d]);
        count *= shape[d];
    }
    length += snprintf(text + length, sizeof text - (size_t)length, "), }");
    while ((10 + length + 1) % 64 != 0) {
        text[length++] = ' ';
    }
    text[length++] = '\n';
    const unsigned char head[10] = {0x93, 'N', 'U', 'M', 'P', 'Y', 1, 0, length & 255, length >> 8};
    output *file = NULL;
    btf_result result = open_in(scene, folder, name, &file);
    if (result != BTF_OK) {
        return result;
    }
    fwrite(head, 1, sizeof head, output_stream(file));
    fwrite(text, 1, (size_t)length, output_stream(file));
    fwrite(values, element, count, output_stream(file));
    return output_commit(&file); /* reports a stream in error */
}

static btf_result write_directions(const sample_scene *scene, const char *folder, const char *name,
                                   const enc_direction *list, int count) {
    double angles[256][2];
    for (int i = 0; i < count; ++i) {
        angles[i][0] = list[i].theta;
        angles[i][1] = list[i].phi;
    }
    return write_array(scene, folder, name, "f8", angles, 2, (size_t[]){(size_t)count, 2});
}

btf_result truth_files_write(const sample_scene *scene, const sample_truth *truth, const char *folder) {
    const sample_options *o = sample_scene_options(scene);
    const size_t views = (size_t)truth->n_views, lights = (size_t)truth->n_lights;
    const size_t rows = (size_t)truth->height, columns = (size_t)truth->width;
    const struct {
        const char *name, *type;
        const void *values;
        int dimensions;
        size_t shape[4];
    } arrays[] = {
        {"position.npy", "f4", truth->position, 4, {views, rows, columns, 3}},
        {"shift.npy", "f4", truth->shift, 4, {views, rows, columns, 2}},
        {"hidden.npy", "u1", truth->hidden, 3, {views, rows, columns}},
        {"shadow.npy", "u1", truth->shadow, 4, {views, lights, rows, columns}},
        {"top_shadow.npy", "u1", truth->top_shadow, 3, {lights, rows, columns}},
    };
    btf_result result = BTF_OK;
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays && result == BTF_OK; ++i) {
        result = write_array(scene, folder, arrays[i].name, arrays[i].type, arrays[i].values,
                             arrays[i].dimensions, arrays[i].shape);
    }
    if (result == BTF_OK) {
        result = write_directions(scene, folder, "views.npy", o->views, o->n_views);
    }
    if (result == BTF_OK) {
        result = write_directions(scene, folder, "lights.npy", o->lights, o->n_lights);
    }
    if (result != BTF_OK) {
        return result;
    }
    output *file = NULL;
    result = open_in(scene, folder, "README.txt", &file);
    if (result != BTF_OK) {
        return result;
    }
    fputs(README, output_stream(file));
    return output_commit(&file);
}
