/* Accumulated pictures: two textures of floats in turn. See history.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "history.h"

#include "decoder/toolkit/file.h"
#include <stdlib.h>

struct history {
    const gl_api *gl;
    GLuint means[2], depth, framebuffers[2], array, program;
    int width, height, samples;
    int now; /* which of the two holds the mean */
};

static const char vertex_text[] =
    "void main() {\n"
    "    gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);\n"
    "}\n";

/* Shows the mean; where nothing was drawn the window keeps its background. */
static const char fragment_text[] =
    "uniform sampler2D view_history;\n"
    "uniform float exposure;\n"
    "out vec4 colour;\n"
    "void main() {\n"
    "    vec4 mean = texelFetch(view_history, ivec2(gl_FragCoord.xy), 0);\n"
    "    if (mean.a == 0.0)\n"
    "        discard;\n"
    "    vec3 c = clamp(exposure * mean.rgb, 0.0, 1.0);\n"
    "    colour = vec4(mix(12.92 * c, 1.055 * pow(max(c, 0.0031308), vec3(1.0 / 2.4)) - 0.055,\n"
    "                      vec3(greaterThan(c, vec3(0.0031308)))), 1.0);\n"
    "}\n";

history *history_create(const gl_api *gl, const btf_log *log) {
    const char *vertex[] = {vertex_text, NULL}, *fragment[] = {fragment_text, NULL};
    history *h = calloc(1, sizeof *h);
    if (!h) {
        file_say(log, "out of memory for a history");
        return NULL;
    }
    h->gl = gl;
    h->program = gl_api_program(gl, "#version 330 core\n", vertex, fragment, log);
    if (!h->program) {
        free(h);
        return NULL;
    }
    gl->GenVertexArrays(1, &h->array);
    gl->GenFramebuffers(2, h->framebuffers);
    return h;
}

static void delete_textures(history *h) {
    const GLuint textures[3] = {h->means[0], h->means[1], h->depth};
    h->gl->DeleteTextures(3, textures);
    h->means[0] = h->means[1] = h->depth = 0;
}

void history_destroy(history **h) {
    if (!h || !*h) {
        return;
    }
    delete_textures(*h);
    (*h)->gl->DeleteProgram((*h)->program);
    free(*h); /* framebuffers and arrays go with the context */
    *h = NULL;
}

void history_clear(history *h) {
    h->samples = 0;
}

int history_samples(const history *h) {
    return h->samples;
}

static GLuint make_texture(const gl_api *gl, int unit, int width, int height, GLint format, GLenum of,
                           GLenum type) {
    GLuint texture = 0;
    gl->ActiveTexture(GL_TEXTURE0 + (GLenum)unit);
    gl->GenTextures(1, &texture);
    gl->BindTexture(GL_TEXTURE_2D, texture);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    gl->TexImage2D(GL_TEXTURE_2D, 0, format, width, height, 0, of, type, NULL);
    return texture;
}

static btf_result resize(history *h, int width, int height, int unit, const btf_log *log) {
    const gl_api *gl = h->gl;
    if (width == h->width && height == h->height) {
        return BTF_OK;
    }
    delete_textures(h);
    h->depth =
        make_texture(gl, unit, width, height, GL_DEPTH_COMPONENT24, GL_DEPTH_COMPONENT, GL_UNSIGNED_INT);
    h->width = width;
    h->height = height;
    h->samples = 0;
    for (int i = 0; i < 2; i++) {
        h->means[i] = make_texture(gl, unit, width, height, GL_RGBA32F, GL_RGBA, GL_FLOAT);
        gl->BindFramebuffer(GL_FRAMEBUFFER, h->framebuffers[i]);
        gl->FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, h->means[i], 0);
        gl->FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, h->depth, 0);
        if (gl->CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
            gl->BindFramebuffer(GL_FRAMEBUFFER, 0);
            h->width = 0;
            file_say(log, "GL refuses a framebuffer of %d x %d pixels of RGBA32F for the mean of frames",
                     width, height);
            return BTF_ERROR_UNSUPPORTED;
        }
    }
    return BTF_OK;
}

btf_result history_begin(history *h, int width, int height, int unit, const btf_log *log) {
    const btf_result result = resize(h, width, height, unit, log);
    if (result) {
        return result;
    }
    h->now = 1 - h->now;
    h->gl->BindFramebuffer(GL_FRAMEBUFFER, h->framebuffers[h->now]);
    h->gl->ActiveTexture(GL_TEXTURE0 + (GLenum)unit);
    h->gl->BindTexture(GL_TEXTURE_2D, h->means[1 - h->now]);
    h->gl->ClearColor(0, 0, 0, 0);
    h->gl->Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    return BTF_OK;
}

void history_end(history *h, int unit, float exposure) {
    const gl_api *gl = h->gl;
    h->samples++;
    gl->BindFramebuffer(GL_FRAMEBUFFER, 0);
    gl->ActiveTexture(GL_TEXTURE0 + (GLenum)unit);
    gl->BindTexture(GL_TEXTURE_2D, h->means[h->now]);
    gl->UseProgram(h->program);
    gl->Uniform1i(gl->GetUniformLocation(h->program, "view_history"), unit);
    gl->Uniform1f(gl->GetUniformLocation(h->program, "exposure"), exposure);
    gl->BindVertexArray(h->array);
    gl->Disable(GL_DEPTH_TEST);
    gl->DrawArrays(GL_TRIANGLES, 0, 3);
    gl->Enable(GL_DEPTH_TEST);
}
