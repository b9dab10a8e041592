#pragma once

// The functions of OpenGL that our passes call, loaded from the context: nothing links a GL library.

#include <map>
#include <string>

#include <GL/glcorearb.h>

namespace surflux::gl {

// X(type, name): the member `name` is the function gl<name>.
#define SURFLUX_GL_FUNCTIONS(X)                                \
    X(PFNGLGETSTRINGPROC, GetString)                           \
    X(PFNGLGETINTEGERVPROC, GetIntegerv)                       \
    X(PFNGLGETERRORPROC, GetError)                             \
    X(PFNGLENABLEPROC, Enable)                                 \
    X(PFNGLDISABLEPROC, Disable)                               \
    X(PFNGLDEPTHFUNCPROC, DepthFunc)                           \
    X(PFNGLDEPTHMASKPROC, DepthMask)                           \
    X(PFNGLBLENDFUNCPROC, BlendFunc)                           \
    X(PFNGLVIEWPORTPROC, Viewport)                             \
    X(PFNGLPIXELSTOREIPROC, PixelStorei)                       \
    X(PFNGLREADBUFFERPROC, ReadBuffer)                         \
    X(PFNGLREADPIXELSPROC, ReadPixels)                         \
    X(PFNGLCLEARBUFFERFVPROC, ClearBufferfv)                   \
    X(PFNGLCLEARBUFFERIVPROC, ClearBufferiv)                   \
    X(PFNGLDRAWARRAYSPROC, DrawArrays)                         \
    X(PFNGLDISPATCHCOMPUTEPROC, DispatchCompute)               \
    X(PFNGLMEMORYBARRIERPROC, MemoryBarrier)                   \
    X(PFNGLCREATESHADERPROC, CreateShader)                     \
    X(PFNGLSHADERSOURCEPROC, ShaderSource)                     \
    X(PFNGLCOMPILESHADERPROC, CompileShader)                   \
    X(PFNGLGETSHADERIVPROC, GetShaderiv)                       \
    X(PFNGLGETSHADERINFOLOGPROC, GetShaderInfoLog)             \
    X(PFNGLDELETESHADERPROC, DeleteShader)                     \
    X(PFNGLCREATEPROGRAMPROC, CreateProgram)                   \
    X(PFNGLATTACHSHADERPROC, AttachShader)                     \
    X(PFNGLLINKPROGRAMPROC, LinkProgram)                       \
    X(PFNGLGETPROGRAMIVPROC, GetProgramiv)                     \
    X(PFNGLGETPROGRAMINFOLOGPROC, GetProgramInfoLog)           \
    X(PFNGLDELETEPROGRAMPROC, DeleteProgram)                   \
    X(PFNGLUSEPROGRAMPROC, UseProgram)                         \
    X(PFNGLGETUNIFORMLOCATIONPROC, GetUniformLocation)         \
    X(PFNGLUNIFORM1FPROC, Uniform1f)                           \
    X(PFNGLUNIFORM2FPROC, Uniform2f)                           \
    X(PFNGLUNIFORM4FPROC, Uniform4f)                           \
    X(PFNGLUNIFORM2IPROC, Uniform2i)                           \
    X(PFNGLGENVERTEXARRAYSPROC, GenVertexArrays)               \
    X(PFNGLBINDVERTEXARRAYPROC, BindVertexArray)               \
    X(PFNGLGENBUFFERSPROC, GenBuffers)                         \
    X(PFNGLBINDBUFFERPROC, BindBuffer)                         \
    X(PFNGLBINDBUFFERBASEPROC, BindBufferBase)                 \
    X(PFNGLBUFFERDATAPROC, BufferData)                         \
    X(PFNGLGETBUFFERSUBDATAPROC, GetBufferSubData)             \
    X(PFNGLDELETEBUFFERSPROC, DeleteBuffers)                   \
    X(PFNGLGENTEXTURESPROC, GenTextures)                       \
    X(PFNGLBINDTEXTUREPROC, BindTexture)                       \
    X(PFNGLACTIVETEXTUREPROC, ActiveTexture)                   \
    X(PFNGLTEXSTORAGE2DPROC, TexStorage2D)                     \
    X(PFNGLTEXSUBIMAGE2DPROC, TexSubImage2D)                   \
    X(PFNGLTEXPARAMETERIPROC, TexParameteri)                   \
    X(PFNGLDELETETEXTURESPROC, DeleteTextures)                 \
    X(PFNGLGENFRAMEBUFFERSPROC, GenFramebuffers)               \
    X(PFNGLBINDFRAMEBUFFERPROC, BindFramebuffer)               \
    X(PFNGLFRAMEBUFFERTEXTUREPROC, FramebufferTexture)         \
    X(PFNGLDRAWBUFFERSPROC, DrawBuffers)                       \
    X(PFNGLCHECKFRAMEBUFFERSTATUSPROC, CheckFramebufferStatus) \
    X(PFNGLDELETEFRAMEBUFFERSPROC, DeleteFramebuffers)

struct Functions {
#define SURFLUX_GL_MEMBER(type, name) type name = nullptr;
    SURFLUX_GL_FUNCTIONS(SURFLUX_GL_MEMBER)
#undef SURFLUX_GL_MEMBER
    mutable std::map<std::string, GLuint> programs;  // that were linked, by their text (objects.h)
};

}  // namespace surflux::gl
