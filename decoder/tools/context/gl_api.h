/* The OpenGL functions that the tools and the tests use, as a table.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_CONTEXT_GL_API_H
#define OPENBTF_CONTEXT_GL_API_H

#include <GL/glcorearb.h>
#include <openbtf/gl.h>
#include <stdbool.h>

/* Functions that OpenGL 3.3 and OpenGL ES 3.0 both have. */
#define GL_API_FUNCTIONS(X)                                                                                \
    X(PFNGLACTIVETEXTUREPROC, ActiveTexture)                                                               \
    X(PFNGLATTACHSHADERPROC, AttachShader)                                                                 \
    X(PFNGLBINDBUFFERPROC, BindBuffer)                                                                     \
    X(PFNGLBINDFRAMEBUFFERPROC, BindFramebuffer)                                                           \
    X(PFNGLBINDSAMPLERPROC, BindSampler)                                                                   \
    X(PFNGLBINDTEXTUREPROC, BindTexture)                                                                   \
    X(PFNGLBINDVERTEXARRAYPROC, BindVertexArray)                                                           \
    X(PFNGLBLENDFUNCPROC, BlendFunc)                                                                       \
    X(PFNGLBUFFERDATAPROC, BufferData)                                                                     \
    X(PFNGLCHECKFRAMEBUFFERSTATUSPROC, CheckFramebufferStatus)                                             \
    X(PFNGLCLEARPROC, Clear)                                                                               \
    X(PFNGLCLEARCOLORPROC, ClearColor)                                                                     \
    X(PFNGLCOLORMASKPROC, ColorMask)                                                                       \
    X(PFNGLCOMPILESHADERPROC, CompileShader)                                                               \
    X(PFNGLCREATEPROGRAMPROC, CreateProgram)                                                               \
    X(PFNGLCREATESHADERPROC, CreateShader)                                                                 \
    X(PFNGLDELETEBUFFERSPROC, DeleteBuffers)                                                               \
    X(PFNGLDELETEPROGRAMPROC, DeleteProgram)                                                               \
    X(PFNGLDELETESAMPLERSPROC, DeleteSamplers)                                                             \
    X(PFNGLDELETESHADERPROC, DeleteShader)                                                                 \
    X(PFNGLDELETETEXTURESPROC, DeleteTextures)                                                             \
    X(PFNGLDISABLEPROC, Disable)                                                                           \
    X(PFNGLDRAWARRAYSPROC, DrawArrays)                                                                     \
    X(PFNGLDRAWELEMENTSPROC, DrawElements)                                                                 \
    X(PFNGLENABLEPROC, Enable)                                                                             \
    X(PFNGLENABLEVERTEXATTRIBARRAYPROC, EnableVertexAttribArray)                                           \
    X(PFNGLFINISHPROC, Finish)                                                                             \
    X(PFNGLFRAMEBUFFERTEXTURE2DPROC, FramebufferTexture2D)                                                 \
    X(PFNGLGENBUFFERSPROC, GenBuffers)                                                                     \
    X(PFNGLGENFRAMEBUFFERSPROC, GenFramebuffers)                                                           \
    X(PFNGLGENSAMPLERSPROC, GenSamplers)                                                                   \
    X(PFNGLGENTEXTURESPROC, GenTextures)                                                                   \
    X(PFNGLGENVERTEXARRAYSPROC, GenVertexArrays)                                                           \
    X(PFNGLGENERATEMIPMAPPROC, GenerateMipmap)                                                             \
    X(PFNGLGETERRORPROC, GetError)                                                                         \
    X(PFNGLGETINTEGERVPROC, GetIntegerv)                                                                   \
    X(PFNGLGETPROGRAMINFOLOGPROC, GetProgramInfoLog)                                                       \
    X(PFNGLGETPROGRAMIVPROC, GetProgramiv)                                                                 \
    X(PFNGLGETSHADERINFOLOGPROC, GetShaderInfoLog)                                                         \
    X(PFNGLGETSHADERIVPROC, GetShaderiv)                                                                   \
    X(PFNGLGETSTRINGPROC, GetString)                                                                       \
    X(PFNGLGETSTRINGIPROC, GetStringi)                                                                     \
    X(PFNGLGETTEXPARAMETERIVPROC, GetTexParameteriv)                                                       \
    X(PFNGLGETUNIFORMLOCATIONPROC, GetUniformLocation)                                                     \
    X(PFNGLISTEXTUREPROC, IsTexture)                                                                       \
    X(PFNGLLINKPROGRAMPROC, LinkProgram)                                                                   \
    X(PFNGLPIXELSTOREIPROC, PixelStorei)                                                                   \
    X(PFNGLREADPIXELSPROC, ReadPixels)                                                                     \
    X(PFNGLSCISSORPROC, Scissor)                                                                           \
    X(PFNGLSHADERSOURCEPROC, ShaderSource)                                                                 \
    X(PFNGLTEXIMAGE2DPROC, TexImage2D)                                                                     \
    X(PFNGLTEXIMAGE3DPROC, TexImage3D)                                                                     \
    X(PFNGLTEXPARAMETERIPROC, TexParameteri)                                                               \
    X(PFNGLTEXSUBIMAGE2DPROC, TexSubImage2D)                                                               \
    X(PFNGLTEXSUBIMAGE3DPROC, TexSubImage3D)                                                               \
    X(PFNGLUNIFORM1FPROC, Uniform1f)                                                                       \
    X(PFNGLUNIFORM1IPROC, Uniform1i)                                                                       \
    X(PFNGLUNIFORM2FPROC, Uniform2f)                                                                       \
    X(PFNGLUNIFORM3FPROC, Uniform3f)                                                                       \
    X(PFNGLUNIFORM4FPROC, Uniform4f)                                                                       \
    X(PFNGLUNIFORMMATRIX4FVPROC, UniformMatrix4fv)                                                         \
    X(PFNGLUSEPROGRAMPROC, UseProgram)                                                                     \
    X(PFNGLVERTEXATTRIBPOINTERPROC, VertexAttribPointer)                                                   \
    X(PFNGLVIEWPORTPROC, Viewport)

/* Functions that OpenGL ES 3.0 lacks: NULL where the context has none. */
#define GL_API_DESKTOP_FUNCTIONS(X)                                                                        \
    X(PFNGLGETTEXIMAGEPROC, GetTexImage)                                                                   \
    X(PFNGLGETTEXLEVELPARAMETERIVPROC, GetTexLevelParameteriv)

typedef struct gl_api {
#define GL_API_MEMBER(type, name) type name;
    GL_API_FUNCTIONS(GL_API_MEMBER)
    GL_API_DESKTOP_FUNCTIONS(GL_API_MEMBER)
#undef GL_API_MEMBER
} gl_api;

/* Fills the table. BTF_ERROR_UNSUPPORTED, naming the function on log, when one is missing. */
btf_result gl_api_load(gl_api *gl, btf_gl_get_proc_address get, void *user, const btf_log *log);

/* Compiles and links a vertex and a fragment shader, each of at most seven parts that are joined, and ended by a NULL;
 * version is the whole head, "#version ..." with its newline. Attribute locations are those of `layout`. 0 on failure,
 * with GL's words on log. */
GLuint gl_api_program(const gl_api *gl, const char *version, const char *const *vertex,
                      const char *const *fragment, const btf_log *log);

/* True when the context has an extension, e.g. "GL_ARB_gpu_shader5". */
bool gl_api_has(const gl_api *gl, const char *extension);

#endif
