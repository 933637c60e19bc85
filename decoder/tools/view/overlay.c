/* Text over the picture: the panel is painted into a texture and drawn as one rectangle.
 *
 * SPDX-License-Identifier: MIT
 */
#include "overlay.h"

#include "decoder/toolkit/file.h"
#include "decoder/toolkit/font.h"
#include <stdlib.h>
#include <string.h>

enum { MARGIN = 4 };

struct overlay {
    const gl_api *gl;
    GLuint program, texture, array;
    GLint rectangle;
};

static const char vertex_text[] = "uniform vec4 rectangle;\n" /* left, bottom, right, top in clip space */
                                  "out vec2 at;\n"
                                  "void main() {\n"
                                  "    at = vec2(float(gl_VertexID & 1), float(gl_VertexID >> 1));\n"
                                  "    gl_Position = vec4(mix(rectangle.xy, rectangle.zw, at), 0.0, 1.0);\n"
                                  "    at.y = 1.0 - at.y;\n"
                                  "}\n";
static const char fragment_text[] =
    "uniform sampler2D panel;\n"
    "in vec2 at;\n"
    "out vec4 colour;\n"
    "void main() { float c = texture(panel, at).r; colour = vec4(c, c, c, 0.6 + 0.4 * c); }\n";

overlay *overlay_create(const gl_api *gl, const btf_log *log) {
    const char *vertex[] = {vertex_text, NULL}, *fragment[] = {fragment_text, NULL};
    overlay *o = calloc(1, sizeof *o);
    if (!o) {
        file_say(log, "out of memory for text");
        return NULL;
    }
    o->gl = gl;
    o->program = gl_api_program(gl, "#version 330 core\n", vertex, fragment, log);
    if (!o->program) {
        free(o);
        return NULL;
    }
    o->rectangle = gl->GetUniformLocation(o->program, "rectangle");
    gl->GenVertexArrays(1, &o->array);
    gl->GenTextures(1, &o->texture);
    gl->ActiveTexture(GL_TEXTURE0);
    gl->BindTexture(GL_TEXTURE_2D, o->texture);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    return o;
}

void overlay_destroy(overlay **o) {
    if (!o || !*o) {
        return;
    }
    (*o)->gl->DeleteProgram((*o)->program);
    (*o)->gl->DeleteTextures(1, &(*o)->texture);
    free(*o);
    *o = NULL;
}

static void measure(const char *text, int *columns, int *lines) {
    *columns = 0;
    *lines = 1;
    for (int length = 0; *text; text++) {
        length = *text == '\n' ? 0 : length + 1;
        *lines += *text == '\n';
        *columns = length > *columns ? length : *columns;
    }
}

void overlay_size(const char *text, int zoom, int *out_width, int *out_height) {
    int columns, lines;
    measure(text, &columns, &lines);
    *out_width = zoom * (columns * FONT_WIDTH + 2 * MARGIN);
    *out_height = zoom * (lines * FONT_HEIGHT + 2 * MARGIN);
}

void overlay_draw(overlay *o, const char *text, int x, int y, int zoom, int width, int height) {
    const gl_api *gl = o->gl;
    int panel_width, panel_height;
    overlay_size(text, 1, &panel_width, &panel_height);
    unsigned char *panel = calloc((size_t)panel_width * (size_t)panel_height, 1);
    if (!panel) {
        return;
    }
    for (int column = 0, line = 0; *text; text++) {
        if (*text == '\n') {
            column = 0;
            line++;
            continue;
        }
        for (int v = 0; v < FONT_HEIGHT; v++) {
            for (int u = 0; u < FONT_WIDTH; u++) {
                if (font_pixel(*text, u, v)) {
                    panel[(MARGIN + line * FONT_HEIGHT + v) * panel_width + MARGIN + column * FONT_WIDTH +
                          u] = 255;
                }
            }
        }
        column++;
    }
    gl->ActiveTexture(GL_TEXTURE0);
    gl->BindTexture(GL_TEXTURE_2D, o->texture);
    gl->PixelStorei(GL_UNPACK_ALIGNMENT, 1);
    gl->TexImage2D(GL_TEXTURE_2D, 0, GL_R8, panel_width, panel_height, 0, GL_RED, GL_UNSIGNED_BYTE, panel);
    free(panel);
    gl->UseProgram(o->program);
    gl->Uniform4f(o->rectangle, 2.0f * (float)x / (float)width - 1,
                  1 - 2.0f * (float)(y + zoom * panel_height) / (float)height,
                  2.0f * (float)(x + zoom * panel_width) / (float)width - 1,
                  1 - 2.0f * (float)y / (float)height);
    gl->Disable(GL_DEPTH_TEST);
    gl->Enable(GL_BLEND);
    gl->BlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    gl->BindVertexArray(o->array);
    gl->DrawArrays(GL_TRIANGLE_STRIP, 0, 4);
    gl->Disable(GL_BLEND);
}
