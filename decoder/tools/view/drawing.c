/* The material on a mesh by rasterisation.
 *
 * SPDX-License-Identifier: MIT
 */
#include "drawing.h"

#include "decoder/toolkit/file.h"
#include "decoder/tools/render/table.h"
#include "drawing_shaders.h"
#include "history.h"
#include "light_fold.h"
#include "mesh_buffers.h"
#include "original_texture.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    PROGRAMS = 32,
    SOURCES = 1 + DRAWING_SLOTS,
    UNIT_IMAGES = 0,
    UNIT_HISTORY = 1,
    UNIT_FOLDED = 2,
    UNIT_MATERIAL = 3
};

/* The choices that a GL program is compiled for. */
typedef struct variant {
    uint32_t effects;
    btf_interpolation interpolation;
    btf_filter filter;
    btf_math math;
    bool images, levels, stochastic;
    bool folded; /* reads a fold where there is one */
} variant;

typedef struct program {
    variant variant;
    GLuint name;
} program;

/* The material that is drawn: the whole one (number 0) or one made for a plan (its slot + 1). */
typedef struct source {
    const btf_material *material;
    btf_material *apart; /* in layout tight, drawn in its place where GL's textures cannot hold its atlas */
    btf_gl *textures;    /* NULL until it is drawn */
    btf_plan plan;   /* of a plan's: what it decodes of the material; of the whole, a light that rests */
    light_fold fold; /* of the fixed light, where that is drawn from */
    program programs[PROGRAMS];
    int program_count;
} source;

struct drawing {
    const gl_api *gl;
    btf_gl_get_proc_address get;
    void *user;
    source sources[SOURCES];
    int used; /* the source that is drawn */
    mesh_buffers mesh;
    double repeat;
    original_texture images;
    bool have_precise;
    bool folds_refused;          /* by GL: the user was told once, and no other fold is tried */
    const btf_cost_model *costs; /* that say when a fold pays; NULL: those of llvmpipe */
    history *history;
    view_state accumulated; /* the state that the history is of */
    int accumulated_source;
};

static void forget_source(drawing *d, source *s) {
    for (int i = 0; i < s->program_count; i++) {
        d->gl->DeleteProgram(s->programs[i].name);
    }
    light_fold_clear(&s->fold);
    btf_gl_destroy(&s->textures);
    btf_material_close(&s->apart);
    *s = (source){0};
}

static void forget_material(drawing *d) {
    for (int i = 0; i < SOURCES; i++) {
        forget_source(d, &d->sources[i]);
    }
    original_texture_clear(d->gl, &d->images);
    d->used = 0;
    if (d->history) {
        history_clear(d->history);
    }
}

drawing *drawing_create(const gl_api *gl, btf_gl_get_proc_address get, void *user, const btf_log *log) {
    drawing *d = calloc(1, sizeof *d);
    if (!d) {
        file_say(log, "out of memory for a drawing");
        return NULL;
    }
    d->gl = gl;
    d->get = get;
    d->user = user;
    d->have_precise = gl_api_has(gl, "GL_ARB_gpu_shader5");
    mesh_buffers_create(gl, &d->mesh);
    return d;
}

void drawing_destroy(drawing **d) {
    if (!d || !*d) {
        return;
    }
    forget_material(*d);
    history_destroy(&(*d)->history);
    mesh_buffers_clear((*d)->gl, &(*d)->mesh);
    free(*d);
    *d = NULL;
}

/* Uploads the textures of a source that was not drawn before. */
static btf_result upload(drawing *d, source *s, const btf_log *log) {
    const btf_gl_options options = {sizeof options, d->get, d->user, NULL};
    btf_material_info info = {.struct_size = sizeof info};
    int fits = 1;
    if (s->textures) {
        return BTF_OK;
    }
    btf_result result = btf_material_get_info(s->material, &info);
    if (!result) {
        result = btf_gl_fits(s->material, &options, log, &fits);
    }
    if (!result && !fits && info.layout == BTF_LAYOUT_PAPER) {
        result = btf_material_to_tight(s->material, log, &s->apart);
    }
    if (!result) {
        result = btf_gl_upload(s->apart ? s->apart : s->material, &options, log, &s->textures);
    }
    if (!result && s->apart) {
        s->material = s->apart;
    }
    return result;
}

btf_result drawing_set_material(drawing *d, const btf_material *material, const original *images,
                                bool planned, const btf_log *log) {
    forget_material(d);
    d->sources[0].material = material;
    btf_result result = planned ? BTF_OK : upload(d, &d->sources[0], log);
    if (!result && images) {
        result = original_texture_create(d->gl, UNIT_IMAGES, material, images, log, &d->images);
    }
    if (result) {
        forget_material(d);
    }
    return result;
}

btf_result drawing_set_plan(drawing *d, int slot, const btf_material *material, const btf_plan *plan,
                            const btf_log *log) {
    source *s = &d->sources[1 + slot];
    forget_source(d, s);
    s->material = material;
    s->plan = *plan;
    const btf_result result = upload(d, s, log);
    if (result) {
        forget_source(d, s);
    }
    return result;
}

void drawing_set_costs(drawing *d, const btf_cost_model *costs) {
    d->costs = costs;
}

bool drawing_folds(const drawing *d, const view_state *s) {
    return !d->folds_refused && !s->stochastic;
}

void drawing_use_plan(drawing *d, int slot) {
    d->used = 1 + slot;
    for (int i = 1; i < SOURCES; i++) {
        if (i != d->used) {
            light_fold_clear(&d->sources[i].fold);
            btf_gl_destroy(&d->sources[i].textures);
        }
    }
}

size_t drawing_bytes(const drawing *d) {
    size_t bytes = 0;
    for (int i = 0; i < SOURCES; i++) {
        bytes += (d->sources[i].textures ? btf_gl_bytes(d->sources[i].textures) : 0) +
                 (d->sources[i].fold.gl ? btf_gl_fold_bytes(d->sources[i].fold.gl) : 0);
    }
    return bytes;
}

btf_result drawing_set_mesh(drawing *d, const mesh *m, double repeat, const btf_log *log) {
    const btf_result result = mesh_buffers_set(d->gl, &d->mesh, m, log);
    d->repeat = repeat;
    if (d->history) {
        history_clear(d->history);
    }
    return result;
}

static bool same_variant(const variant *a, const variant *b) {
    return a->effects == b->effects && a->interpolation == b->interpolation && a->filter == b->filter &&
           a->math == b->math && a->images == b->images && a->levels == b->levels &&
           a->stochastic == b->stochastic && a->folded == b->folded;
}

static btf_shader_options options_of(const drawing *d, const source *s, const variant *v) {
    const bool planned = s != &d->sources[0];
    btf_shader_options options = {.struct_size = sizeof options,
                                  .leave_out = BTF_EFFECT_ALL & ~v->effects,
                                  .interpolation = v->interpolation,
                                  .filter = v->filter,
                                  .math = v->math,
                                  .have_precise = d->have_precise,
                                  .picks = v->stochastic ? BTF_PICK_ALL : BTF_PICK_NONE};
    if (planned) {
        options.leave_out |= BTF_EFFECT_ALL & ~s->plan.effects;
        options.components = s->plan.components;
        options.fixed = s->plan.shader.fixed;
        memcpy(options.fixed_view, s->plan.shader.fixed_view, sizeof options.fixed_view);
        memcpy(options.fixed_light, s->plan.shader.fixed_light, sizeof options.fixed_light);
    }
    return options;
}

/* Folds the light that the source's plan fixes, for this variant, where that is worth it and fits into GL's memory. */
static btf_result fold(drawing *d, source *s, const variant *v, double pixels, const btf_log *log) {
    btf_material_info info = {.struct_size = sizeof info};
    const btf_gl_options gl = {sizeof gl, d->get, d->user, NULL};
    file_kept why;
    const btf_log keeps = file_log_keep(&why);
    btf_shader_options options = options_of(d, s, v);
    options.fixed = s->plan.shader.fixed; /* of the whole material, too */
    memcpy(options.fixed_light, s->plan.shader.fixed_light, sizeof options.fixed_light);
    if (d->folds_refused || !s->textures || !light_fold_wanted(s->material, &options, pixels, d->costs)) {
        light_fold_clear(&s->fold);
        return BTF_OK;
    }
    if (light_fold_make(&s->fold, s->material, s->textures, &gl, &options, UNIT_MATERIAL, &keeps) ==
        BTF_OK) {
        return BTF_OK;
    }
    d->folds_refused = true;
    btf_material_get_info(s->material, &info);
    file_warn(log, "GL refuses %zu bytes for a fold of the light: nothing is folded from here on (%s)",
              btf_fold_bytes(&info, BTF_FOLD_LIGHT, 1), why.text);
    return BTF_OK;
}

static btf_result compile(drawing *d, const source *s, const variant *v, const btf_log *log,
                          GLuint *out_program) {
    btf_shader_options options = options_of(d, s, v);
    options.fold = v->folded ? BTF_FOLD_LIGHT : BTF_FOLD_NONE;
    char *library = NULL;
    btf_result result = btf_shader_source(s->material, &options, log, &library);
    if (result) {
        return result;
    }
    const char *vertex[] = {vertex_text, NULL};
    const char *fragment[] = {library, steps_text,
                              v->images       ? images_text
                              : v->stochastic ? stochastic_text
                              : v->levels     ? level_text
                                              : material_text,
                              fragment_text, NULL};
    *out_program =
        gl_api_program(d->gl,
                       d->have_precise ? "#version 330 core\n#extension GL_ARB_gpu_shader5 : require\n"
                                       : "#version 330 core\n",
                       vertex, fragment, log);
    btf_free(library);
    if (!*out_program) {
        return BTF_ERROR_INTERNAL;
    }
    return BTF_OK;
}

/* The program of a variant, compiled when it is new. */
static btf_result find_program(drawing *d, source *s, const variant *v, const btf_log *log,
                               GLuint *out_program) {
    for (int i = 0; i < s->program_count; i++) {
        if (same_variant(&s->programs[i].variant, v)) {
            *out_program = s->programs[i].name;
            return BTF_OK;
        }
    }
    btf_result result = compile(d, s, v, log, out_program);
    if (result) {
        return result;
    }
    if (s->program_count == PROGRAMS) {
        d->gl->DeleteProgram(s->programs[0].name);
        memmove(s->programs, s->programs + 1, (PROGRAMS - 1) * sizeof *s->programs);
        s->program_count--;
    }
    s->programs[s->program_count++] = (program){*v, *out_program};
    return BTF_OK;
}

/* Makes the column-major matrix that projects the world for a camera frame. */
static void make_matrix(const camera_frame *f, int width, int height, float m[16]) {
    const double smaller = width < height ? width : height, near = 0.05, far = f->distance + 4;
    const double sx = f->distance / f->half * smaller / width,
                 sy = f->distance / f->half * smaller / height;
    const double a = -(far + near) / (far - near), b = -2 * far * near / (far - near);
    const double axes[3][3] = {{f->right.x, f->right.y, f->right.z},
                               {f->up.x, f->up.y, f->up.z},
                               {f->back.x, f->back.y, f->back.z}};
    for (int k = 0; k < 3; k++) {
        m[4 * k] = (float)(sx * axes[0][k]);
        m[4 * k + 1] = (float)(sy * axes[1][k]);
        m[4 * k + 2] = (float)(a * axes[2][k]);
        m[4 * k + 3] = (float)-axes[2][k];
    }
    m[12] = m[13] = 0;
    m[14] = (float)(b - a * f->distance);
    m[15] = (float)f->distance;
}

/* Makes a fold anew where effects or interpolation were switched, or textures were gone. The right half of a split
 * screen, which shows other effects, is drawn without a fold. */
static btf_result fold_again(drawing *d, source *s, const variant *v, double pixels, const btf_log *log) {
    return !v->folded || !(s->plan.shader.fixed & BTF_FIXED_LIGHT) ? BTF_OK : fold(d, s, v, pixels, log);
}

/* Draws one side of the picture. Images are drawn with the whole material, whose directions alone they know. */
static btf_result draw_side(drawing *d, int used, const view_state *s, const variant *v, int width,
                            int height, const btf_log *log) {
    source *from = &d->sources[v->images ? 0 : used];
    const camera camera = {s->theta, s->phi, 30, s->zoom};
    const camera_frame frame = camera_get_frame(&camera);
    const gl_api *gl = d->gl;
    GLuint name = 0;
    variant read = *v;
    btf_result result = upload(d, from, log);
    if (!result) {
        result = fold_again(d, from, v, (double)width * height, log);
    }
    read.folded = v->folded && from->fold.gl;
    if (!result) {
        result = find_program(d, from, &read, log, &name);
    }
    if (!result) {
        result = btf_gl_bind(from->textures, name, UNIT_MATERIAL, NULL, log, NULL);
    }
    if (result) {
        return result;
    }
    if (read.folded) {
        btf_gl_fold_bind(from->fold.gl, name, UNIT_FOLDED, NULL);
    }
    float matrix[16], eye[3], light[3];
    make_matrix(&frame, width, height, matrix);
    vec_store(vec_mul(frame.back, frame.distance), eye);
    vec_store(vec_from_angles(s->light_theta, s->light_phi), light);
    gl->UseProgram(name);
    gl->ActiveTexture(GL_TEXTURE0 + UNIT_IMAGES);
    gl->BindTexture(GL_TEXTURE_2D_ARRAY, d->images.name);
    gl->Uniform1i(gl->GetUniformLocation(name, "view_images"), UNIT_IMAGES);
    gl->Uniform1i(gl->GetUniformLocation(name, "view_columns"), d->images.columns);
    gl->UniformMatrix4fv(gl->GetUniformLocation(name, "view_to_clip"), 1, GL_FALSE, matrix);
    gl->Uniform3f(gl->GetUniformLocation(name, "eye"), eye[0], eye[1], eye[2]);
    gl->Uniform3f(gl->GetUniformLocation(name, "light"), light[0], light[1], light[2]);
    gl->Uniform1f(gl->GetUniformLocation(name, "exposure"), v->stochastic ? 1 : (float)exp2(s->exposure));
    if (v->stochastic) {
        const int samples = history_samples(d->history);
        gl->Uniform1i(gl->GetUniformLocation(name, "view_history"), UNIT_HISTORY);
        gl->Uniform1i(gl->GetUniformLocation(name, "view_sample"), samples);
        gl->Uniform1i(gl->GetUniformLocation(name, "view_levels"), v->levels);
        gl->Uniform1f(gl->GetUniformLocation(name, "view_share"), 1.0f / (float)(samples + 1));
    }
    gl->Uniform1f(gl->GetUniformLocation(name, "repeat"), (float)d->repeat);
    mesh_buffers_draw(gl, &d->mesh);
    return gl->GetError() == GL_NO_ERROR ? BTF_OK : BTF_ERROR_INTERNAL;
}

static variant variant_of(const view_state *s) {
    return (variant){s->effects, s->interpolation,           s->filter,     s->math,
                     false,      s->levels && s->has_levels, s->stochastic, !s->stochastic};
}

btf_result drawing_fold_plan(drawing *d, int slot, const view_state *s, double pixels, const btf_log *log) {
    const variant v = variant_of(s);
    return fold(d, &d->sources[1 + slot], &v, pixels, log);
}

btf_result drawing_fold_whole(drawing *d, const float light[3], const view_state *s, double pixels,
                              const btf_log *log) {
    source *whole = &d->sources[0];
    const variant v = variant_of(s);
    btf_shader_options *still = &whole->plan.shader;
    still->fixed = light ? BTF_FIXED_LIGHT : 0u;
    if (light) {
        memcpy(still->fixed_light, light, sizeof still->fixed_light);
    }
    return fold(d, whole, &v, pixels, log);
}

size_t drawing_folded(const drawing *d) {
    const light_fold *f = &d->sources[d->used].fold;
    return f->gl ? btf_gl_fold_bytes(f->gl) : 0;
}

btf_result drawing_link_plan(drawing *d, int slot, const view_state *s, const btf_log *log) {
    variant v = variant_of(s);
    v.folded = d->sources[1 + slot].fold.gl != NULL;
    GLuint name;
    return find_program(d, &d->sources[1 + slot], &v, log, &name);
}

btf_result drawing_try_plan(drawing *d, int slot, const view_state *s, int width, int height,
                            const btf_log *log) {
    const gl_api *gl = d->gl;
    const variant v = variant_of(s);
    if (v.stochastic && !d->history && !(d->history = history_create(gl, log))) {
        return BTF_ERROR_INTERNAL;
    }
    gl->Viewport(0, 0, width, height);
    gl->Enable(GL_DEPTH_TEST);
    gl->Enable(GL_SCISSOR_TEST);
    gl->Scissor(width / 2, height / 2, 1, 1);
    gl->Clear(GL_DEPTH_BUFFER_BIT);
    const btf_result result = draw_side(d, 1 + slot, s, &v, width, height, log);
    gl->Disable(GL_SCISSOR_TEST);
    gl->Finish();
    return result;
}

/* Whether two states show the same picture left of the split, but for the exposure. */
static bool same_picture(const view_state *a, const view_state *b) {
    return a->theta == b->theta && a->phi == b->phi && a->light_theta == b->light_theta &&
           a->light_phi == b->light_phi && a->zoom == b->zoom && a->mesh == b->mesh &&
           a->effects == b->effects && a->interpolation == b->interpolation && a->filter == b->filter &&
           a->math == b->math && a->levels == b->levels && a->split_at == b->split_at &&
           (a->split == VIEW_SPLIT_OFF) == (b->split == VIEW_SPLIT_OFF);
}

/* Draws one more sample of each pixel left of the split, then shows the mean of all. */
static btf_result accumulate(drawing *d, const view_state *s, const variant *v, int width, int height,
                             const btf_log *log) {
    if (!d->history && !(d->history = history_create(d->gl, log))) {
        return BTF_ERROR_INTERNAL;
    }
    if (!same_picture(s, &d->accumulated) || d->accumulated_source != d->used) {
        history_clear(d->history);
    }
    d->accumulated = *s;
    d->accumulated_source = d->used;
    btf_result result = history_begin(d->history, width, height, UNIT_HISTORY, log);
    if (!result) {
        result = draw_side(d, d->used, s, v, width, height, log);
    }
    if (!result) {
        history_end(d->history, UNIT_HISTORY, (float)exp2(s->exposure));
    }
    return result;
}

int drawing_samples(const drawing *d) {
    return d->history ? history_samples(d->history) : 0;
}

btf_result drawing_draw(drawing *d, const view_state *s, int width, int height, const btf_log *log) {
    const gl_api *gl = d->gl;
    gl->Viewport(0, 0, width, height);
    gl->Disable(GL_SCISSOR_TEST);
    gl->ClearColor(0.1f, 0.1f, 0.11f, 1);
    gl->Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    if (!d->sources[d->used].material) {
        return BTF_OK;
    }
    const int split = s->split == VIEW_SPLIT_OFF ? width : (int)(s->split_at * width + 0.5);
    const variant left = variant_of(s);
    variant right = left;
    right.stochastic = false;
    right.images = s->split == VIEW_SPLIT_ORIGINAL && d->images.name;
    right.effects = 0;
    right.folded = false;
    gl->Enable(GL_DEPTH_TEST);
    gl->Enable(GL_SCISSOR_TEST);
    gl->Scissor(0, 0, split, height);
    btf_result result = left.stochastic ? accumulate(d, s, &left, width, height, log)
                                        : draw_side(d, d->used, s, &left, width, height, log);
    if (!result && split < width) {
        gl->Scissor(split, 0, 1, height);
        gl->ClearColor(1, 1, 1, 1);
        gl->Clear(GL_COLOR_BUFFER_BIT);
        gl->Scissor(split + 1, 0, width - split, height);
        result = draw_side(d, d->used, s, &right, width, height, log);
    }
    gl->Disable(GL_SCISSOR_TEST);
    return result;
}
