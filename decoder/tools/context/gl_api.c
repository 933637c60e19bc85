/* Loading OpenGL functions, compiling programs.
 *
 * SPDX-License-Identifier: MIT
 */
#include "gl_api.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

static void log_error(const btf_log *log, const char *format, ...) __attribute__((format(printf, 2, 3)));
static void log_error(const btf_log *log, const char *format, ...) {
    char text[2000];
    va_list arguments;
    if (!log || !log->callback) {
        return;
    }
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    log->callback(log->user, BTF_LOG_ERROR, text);
}

btf_result gl_api_load(gl_api *gl, btf_gl_get_proc_address get, void *user, const btf_log *log) {
#define GL_API_LOAD(type, function)                                                                        \
    gl->function = (type)get(user, "gl" #function);                                                        \
    if (!gl->function) {                                                                                   \
        log_error(log, "the context lacks the function gl" #function);                                     \
        return BTF_ERROR_UNSUPPORTED;                                                                      \
    }
    GL_API_FUNCTIONS(GL_API_LOAD)
#undef GL_API_LOAD
#define GL_API_LOAD(type, function) gl->function = (type)get(user, "gl" #function);
    GL_API_DESKTOP_FUNCTIONS(GL_API_LOAD)
#undef GL_API_LOAD
    return BTF_OK;
}

static GLuint compile(const gl_api *gl, GLenum kind, const char *version, const char *const *parts,
                      const btf_log *log) {
    enum { MOST = 8 };
    const char *all[MOST] = {version};
    GLsizei count = 1;
    while (*parts && count < MOST) {
        all[count++] = *parts++;
    }
    if (*parts) {
        log_error(log, "GLSL of more than %d parts", MOST - 1);
        return 0;
    }
    GLuint shader = gl->CreateShader(kind);
    GLint ok = 0;
    gl->ShaderSource(shader, count, all, NULL);
    gl->CompileShader(shader);
    gl->GetShaderiv(shader, GL_COMPILE_STATUS, &ok);
    if (!ok) {
        char message[1900] = "";
        gl->GetShaderInfoLog(shader, (GLsizei)sizeof message, NULL, message);
        log_error(log, "GLSL does not compile: %s", message);
        gl->DeleteShader(shader);
        return 0;
    }
    return shader;
}

GLuint gl_api_program(const gl_api *gl, const char *version, const char *const *vertex,
                      const char *const *fragment, const btf_log *log) {
    GLuint vertex_shader = compile(gl, GL_VERTEX_SHADER, version, vertex, log);
    GLuint fragment_shader = vertex_shader ? compile(gl, GL_FRAGMENT_SHADER, version, fragment, log) : 0;
    GLuint program = 0;
    if (fragment_shader) {
        GLint ok = 0;
        program = gl->CreateProgram();
        gl->AttachShader(program, vertex_shader);
        gl->AttachShader(program, fragment_shader);
        gl->LinkProgram(program);
        gl->GetProgramiv(program, GL_LINK_STATUS, &ok);
        if (!ok) {
            char message[1900] = "";
            gl->GetProgramInfoLog(program, (GLsizei)sizeof message, NULL, message);
            log_error(log, "GLSL does not link: %s", message);
            gl->DeleteProgram(program);
            program = 0;
        }
        gl->DeleteShader(fragment_shader);
    }
    if (vertex_shader) {
        gl->DeleteShader(vertex_shader);
    }
    return program;
}

bool gl_api_has(const gl_api *gl, const char *extension) {
    GLint count = 0;
    gl->GetIntegerv(GL_NUM_EXTENSIONS, &count);
    for (GLint i = 0; i < count; i++) {
        if (!strcmp((const char *)gl->GetStringi(GL_EXTENSIONS, (GLuint)i), extension)) {
            return true;
        }
    }
    return false;
}
