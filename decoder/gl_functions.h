/* The part of OpenGL 3.3 / OpenGL ES 3.0 that the library uses: names, numbers, and a table filled through
 * the caller's get_proc_address. No GL header is needed and nothing is linked.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_GL_FUNCTIONS_H
#define OPENBTF_GL_FUNCTIONS_H

#include <openbtf/gl.h>

#pragma GCC visibility push(hidden)

#if defined(_WIN32)
#define BTFI_GL_CALL __stdcall
#else
#define BTFI_GL_CALL
#endif

/* name, result, parameters */
#define BTFI_GL_FUNCTIONS(X)                                                                               \
    X(ActiveTexture, void, (uint32_t unit))                                                                \
    X(AttachShader, void, (uint32_t program, uint32_t shader))                                             \
    X(BindBuffer, void, (uint32_t target, uint32_t buffer))                                                \
    X(BindFramebuffer, void, (uint32_t target, uint32_t framebuffer))                                      \
    X(BindSampler, void, (uint32_t unit, uint32_t sampler))                                                \
    X(BindTexture, void, (uint32_t target, uint32_t texture))                                              \
    X(BindVertexArray, void, (uint32_t array))                                                             \
    X(CheckFramebufferStatus, uint32_t, (uint32_t target))                                                 \
    X(ColorMask, void, (uint8_t r, uint8_t g, uint8_t b, uint8_t a))                                       \
    X(CompileShader, void, (uint32_t shader))                                                              \
    X(CreateProgram, uint32_t, (void))                                                                     \
    X(CreateShader, uint32_t, (uint32_t kind))                                                             \
    X(DeleteFramebuffers, void, (int32_t count, const uint32_t *names))                                    \
    X(DeleteProgram, void, (uint32_t program))                                                             \
    X(DeleteShader, void, (uint32_t shader))                                                               \
    X(DeleteTextures, void, (int32_t count, const uint32_t *names))                                        \
    X(DeleteVertexArrays, void, (int32_t count, const uint32_t *names))                                    \
    X(Disable, void, (uint32_t capability))                                                                \
    X(DrawArrays, void, (uint32_t mode, int32_t first, int32_t count))                                     \
    X(Enable, void, (uint32_t capability))                                                                 \
    X(FramebufferTexture2D, void,                                                                          \
      (uint32_t target, uint32_t attachment, uint32_t texture_target, uint32_t texture, int32_t level))    \
    X(FramebufferTextureLayer, void,                                                                       \
      (uint32_t target, uint32_t attachment, uint32_t texture, int32_t level, int32_t layer))              \
    X(GenFramebuffers, void, (int32_t count, uint32_t * names))                                            \
    X(GenTextures, void, (int32_t count, uint32_t * names))                                                \
    X(GenVertexArrays, void, (int32_t count, uint32_t * names))                                            \
    X(GetBooleanv, void, (uint32_t name, uint8_t * values))                                                \
    X(GetError, uint32_t, (void))                                                                          \
    X(GetIntegerv, void, (uint32_t name, int32_t * values))                                                \
    X(GetProgramiv, void, (uint32_t program, uint32_t name, int32_t * value))                              \
    X(GetShaderInfoLog, void, (uint32_t shader, int32_t size, int32_t * length, char *text))               \
    X(GetShaderiv, void, (uint32_t shader, uint32_t name, int32_t * value))                                \
    X(GetString, const unsigned char *, (uint32_t name))                                                   \
    X(GetUniformLocation, int32_t, (uint32_t program, const char *name))                                   \
    X(IsEnabled, uint8_t, (uint32_t capability))                                                           \
    X(LinkProgram, void, (uint32_t program))                                                               \
    X(PixelStorei, void, (uint32_t name, int32_t value))                                                   \
    X(ReadPixels, void,                                                                                    \
      (int32_t x, int32_t y, int32_t width, int32_t height, uint32_t format, uint32_t type, void *data))   \
    X(ShaderSource, void,                                                                                  \
      (uint32_t shader, int32_t count, const char *const *text, const int32_t *length))                    \
    X(TexImage2D, void,                                                                                    \
      (uint32_t target, int32_t level, int32_t internal, int32_t width, int32_t height, int32_t border,    \
       uint32_t format, uint32_t type, const void *data))                                                  \
    X(TexImage3D, void,                                                                                    \
      (uint32_t target, int32_t level, int32_t internal, int32_t width, int32_t height, int32_t depth,     \
       int32_t border, uint32_t format, uint32_t type, const void *data))                                  \
    X(TexParameteri, void, (uint32_t target, uint32_t name, int32_t value))                                \
    X(Uniform1i, void, (int32_t location, int32_t value))                                                  \
    X(Uniform3f, void, (int32_t location, float x, float y, float z))                                      \
    X(UseProgram, void, (uint32_t program))                                                                \
    X(Viewport, void, (int32_t x, int32_t y, int32_t width, int32_t height))

/* Functions that OpenGL ES lacks, and that core contexts lack too. */
#define BTFI_GL_DESKTOP_FUNCTIONS(X) X(PolygonMode, void, (uint32_t face, uint32_t mode))
#define BTFI_GL_COMPATIBILITY_FUNCTIONS(X)                                                                 \
    X(GetFloatv, void, (uint32_t name, float *values))                                                     \
    X(PixelTransferf, void, (uint32_t name, float value))

/* Functions that set one of several draw buffers or viewports. Each is NULL where the context has no state for each
 * of them: then the function without an index sets the one there is. */
#define BTFI_GL_BUFFER_FUNCTIONS(X)                                                                        \
    X(ColorMaski, void, (uint32_t buffer, uint8_t r, uint8_t g, uint8_t b, uint8_t a))
#define BTFI_GL_VIEWPORT_FUNCTIONS(X)                                                                      \
    X(Disablei, void, (uint32_t capability, uint32_t index))                                               \
    X(Enablei, void, (uint32_t capability, uint32_t index))                                                \
    X(GetFloati_v, void, (uint32_t name, uint32_t index, float *values))                                   \
    X(ViewportIndexedf, void, (uint32_t index, float x, float y, float width, float height))

typedef struct btfi_gl_functions {
#define BTFI_GL_MEMBER(name, result, parameters) result(BTFI_GL_CALL *name) parameters;
    BTFI_GL_FUNCTIONS(BTFI_GL_MEMBER)
    BTFI_GL_DESKTOP_FUNCTIONS(BTFI_GL_MEMBER)       /* NULL in OpenGL ES */
    BTFI_GL_COMPATIBILITY_FUNCTIONS(BTFI_GL_MEMBER) /* NULL where is_compatibility is 0 */
    BTFI_GL_BUFFER_FUNCTIONS(BTFI_GL_MEMBER)        /* NULL in OpenGL ES below 3.2 */
    BTFI_GL_VIEWPORT_FUNCTIONS(BTFI_GL_MEMBER)      /* NULL in OpenGL ES, and in OpenGL below 4.1 */
#undef BTFI_GL_MEMBER
    int is_es, is_compatibility, major, minor; /* of the context */
} btfi_gl_functions;

/* Numbers of the OpenGL registry. */
enum {
    GL_NO_ERROR = 0,
    GL_OUT_OF_MEMORY = 0x0505,
    GL_TRIANGLES = 0x0004,
    GL_FRONT = 0x0404,
    GL_BACK = 0x0405,
    GL_FRONT_AND_BACK = 0x0408,
    GL_POLYGON_MODE = 0x0B40,
    GL_POLYGON_STIPPLE = 0x0B42,
    GL_CULL_FACE = 0x0B44,
    GL_DEPTH_TEST = 0x0B71,
    GL_STENCIL_TEST = 0x0B90,
    GL_VIEWPORT = 0x0BA2,
    GL_ALPHA_TEST = 0x0BC0,
    GL_COLOR_LOGIC_OP = 0x0BF2,
    GL_SCISSOR_TEST = 0x0C11,
    GL_COLOR_WRITEMASK = 0x0C23,
    GL_UNPACK_SWAP_BYTES = 0x0CF0,
    GL_UNPACK_ROW_LENGTH = 0x0CF2,
    GL_UNPACK_SKIP_ROWS = 0x0CF3,
    GL_UNPACK_SKIP_PIXELS = 0x0CF4,
    GL_UNPACK_ALIGNMENT = 0x0CF5,
    GL_PACK_SWAP_BYTES = 0x0D00,
    GL_PACK_ROW_LENGTH = 0x0D02,
    GL_PACK_SKIP_ROWS = 0x0D03,
    GL_PACK_SKIP_PIXELS = 0x0D04,
    GL_MAP_COLOR = 0x0D10,
    GL_RED_SCALE = 0x0D14,
    GL_RED_BIAS = 0x0D15,
    GL_GREEN_SCALE = 0x0D18,
    GL_GREEN_BIAS = 0x0D19,
    GL_BLUE_SCALE = 0x0D1A,
    GL_BLUE_BIAS = 0x0D1B,
    GL_ALPHA_SCALE = 0x0D1C,
    GL_ALPHA_BIAS = 0x0D1D,
    GL_MAX_TEXTURE_SIZE = 0x0D33,
    GL_TEXTURE_2D = 0x0DE1,
    GL_BYTE = 0x1400,
    GL_UNSIGNED_BYTE = 0x1401,
    GL_UNSIGNED_SHORT = 0x1403,
    GL_UNSIGNED_INT = 0x1405,
    GL_FLOAT = 0x1406,
    GL_HALF_FLOAT = 0x140B,
    GL_RED = 0x1903,
    GL_RGBA = 0x1908,
    GL_FILL = 0x1B02,
    GL_VERSION = 0x1F02,
    GL_EXTENSIONS = 0x1F03,
    GL_NEAREST = 0x2600,
    GL_NEAREST_MIPMAP_NEAREST = 0x2700,
    GL_TEXTURE_MAG_FILTER = 0x2800,
    GL_TEXTURE_MIN_FILTER = 0x2801,
    GL_TEXTURE_WRAP_S = 0x2802,
    GL_TEXTURE_WRAP_T = 0x2803,
    GL_CLIP_DISTANCE0 = 0x3000,
    GL_CONVOLUTION_1D = 0x8010,
    GL_CONVOLUTION_2D = 0x8011,
    GL_SEPARABLE_2D = 0x8012,
    GL_POST_CONVOLUTION_RED_SCALE = 0x801C,
    GL_POST_CONVOLUTION_RED_BIAS = 0x8020,
    GL_HISTOGRAM = 0x8024,
    GL_MINMAX = 0x802E,
    GL_UNPACK_SKIP_IMAGES = 0x806D,
    GL_UNPACK_IMAGE_HEIGHT = 0x806E,
    GL_TEXTURE_BINDING_2D = 0x8069,
    GL_SAMPLE_ALPHA_TO_COVERAGE = 0x809E,
    GL_SAMPLE_COVERAGE = 0x80A0,
    GL_POST_COLOR_MATRIX_RED_SCALE = 0x80B4,
    GL_POST_COLOR_MATRIX_RED_BIAS = 0x80B8,
    GL_COLOR_TABLE = 0x80D0,
    GL_POST_CONVOLUTION_COLOR_TABLE = 0x80D1,
    GL_POST_COLOR_MATRIX_COLOR_TABLE = 0x80D2,
    GL_CLAMP_TO_EDGE = 0x812F,
    GL_TEXTURE_BASE_LEVEL = 0x813C,
    GL_TEXTURE_MAX_LEVEL = 0x813D,
    GL_MAJOR_VERSION = 0x821B,
    GL_MINOR_VERSION = 0x821C,
    GL_RG_INTEGER = 0x8228,
    GL_R32F = 0x822E,
    GL_R8UI = 0x8232,
    GL_RG8UI = 0x8238,
    GL_TEXTURE0 = 0x84C0,
    GL_ACTIVE_TEXTURE = 0x84E0,
    GL_SAMPLER_BINDING = 0x8919,
    GL_VERTEX_ARRAY_BINDING = 0x85B5,
    GL_RGBA32F = 0x8814,
    GL_RGBA16F = 0x881A,
    GL_PIXEL_PACK_BUFFER = 0x88EB,
    GL_PIXEL_UNPACK_BUFFER = 0x88EC,
    GL_PIXEL_PACK_BUFFER_BINDING = 0x88ED,
    GL_PIXEL_UNPACK_BUFFER_BINDING = 0x88EF,
    GL_MAX_ARRAY_TEXTURE_LAYERS = 0x88FF,
    GL_FRAGMENT_SHADER = 0x8B30,
    GL_VERTEX_SHADER = 0x8B31,
    GL_DELETE_STATUS = 0x8B80,
    GL_COMPILE_STATUS = 0x8B81,
    GL_LINK_STATUS = 0x8B82,
    GL_CURRENT_PROGRAM = 0x8B8D,
    GL_TEXTURE_2D_ARRAY = 0x8C1A,
    GL_TEXTURE_BINDING_2D_ARRAY = 0x8C1D,
    GL_RASTERIZER_DISCARD = 0x8C89,
    GL_READ_FRAMEBUFFER = 0x8CA8,
    GL_DRAW_FRAMEBUFFER = 0x8CA9,
    GL_DRAW_FRAMEBUFFER_BINDING = 0x8CA6,
    GL_READ_FRAMEBUFFER_BINDING = 0x8CAA,
    GL_FRAMEBUFFER_COMPLETE = 0x8CD5,
    GL_COLOR_ATTACHMENT0 = 0x8CE0,
    GL_RGBA32UI = 0x8D70,
    GL_RGBA16UI = 0x8D76,
    GL_RGBA8UI = 0x8D7C,
    GL_RGBA8I = 0x8D8E,
    GL_RED_INTEGER = 0x8D94,
    GL_RGBA_INTEGER = 0x8D99,
    GL_CONTEXT_PROFILE_MASK = 0x9126,
    GL_CONTEXT_CORE_PROFILE_BIT = 1,
};

/* Fills the table and the version. Errors, on log: BTF_ERROR_USAGE (no get_proc_address),
 * BTF_ERROR_UNSUPPORTED (a function is missing; GL below 3.3, GL ES below 3.0; no context). */
btf_result btfi_gl_load(const btf_gl_options *options, const btf_log *log, btfi_gl_functions *out_gl);

/* How GL reads texels from memory, and what a compatibility context does to them on the way. */
enum { BTFI_UNPACK_COUNT = 7, BTFI_TRANSFER_COUNT = 25, BTFI_IMAGING_COUNT = 8 };
typedef struct btfi_gl_unpack {
    int32_t buffer, value[BTFI_UNPACK_COUNT];
    int transfers, imagings; /* how many of the following exist in this context */
    float transfer[BTFI_TRANSFER_COUNT];
    uint8_t imaging[BTFI_IMAGING_COUNT];
} btfi_gl_unpack;

/* Keeps the state in *out and sets tight packing from the caller's memory, texels taken as they are; puts
 * it back. Both leave no GL error behind; the first takes those off the queue that were there. */
void btfi_gl_save_unpack(const btfi_gl_functions *gl, btfi_gl_unpack *out);
void btfi_gl_restore_unpack(const btfi_gl_functions *gl, const btfi_gl_unpack *saved);

/* Takes GL errors off the queue; returns the first, GL_NO_ERROR when there was none. */
uint32_t btfi_gl_errors(const btfi_gl_functions *gl);

#pragma GCC visibility pop

#endif
