#include "surflux/gl/objects.h"

#include <initializer_list>
#include <string>

#include "surflux/core/error.h"

namespace surflux::gl {

namespace {

const char* name_of(GLenum kind) {
    return kind == GL_VERTEX_SHADER ? "vertex" : kind == GL_FRAGMENT_SHADER ? "fragment" : "compute";
}

GLuint compile(const Functions& gl, GLenum kind, const char* source) {
    const GLuint shader = gl.CreateShader(kind);
    gl.ShaderSource(shader, 1, &source, nullptr);
    gl.CompileShader(shader);
    GLint good = 0;
    gl.GetShaderiv(shader, GL_COMPILE_STATUS, &good);
    if (good) return shader;
    std::string log(4096, '\0');
    GLsizei size = 0;
    gl.GetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), &size, log.data());
    log.resize(static_cast<std::size_t>(size));
    gl.DeleteShader(shader);
    throw DeviceError(message("the driver refuses our ", name_of(kind), " shader:\n", log));
}

GLuint link(const Functions& gl, std::initializer_list<GLuint> shaders) {
    const GLuint program = gl.CreateProgram();
    for (const GLuint shader : shaders) {
        gl.AttachShader(program, shader);
        gl.DeleteShader(shader);  // the program keeps it until it goes
    }
    gl.LinkProgram(program);
    GLint good = 0;
    gl.GetProgramiv(program, GL_LINK_STATUS, &good);
    if (good) return program;
    std::string log(4096, '\0');
    GLsizei size = 0;
    gl.GetProgramInfoLog(program, static_cast<GLsizei>(log.size()), &size, log.data());
    log.resize(static_cast<std::size_t>(size));
    gl.DeleteProgram(program);
    throw DeviceError("the driver cannot link our shaders:\n" + log);
}

GLuint drawing_program(const Functions& gl, const char* vertex, const char* fragment) {
    const GLuint first = compile(gl, GL_VERTEX_SHADER, vertex);
    GLuint second = 0;
    try {
        second = compile(gl, GL_FRAGMENT_SHADER, fragment);
    } catch (...) {
        gl.DeleteShader(first);
        throw;
    }
    return link(gl, {first, second});
}

template <class Make>
GLuint kept(const Functions& gl, const std::string& text, const Make& make) {
    const auto found = gl.programs.find(text);
    return found != gl.programs.end() ? found->second : gl.programs[text] = make();
}

}  // namespace

Program::Program(const Functions& gl, const char* vertex, const char* fragment)
    : gl_(gl),
      program_(kept(gl, std::string(vertex) + fragment, [&] { return drawing_program(gl, vertex, fragment); })) {}

Program::Program(const Functions& gl, const char* text)
    : gl_(gl), program_(kept(gl, text, [&] { return link(gl, {compile(gl, GL_COMPUTE_SHADER, text)}); })) {}

Buffer::Buffer(const Functions& gl, const void* data, std::size_t bytes) : gl_(gl) {
    gl.GenBuffers(1, &buffer_);
    gl.BindBuffer(GL_SHADER_STORAGE_BUFFER, buffer_);
    gl.BufferData(GL_SHADER_STORAGE_BUFFER, static_cast<GLsizeiptr>(bytes), data, GL_STATIC_DRAW);
}

void Buffer::read(void* out, std::size_t bytes) const {
    gl_.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    gl_.BindBuffer(GL_SHADER_STORAGE_BUFFER, buffer_);
    gl_.GetBufferSubData(GL_SHADER_STORAGE_BUFFER, 0, static_cast<GLsizeiptr>(bytes), out);
}

void require_storage_buffers(const Functions& gl) {
    for (const GLenum stage : {GL_MAX_VERTEX_SHADER_STORAGE_BLOCKS, GL_MAX_FRAGMENT_SHADER_STORAGE_BLOCKS}) {
        GLint blocks = 0;
        gl.GetIntegerv(stage, &blocks);
        if (blocks < 2) throw DeviceError("the driver has no storage buffers in vertex and fragment shaders");
    }
}

Buffer::~Buffer() { gl_.DeleteBuffers(1, &buffer_); }

Texture::Texture(const Functions& gl, GLenum format, GLsizei width, GLsizei height) : gl_(gl) {
    gl.GenTextures(1, &texture_);
    gl.BindTexture(GL_TEXTURE_2D, texture_);
    gl.TexStorage2D(GL_TEXTURE_2D, 1, format, width, height);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
}

Texture::~Texture() { gl_.DeleteTextures(1, &texture_); }

void Texture::bind(GLuint unit) const {
    gl_.ActiveTexture(GL_TEXTURE0 + unit);
    gl_.BindTexture(GL_TEXTURE_2D, texture_);
}

void Texture::write(GLsizei width, GLsizei height, GLenum format, GLenum type, const void* texels) const {
    gl_.BindTexture(GL_TEXTURE_2D, texture_);
    gl_.TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, width, height, format, type, texels);
}

Framebuffer::Framebuffer(const Functions& gl, const std::vector<const Texture*>& colors, const Texture* depth)
    : gl_(gl) {
    gl.GenFramebuffers(1, &framebuffer_);
    bind();
    std::vector<GLenum> attachments;
    for (const Texture* color : colors) {
        attachments.push_back(GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(attachments.size()));
        gl.FramebufferTexture(GL_FRAMEBUFFER, attachments.back(), color->id(), 0);
    }
    if (depth) gl.FramebufferTexture(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, depth->id(), 0);
    gl.DrawBuffers(static_cast<GLsizei>(attachments.size()), attachments.data());
    const GLenum status = gl.CheckFramebufferStatus(GL_FRAMEBUFFER);
    if (status == GL_FRAMEBUFFER_COMPLETE) return;
    gl.DeleteFramebuffers(1, &framebuffer_);
    throw DeviceError(
        message("the driver cannot draw into float textures (framebuffer status 0x", std::hex, status, ")"));
}

Framebuffer::~Framebuffer() { gl_.DeleteFramebuffers(1, &framebuffer_); }

void Framebuffer::read(GLuint attachment, GLsizei width, GLsizei height, GLenum format, GLenum type, void* out) const {
    bind();
    gl_.PixelStorei(GL_PACK_ALIGNMENT, 1);
    gl_.ReadBuffer(GL_COLOR_ATTACHMENT0 + attachment);
    gl_.ReadPixels(0, 0, width, height, format, type, out);
}

}  // namespace surflux::gl
