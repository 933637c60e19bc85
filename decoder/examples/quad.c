/* OpenBTF example: a material on a quad, drawn without a window and written as a PPM picture.
 *
 *     quad MATERIAL.btf.exr [VIEW_THETA LIGHT_THETA] > quad.ppm
 *
 * draw() uses the library: open, assemble, upload, bind, draw. The rest is EGL and GL as any program has
 * them.
 *
 * SPDX-License-Identifier: MIT
 */
#include <openbtf/gl.h>

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GLES3/gl3.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { SIZE = 256 };

static const char vertex_text[] = "#version 300 es\n"
                                  "out highp vec2 uv;\n"
                                  "void main() {\n"
                                  "    uv = vec2(gl_VertexID & 1, gl_VertexID >> 1);\n"
                                  "    gl_Position = vec4(2.0 * uv - 1.0, 0.0, 1.0);\n"
                                  "}\n";
static const char version_text[] = "#version 300 es\n";
static const char fragment_text[] = "in highp vec2 uv;\n"
                                    "uniform highp vec3 light, view;\n"
                                    "out highp vec4 colour;\n"
                                    "void main() {\n"
                                    "    highp vec3 radiance = btf_evaluate(uv, light, view);\n"
                                    "    colour = vec4(pow(min(radiance, 1.0), vec3(1.0 / 2.2)), 1.0);\n"
                                    "}\n";

static void print_message(void *user, btf_log_level level, const char *message) {
    (void)user;
    (void)level;
    fprintf(stderr, "quad: %s\n", message);
}
static const btf_log log_stderr = {print_message, NULL};

static btf_gl_function find(void *user, const char *name) {
    (void)user;
    return (btf_gl_function)eglGetProcAddress(name);
}

/* Makes an OpenGL ES 3 context current that needs no window and no surface. */
static int make_context(void) {
    EGLDisplay display = eglGetPlatformDisplay(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, NULL);
    const EGLint config_attributes[] = {EGL_SURFACE_TYPE, 0, EGL_RENDERABLE_TYPE, EGL_OPENGL_ES3_BIT,
                                        EGL_NONE};
    const EGLint context_attributes[] = {EGL_CONTEXT_MAJOR_VERSION, 3, EGL_NONE};
    EGLConfig config;
    EGLint count = 0;
    if (!eglInitialize(display, NULL, NULL) ||
        !eglChooseConfig(display, config_attributes, &config, 1, &count) || count < 1) {
        return 0;
    }
    EGLContext context = eglCreateContext(display, config, EGL_NO_CONTEXT, context_attributes);
    return eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context);
}

static GLuint make_program(const char *decoder) {
    const char *fragment_parts[] = {version_text, decoder, fragment_text}, *vertex_part = vertex_text;
    GLuint program = glCreateProgram(), vertex = glCreateShader(GL_VERTEX_SHADER),
           fragment = glCreateShader(GL_FRAGMENT_SHADER);
    glShaderSource(vertex, 1, &vertex_part, NULL);
    glShaderSource(fragment, 3, fragment_parts, NULL);
    glCompileShader(vertex);
    glCompileShader(fragment);
    glAttachShader(program, vertex);
    glAttachShader(program, fragment);
    glLinkProgram(program);
    return program;
}

static void make_framebuffer(void) {
    GLuint texture, framebuffer;
    glGenTextures(1, &texture);
    glBindTexture(GL_TEXTURE_2D, texture);
    glTexStorage2D(GL_TEXTURE_2D, 1, GL_RGBA8, SIZE, SIZE);
    glGenFramebuffers(1, &framebuffer);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture, 0);
    glViewport(0, 0, SIZE, SIZE);
}

/* Draws the material of a file, seen and lit from these angles (radians from the normal), into
 * pixels[SIZE][SIZE][4]. */
static btf_result draw(const char *path, double view, double light, unsigned char *pixels) {
    btf_material *material = NULL;
    btf_gl *gl = NULL;
    char *decoder = NULL;
    const btf_gl_options options = {sizeof options, find, NULL, NULL};
    GLuint program = 0;
    btf_result result = btf_material_open(path, &log_stderr, &material);
    if (!result) {
        result = btf_shader_source(material, NULL, &log_stderr, &decoder);
    }
    if (!result) {
        result = btf_gl_upload(material, &options, &log_stderr, &gl);
    }
    if (!result) {
        result = btf_gl_bind(gl, program = make_program(decoder), 0, NULL, &log_stderr, NULL);
    }
    if (!result) {
        glUseProgram(program);
        glUniform3f(glGetUniformLocation(program, "view"), 0, (float)sin(view), (float)cos(view));
        glUniform3f(glGetUniformLocation(program, "light"), (float)sin(light), 0, (float)cos(light));
        glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
        glReadPixels(0, 0, SIZE, SIZE, GL_RGBA, GL_UNSIGNED_BYTE, pixels);
    }
    glDeleteProgram(program);
    btf_gl_destroy(&gl);
    btf_free(decoder);
    btf_material_close(&material);
    return result;
}

int main(int argc, char **argv) {
    static unsigned char pixels[SIZE * SIZE * 4];
    if (argc != 2 && argc != 4) {
        fprintf(stderr, "usage: quad MATERIAL.btf.exr [VIEW_THETA LIGHT_THETA] > quad.ppm\n");
        return 1;
    }
    if (!make_context()) {
        fprintf(stderr, "quad: EGL does not make an OpenGL ES 3 context without a surface\n");
        return 5;
    }
    make_framebuffer();
    const double degree = 3.14159265358979 / 180;
    btf_result result = draw(argv[1], argc == 4 ? atof(argv[2]) * degree : 0,
                             argc == 4 ? atof(argv[3]) * degree : 0.5, pixels);
    if (result != BTF_OK) {
        return btf_result_exit_code(result);
    }
    printf("P6\n%d %d\n255\n", SIZE, SIZE);
    for (int row = SIZE - 1; row >= 0; --row) { /* row 0 of a PPM is the top */
        for (int column = 0; column < SIZE; ++column) {
            fwrite(pixels + 4 * (row * SIZE + column), 1, 3, stdout);
        }
    }
    return glGetError() == GL_NO_ERROR && fflush(stdout) == 0 ? 0 : 4;
}
