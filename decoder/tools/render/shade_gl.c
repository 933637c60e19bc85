/* GL devices: the table goes up as bits in an integer texture, a full-screen triangle evaluates the GLSL
 * library, the bits come back.
 *
 * SPDX-License-Identifier: MIT
 */
#include "shade_gl.h"

#include "decoder/toolkit/reference_view.h"
#include "decoder/tools/context/context.h"
#include "decoder/tools/context/gl_api.h"
#include "decoder/toolkit/file.h"
#include "shade_fold.h"
#include "table.h"
#include <omp.h>
#include <openbtf/fold.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

typedef struct gl_device {
    context *context;
    gl_api gl;
    btf_gl *material;
    btf_gl_fold *folds[SHADER_VARIANTS]; /* NULL: nothing is folded */
    btf_fold folded[SHADER_VARIANTS];
    GLuint programs[SHADER_VARIANTS], phong;
    GLuint inputs, levels, outputs, framebuffer, array, colour;
    int width, rows; /* of the textures */
    int variants;
    int level;       /* the level of detail of all samples */
    bool has_levels; /* each sample has its own level */
    bool stochastic;
    int picked;     /* times that a list is decoded */
    uint32_t drawn; /* random numbers of each place in a list */
    uint32_t *bits; /* [rows][width][4] */
    char name[240];
} gl_device;

enum { UNIT_INPUTS = 0, UNIT_COLOUR = 1, UNIT_LEVELS = 2, UNIT_FOLDED = 3, UNIT_MATERIAL = 4 };

static const char vertex_text[] =
    "void main() {\n"
    "    gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);\n"
    "}\n";

/* In front of every fragment shader. */
static const char interface_text[] = "precision highp float;\n"
                                     "precision highp int;\n"
                                     "uniform highp usampler2DArray render_inputs;\n"
                                     "uniform highp usampler2D render_levels;\n"
                                     "uniform highp sampler2D render_colour;\n"
                                     "out highp uvec4 render_result;\n";

static const char main_text[] =
    "void main() {\n"
    "    ivec2 at = ivec2(gl_FragCoord.xy);\n"
    "    vec4 a = uintBitsToFloat(texelFetch(render_inputs, ivec3(at, 0), 0));\n"
    "    vec4 b = uintBitsToFloat(texelFetch(render_inputs, ivec3(at, 1), 0));\n"
    "    render_result = uvec4(floatBitsToUint(render_evaluate(a.xy, b.yzw, vec3(a.zw, b.x))), 0u);\n"
    "}\n";

static const char decode_text[] =
    "vec3 render_evaluate(vec2 uv, vec3 l, vec3 v) { return btf_evaluate(uv, l, v); }\n";

/* Decodes one level of detail for all samples. */
static const char one_level_text[] = "vec3 render_evaluate(vec2 uv, vec3 l, vec3 v) {\n"
                                     "    return btf_evaluate_level(uv, l, v, RENDER_LEVEL);\n"
                                     "}\n";

/* Decodes the level of detail that each sample asks for. */
static const char level_text[] =
    "vec3 render_evaluate(vec2 uv, vec3 l, vec3 v) {\n"
    "    uint level = texelFetch(render_levels, ivec2(gl_FragCoord.xy), 0).x;\n"
    "    return btf_evaluate_level(uv, l, v, int(level));\n"
    "}\n";

/* Sums the picks of a sample. RENDER_LEVEL is the level of all samples; below 0, each sample has its own in a
 * texture. */
static const char stochastic_text[] =
    "uniform int render_picked, render_drawn;\n"
    "vec3 render_evaluate(vec2 uv, vec3 l, vec3 v) {\n"
    "    int i = 0, level = RENDER_LEVEL;\n"
    "    vec3 sum = vec3(0.0);\n"
    "    if (level < 0)\n"
    "        level = int(texelFetch(render_levels, ivec2(gl_FragCoord.xy), 0).x);\n"
    "    do {\n"
    "        uvec3 random = btf_random(uvec3(uvec2(gl_FragCoord.xy), uint(render_drawn + i)));\n"
    "        sum = btf_add(sum, btf_evaluate_stochastic_level(uv, l, v, level, random));\n"
    "    } while (++i < render_picked);\n"
    "    return sum;\n"
    "}\n";

static const char phong_text[] =
    "vec3 render_evaluate(vec2 uv, vec3 l, vec3 v) {\n"
    "    vec3 colour = texture(render_colour, vec2(uv.x, 1.0 - uv.y)).rgb;\n"
    "    float shine = pow(max(dot(vec3(-l.xy, l.z), v), 0.0), 20.0);\n"
    "    return v.z > 0.0 ? colour * max(l.z, 0.0) + 0.2 * shine : vec3(0.0);\n"
    "}\n";

static const context_device *find_device(const char *name, const btf_log *log) {
    char list[300] = "reference";
    for (const context_device *d = context_devices; d->name; d++) {
        if (!strcmp(d->name, name)) {
            return d;
        }
        size_t length = strlen(list);
        snprintf(list + length, sizeof list - length, ", %s", d->name);
    }
    file_say(log, "option --device: '%s' is not one of %s", name, list);
    return NULL;
}

static GLuint make_texture(gl_device *d, GLenum target, int unit) {
    GLuint texture = 0;
    d->gl.ActiveTexture(GL_TEXTURE0 + (GLenum)unit);
    d->gl.GenTextures(1, &texture);
    d->gl.BindTexture(target, texture);
    return texture;
}

/* The mean colour of every texel seen and lit from the top, for the Phong shader. */
static bool make_colour(gl_device *d, const btf_material *material) {
    const float top[3] = {0, 0, 1};
    const btf_ref_options options = {BTF_EFFECT_ALL, BTF_MAX_COMPONENTS, BTF_REF_NEAREST, BTF_REF_TEXEL};
    btf_ref_material m;
    reference_view(material, 0, &m);
    float *colour = malloc((size_t)m.width * m.height * 4 * sizeof *colour);
    if (!colour) {
        return false;
    }
    for (uint32_t i = 0; i < m.width * m.height; i++) {
        btf_ref_evaluate_texel(&m, &options, i % m.width, i / m.width, top, top, colour + 4 * (size_t)i);
        colour[4 * (size_t)i + 3] = 1;
    }
    d->colour = make_texture(d, GL_TEXTURE_2D, UNIT_COLOUR);
    d->gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    d->gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    d->gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA16F, (GLsizei)m.width, (GLsizei)m.height, 0, GL_RGBA,
                     GL_FLOAT, colour);
    free(colour);
    return true;
}

static GLuint make_program(gl_device *d, const context_device *device, const char *library,
                           const char *body, const btf_log *log) {
    char version[120];
    snprintf(version, sizeof version, "#version %s\n%s", device->glsl,
             device->enable_gpu_shader5 ? "#extension GL_ARB_gpu_shader5 : require\n" : "");
    const char *vertex[] = {vertex_text, NULL};
    char level[40];
    snprintf(level, sizeof level, "#define RENDER_LEVEL %d\n", d->level);
    const char *fragment[] = {level, interface_text, library, body, main_text, NULL};
    GLuint program = gl_api_program(&d->gl, version, vertex, fragment, log);
    if (!program) {
        return 0;
    }
    d->gl.UseProgram(program);
    d->gl.Uniform1i(d->gl.GetUniformLocation(program, "render_inputs"), UNIT_INPUTS);
    d->gl.Uniform1i(d->gl.GetUniformLocation(program, "render_colour"), UNIT_COLOUR);
    d->gl.Uniform1i(d->gl.GetUniformLocation(program, "render_levels"), UNIT_LEVELS);
    d->gl.UseProgram(0);
    return program;
}

/* Folds what the options say; where GL refuses the texture, or to fill it, options->fold becomes BTF_FOLD_NONE. */
static void make_fold(gl_device *d, const shader_request *request, int variant, btf_shader_options *options,
                      const btf_log *log) {
    btf_gl_fold **fold = &d->folds[variant];
    btf_material_info info = {.struct_size = sizeof info};
    const btf_gl_options gl = {sizeof gl, context_get_proc_address, d->context, options};
    file_kept why;
    const btf_log keeps = file_log_keep(&why);
    if (options->fold == BTF_FOLD_NONE) {
        return;
    }
    btf_result result = btf_gl_fold_create(request->material, &gl, 1, &keeps, fold);
    if (result == BTF_OK && request->lights > 0) {
        result = btf_gl_fold_run_lights(*fold, d->material, UNIT_MATERIAL, 0, (uint32_t)request->lights,
                                        request->light_directions, request->light_weights,
                                        options->fixed_view, &keeps);
    } else if (result == BTF_OK) {
        result = btf_gl_fold_run(*fold, d->material, UNIT_MATERIAL, 0, options->fixed_light,
                                 options->fixed_view, &keeps);
    }
    if (result == BTF_OK) {
        return;
    }
    btf_material_get_info(request->material, &info);
    file_warn(log, "%s refuses %zu bytes for a fold: nothing is folded (%s)", d->name,
              btf_fold_bytes(&info, options->fold, 1), why.text);
    btf_gl_fold_destroy(fold);
    options->fold = BTF_FOLD_NONE;
}

static btf_result make_variant(gl_device *d, const context_device *device, const shader_request *request,
                               int variant, const btf_log *log) {
    btf_shader_options options = shade_fold_options(request, variant, log);
    options.have_precise = device->enable_gpu_shader5;
    make_fold(d, request, variant, &options, log);
    d->folded[variant] = options.fold;
    char *library = NULL;
    btf_result result = btf_shader_source(request->material, &options, log, &library);
    if (result) {
        return result;
    }
    d->programs[variant] = make_program(d, device, library,
                                        d->stochastic   ? stochastic_text
                                        : d->has_levels ? level_text
                                        : d->level > 0  ? one_level_text
                                                        : decode_text,
                                        log);
    btf_free(library);
    if (!d->programs[variant]) {
        return BTF_ERROR_INTERNAL;
    }
    return btf_gl_bind(d->material, d->programs[variant], UNIT_MATERIAL, NULL, log, NULL);
}

/* Checks what the request needs of the device: exact arithmetic where it asks for that; whatever the arithmetic, right
 * fetches from levels of detail and from lists of points, and factors that are multiplied and fetched as whole
 * numbers. With fast math nothing is checked for a material of one level without factors. */
static btf_result check_device(gl_device *d, const context_device *device, const shader_request *request,
                               const btf_log *log) {
    const btf_gl_options options = {sizeof options, context_get_proc_address, d->context, NULL};
    uint32_t failures = 0;
    char names[200];
    snprintf(d->name, sizeof d->name, "%s, %s", (const char *)d->gl.GetString(GL_RENDERER),
             (const char *)d->gl.GetString(GL_VERSION));
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(request->material, &info);
    if (request->math == BTF_MATH_FAST && info.levels == 1 && info.store != BTF_STORE_FACTORS &&
        info.point_store != BTF_POINTS_LISTS) {
        return BTF_OK;
    }
    btf_result result = btf_gl_self_test(&options, log, &failures);
    if (!result && failures & BTF_SELF_TEST_LEVELS && info.levels > 1) {
        file_say(log,
                 "device %s (%s) fetches from mip levels other than the one asked for: it cannot show a "
                 "material of several levels of detail",
                 device->name, d->name);
        return BTF_ERROR_UNSUPPORTED;
    }
    if (!result && failures & BTF_SELF_TEST_FACTORS && info.store == BTF_STORE_FACTORS) {
        file_say(
            log,
            "device %s (%s) multiplies or fetches packed factors wrongly: it cannot show this material",
            device->name, d->name);
        return BTF_ERROR_UNSUPPORTED;
    }
    if (!result && failures & BTF_SELF_TEST_LISTS && info.point_store == BTF_POINTS_LISTS) {
        file_say(log, "device %s (%s) fetches from lists of points wrongly: it cannot show this material",
                 device->name, d->name);
        return BTF_ERROR_UNSUPPORTED;
    }
    failures &= ~(uint32_t)(BTF_SELF_TEST_LEVELS | BTF_SELF_TEST_FACTORS | BTF_SELF_TEST_LISTS);
    if (!result && failures && request->math != BTF_MATH_FAST) {
        btf_self_test_names(failures, names, sizeof names);
        file_say(log, "device %s (%s) does not keep to the format's arithmetic: %s; try --math fast",
                 device->name, d->name, names);
        return BTF_ERROR_UNSUPPORTED;
    }
    return result;
}

static btf_result fill(gl_device *d, const context_device *device, const shader_request *request,
                       const btf_log *log) {
    const btf_gl_options options = {sizeof options, context_get_proc_address, d->context, NULL};
    btf_result result = gl_api_load(&d->gl, context_get_proc_address, d->context, log);
    if (!result) {
        result = check_device(d, device, request, log);
    }
    if (!result) {
        result = btf_gl_upload(request->material, &options, log, &d->material);
    }
    if (!result && !make_colour(d, request->material)) {
        file_say(log, "out of memory for a texture");
        result = BTF_ERROR_MEMORY;
    }
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(request->material, &info);
    d->has_levels = info.levels > 1 && request->level < 0;
    d->level = info.levels > 1 ? request->level : 0;
    d->variants = request->variants;
    d->stochastic = request->picks != BTF_PICK_NONE;
    d->picked = d->stochastic ? request->picked : 1;
    for (int i = 0; i < request->variants && !result; i++) {
        result = make_variant(d, device, request, i, log);
    }
    if (!result && !(d->phong = make_program(d, device, "", phong_text, log))) {
        result = BTF_ERROR_INTERNAL;
    }
    if (result) {
        return result;
    }
    d->gl.GenFramebuffers(1, &d->framebuffer);
    d->gl.BindFramebuffer(GL_FRAMEBUFFER, d->framebuffer);
    d->gl.GenVertexArrays(1, &d->array);
    d->gl.BindVertexArray(d->array);
    return BTF_OK;
}

static void destroy(void *self) {
    gl_device *d = self;
    for (int i = 0; i < SHADER_VARIANTS; i++) {
        btf_gl_fold_destroy(&d->folds[i]);
    }
    if (d->material) {
        btf_gl_destroy(&d->material);
    }
    context_destroy(&d->context); /* and all that lives in it */
    free(d->bits);
    free(d);
}

static void *create(const shader_request *request, const btf_log *log, btf_result *out_result) {
    const context_device *device = find_device(request->device, log);
    char why[300] = "";
    if (!device) {
        *out_result = BTF_ERROR_USAGE;
        return NULL;
    }
    gl_device *d = calloc(1, sizeof *d);
    if (!d) {
        file_say(log, "out of memory for a device");
        *out_result = BTF_ERROR_MEMORY;
        return NULL;
    }
    context_prepare(device);
    d->context = context_create(device, why, sizeof why);
    if (!d->context) {
        file_say(log, "device %s: %s (--device reference renders on the CPU)", device->name, why);
        *out_result = BTF_ERROR_UNSUPPORTED;
        free(d);
        return NULL;
    }
    if ((*out_result = fill(d, device, request, log))) {
        destroy(d);
        return NULL;
    }
    return d;
}

static const char *name(const void *self) {
    return ((const gl_device *)self)->name;
}

static int max_width(const void *self) {
    GLint size = 0;
    ((const gl_device *)self)->gl.GetIntegerv(GL_MAX_TEXTURE_SIZE, &size);
    return size;
}

/* Makes the textures large enough. */
static btf_result resize(gl_device *d, int width, int rows, const btf_log *log) {
    if (width == d->width && rows == d->rows) {
        return BTF_OK;
    }
    uint32_t *bits = realloc(d->bits, (size_t)width * (size_t)rows * 4 * sizeof *bits);
    if (!bits) {
        file_say(log, "out of memory for %d x %d samples", width, rows);
        return BTF_ERROR_MEMORY;
    }
    d->bits = bits;
    const GLuint old[3] = {d->inputs, d->outputs, d->levels};
    d->gl.DeleteTextures(3, old);
    d->outputs = make_texture(d, GL_TEXTURE_2D, UNIT_INPUTS);
    d->gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    d->gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    d->gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32UI, width, rows, 0, GL_RGBA_INTEGER, GL_UNSIGNED_INT, NULL);
    d->inputs = make_texture(d, GL_TEXTURE_2D_ARRAY, UNIT_INPUTS);
    d->gl.TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    d->gl.TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    d->gl.TexImage3D(GL_TEXTURE_2D_ARRAY, 0, GL_RGBA32UI, width, rows, 2, 0, GL_RGBA_INTEGER,
                     GL_UNSIGNED_INT, NULL);
    d->levels = make_texture(d, GL_TEXTURE_2D, UNIT_LEVELS);
    d->gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    d->gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    d->gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, d->outputs, 0);
    d->width = width;
    d->rows = rows;
    GLenum error = d->gl.GetError();
    if (error != GL_NO_ERROR || d->gl.CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
        file_say(log, "%s: GL refuses a framebuffer of %d x %d samples of RGBA32UI (error 0x%04x)", d->name,
                 width, rows, error);
        return BTF_ERROR_UNSUPPORTED;
    }
    return BTF_OK;
}

static btf_result run(void *self, int variant, int width, int rows, const float *inputs, float *out,
                      const btf_log *log) {
    gl_device *d = self;
    const size_t count = (size_t)width * (size_t)rows;
    btf_result result = resize(d, width, rows, log);
    if (result) {
        return result;
    }
    d->gl.ActiveTexture(GL_TEXTURE0 + UNIT_INPUTS);
    d->gl.BindTexture(GL_TEXTURE_2D_ARRAY, d->inputs);
    for (int half = 0; half < 2; half++) {
        for (size_t i = 0; i < count; i++) {
            memcpy(d->bits + 4 * i, inputs + TABLE_INPUTS * i + 4 * half, 16);
        }
        d->gl.TexSubImage3D(GL_TEXTURE_2D_ARRAY, 0, 0, 0, half, width, rows, 1, GL_RGBA_INTEGER,
                            GL_UNSIGNED_INT, d->bits);
    }
    if (d->has_levels) {
        for (size_t i = 0; i < count; i++) {
            d->bits[i] = (uint32_t)inputs[TABLE_INPUTS * i + 8];
        }
        d->gl.ActiveTexture(GL_TEXTURE0 + UNIT_LEVELS);
        d->gl.BindTexture(GL_TEXTURE_2D, d->levels);
        d->gl.TexImage2D(GL_TEXTURE_2D, 0, GL_R32UI, width, rows, 0, GL_RED_INTEGER, GL_UNSIGNED_INT,
                         d->bits);
    }
    /* Bound anew in each run, because variants that read other textures use the same texture units. */
    const btf_result bound = btf_gl_bind(d->material, d->programs[variant], UNIT_MATERIAL, NULL, log, NULL);
    if (bound) {
        return bound;
    }
    if (d->folds[variant]) {
        btf_gl_fold_bind(d->folds[variant], d->programs[variant], UNIT_FOLDED, NULL);
    }
    d->gl.UseProgram(d->programs[variant]);
    if (d->stochastic) {
        d->gl.Uniform1i(d->gl.GetUniformLocation(d->programs[variant], "render_picked"), d->picked);
        d->gl.Uniform1i(d->gl.GetUniformLocation(d->programs[variant], "render_drawn"), (GLint)d->drawn);
        d->drawn += (uint32_t)d->picked;
    }
    d->gl.Viewport(0, 0, width, rows);
    d->gl.DrawArrays(GL_TRIANGLES, 0, 3);
    d->gl.ReadPixels(0, 0, width, rows, GL_RGBA_INTEGER, GL_UNSIGNED_INT, d->bits);
    for (size_t i = 0; i < count; i++) {
        memcpy(out + 3 * i, d->bits + 4 * i, 12);
        for (size_t c = 0; c < 3 && d->stochastic; c++) {
            out[3 * i + c] = out[3 * i + c] / (float)d->picked;
        }
    }
    GLenum error = d->gl.GetError();
    if (error != GL_NO_ERROR) {
        file_say(log, "%s: error 0x%04x while drawing", d->name, error);
        return BTF_ERROR_INTERNAL;
    }
    return BTF_OK;
}

static int compare(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static btf_result time_draws(void *self, int variant, int repeats, shader_times *out_times) {
    gl_device *d = self;
    double *seconds = calloc((size_t)repeats, sizeof *seconds);
    clock_t cpu = 0;
    *out_times = (shader_times){0};
    if (!seconds) {
        return BTF_ERROR_MEMORY;
    }
    d->gl.UseProgram(variant == SHADER_PHONG ? d->phong : d->programs[variant]);
    for (int i = -1; i < repeats; i++) { /* -1 warms up */
        if (i == 0) {
            cpu = clock();
        }
        double start = omp_get_wtime();
        d->gl.DrawArrays(GL_TRIANGLES, 0, 3);
        d->gl.Finish();
        if (i >= 0) {
            seconds[i] = omp_get_wtime() - start;
        }
    }
    qsort(seconds, (size_t)repeats, sizeof *seconds, compare);
    *out_times = (shader_times){seconds[repeats / 2], (double)(clock() - cpu) / CLOCKS_PER_SEC / repeats};
    free(seconds);
    return d->gl.GetError() == GL_NO_ERROR ? BTF_OK : BTF_ERROR_INTERNAL;
}

static btf_fold folded(const void *self) {
    return ((const gl_device *)self)->folded[0];
}

const shader_class shader_class_gl = {create, destroy, name, max_width, run, folded, time_draws};
