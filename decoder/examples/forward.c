/* Example 2: a forward shader of your own with two BTF materials and an ordinary one in one program. Each
 * material gets a prefix, so that no names clash. Prints the picture as a PPM image: three boards in a row.
 *
 *     forward LEFT.btf.exr RIGHT.btf.exr > forward.ppm
 *
 * SPDX-License-Identifier: MIT
 */
#define GL_GLEXT_PROTOTYPES
#include <GL/osmesa.h>
#include <GL/glcorearb.h>
#include <openbtf/gl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 480, HEIGHT = 160 };

static const char version_text[] = "#version 450 core\n";

/* Three boards, each leaning back, with positions and a tangent frame in the world. */
static const char vertex_text[] = "out vec3 position;\n"
                                  "out vec2 uv;\n"
                                  "flat out int board;\n"
                                  "void main() {\n"
                                  "    board = gl_VertexID / 6;\n"
                                  "    int corner = int[6](0, 1, 2, 2, 1, 3)[gl_VertexID % 6];\n"
                                  "    uv = vec2(corner & 1, corner >> 1);\n"
                                  "    position = vec3(2.1 * (board - 1) + 2.0 * uv.x - 1.0, (2.0 * uv.y - "
                                  "1.0) * 0.8, (1.0 - 2.0 * uv.y) * 0.6);\n"
                                  "    gl_Position = vec4(position.x / 3.2, position.y / 1.1, position.z / "
                                  "10.0, 1.0 - position.z * 0.1);\n"
                                  "}\n";

/* Your shader: its own light, its own materials. */
static const char fragment_text[] =
    "in vec3 position;\n"
    "in vec2 uv;\n"
    "flat in int board;\n"
    "out vec4 colour;\n"
    "const vec3 lamp = vec3(-2.0, 3.0, 4.0), eye = vec3(0.0, 0.0, 10.0);\n"
    "vec3 varnish(vec2 uv, vec3 l, vec3 v) {\n"
    "    float squares = mod(floor(uv.x * 6.0) + floor(uv.y * 6.0), 2.0);\n"
    "    vec3 paint = mix(vec3(0.1, 0.3, 0.2), vec3(0.7, 0.7, 0.6), squares);\n"
    "    return paint * max(l.z, 0.0) + pow(max(normalize(l + v).z, 0.0), 40.0);\n"
    "}\n"
    "void main() {\n"
    "    vec3 tangent = vec3(1.0, 0.0, 0.0), bitangent = vec3(0.0, 0.8, -0.6), normal = vec3(0.0, 0.6, "
    "0.8);\n"
    "    mat3 to_tangent = transpose(mat3(tangent, bitangent, normal));\n"
    "    vec3 l = to_tangent * normalize(lamp - position), v = to_tangent * normalize(eye - position);\n"
    "    vec3 radiance = board == 0 ? left_evaluate(uv * 2.0, l, v)\n"
    "                  : board == 1 ? varnish(uv, l, v)\n"
    "                               : right_evaluate(uv * 2.0, l, v);\n"
    "    colour = vec4(pow(min(radiance, 1.0), vec3(1.0 / 2.2)), 1.0);\n"
    "}\n";

/* One BTF material of the program. */
typedef struct board {
    const char *path, *prefix;
    char *decoder;
    btf_gl *textures;
} board;

static void print_message(void *user, btf_log_level level, const char *message) {
    (void)user;
    (void)level;
    fprintf(stderr, "forward: %s\n", message);
}
static const btf_log log_stderr = {print_message, NULL};

static btf_gl_function find(void *user, const char *name) {
    (void)user;
    return (btf_gl_function)OSMesaGetProcAddress(name);
}

/* The decoder's text and the textures; the material itself is then no longer needed. */
static btf_result load(board *b) {
    const btf_shader_options shader = {
        .struct_size = sizeof shader, .filter = BTF_FILTER_BILINEAR, .prefix = b->prefix};
    const btf_gl_options gl = {sizeof gl, find, NULL, &shader};
    btf_material *material = NULL;
    btf_result result = btf_material_open(b->path, &log_stderr, &material);
    if (!result) {
        result = btf_shader_source(material, &shader, &log_stderr, &b->decoder);
    }
    if (!result) {
        result = btf_gl_upload(material, &gl, &log_stderr, &b->textures);
    }
    btf_material_close(&material);
    return result;
}

static GLuint compile(GLenum kind, GLsizei count, const char *const *parts) {
    GLuint shader = glCreateShader(kind);
    GLint ok = 0;
    char message[2000] = "";
    glShaderSource(shader, count, parts, NULL);
    glCompileShader(shader);
    glGetShaderiv(shader, GL_COMPILE_STATUS, &ok);
    glGetShaderInfoLog(shader, (GLsizei)sizeof message, NULL, message);
    if (!ok) {
        fprintf(stderr, "forward: %s\n", message);
    }
    return shader;
}

static GLuint make_program(const board boards[2]) {
    const char *vertex[] = {version_text, vertex_text};
    const char *fragment[] = {version_text, boards[0].decoder, boards[1].decoder, fragment_text};
    GLuint program = glCreateProgram();
    glAttachShader(program, compile(GL_VERTEX_SHADER, 2, vertex));
    glAttachShader(program, compile(GL_FRAGMENT_SHADER, 4, fragment));
    glLinkProgram(program);
    return program;
}

/* Each material's textures take the units after those of the one before. */
static btf_result draw(board boards[2]) {
    GLuint program = make_program(boards), array;
    uint32_t unit = 0, used = 0;
    for (int i = 0; i < 2; i++, unit += used) {
        btf_result result =
            btf_gl_bind(boards[i].textures, program, unit, boards[i].prefix, &log_stderr, &used);
        if (result) {
            return result;
        }
    }
    glGenVertexArrays(1, &array);
    glBindVertexArray(array);
    glViewport(0, 0, WIDTH, HEIGHT);
    glUseProgram(program);
    glDrawArrays(GL_TRIANGLES, 0, 18);
    glFinish();
    return glGetError() == GL_NO_ERROR ? BTF_OK : BTF_ERROR_INTERNAL;
}

int main(int argc, char **argv) {
    static unsigned char pixels[WIDTH * HEIGHT * 4];
    static const int attributes[] = {OSMESA_FORMAT,
                                     OSMESA_RGBA,
                                     OSMESA_PROFILE,
                                     OSMESA_CORE_PROFILE,
                                     OSMESA_CONTEXT_MAJOR_VERSION,
                                     4,
                                     OSMESA_CONTEXT_MINOR_VERSION,
                                     5,
                                     0};
    if (argc != 3) {
        fprintf(stderr, "usage: forward LEFT.btf.exr RIGHT.btf.exr > forward.ppm\n");
        return 1;
    }
    OSMesaContext context = OSMesaCreateContextAttribs(attributes, NULL);
    if (!context || !OSMesaMakeCurrent(context, pixels, GL_UNSIGNED_BYTE, WIDTH, HEIGHT)) {
        fprintf(stderr, "forward: OSMesa does not make an OpenGL 4.5 context\n");
        return 5;
    }
    board boards[2] = {{.path = argv[1], .prefix = "left"}, {.path = argv[2], .prefix = "right"}};
    btf_result result = load(&boards[0]);
    if (!result) {
        result = load(&boards[1]);
    }
    if (!result) {
        result = draw(boards);
    }
    if (!result) {
        printf("P6\n%d %d\n255\n", WIDTH, HEIGHT);
        for (int row = HEIGHT - 1; row >= 0; row--) { /* row 0 of a PPM is the top */
            for (int column = 0; column < WIDTH; column++) {
                fwrite(pixels + 4 * (row * WIDTH + column), 1, 3, stdout);
            }
        }
        if (fflush(stdout)) {
            result = BTF_ERROR_IO;
        }
    }
    for (int i = 0; i < 2; i++) {
        btf_gl_destroy(&boards[i].textures);
        btf_free(boards[i].decoder);
    }
    OSMesaDestroyContext(context);
    return btf_result_exit_code(result);
}
