#pragma once

// What a pass makes in a context; each is deleted with its owner, but for programs, which stay for other passes in the
// same context. None outlives the Context it was made in.

#include <cstddef>
#include <vector>

#include "surflux/gl/context.h"

namespace surflux::gl {

// A vertex and a fragment shader, or a compute shader, linked once in a context: uniforms have what they were given
// last. Throws DeviceError with the driver's log.
class Program {
public:
    Program(const Functions& gl, const char* vertex, const char* fragment);
    Program(const Functions& gl, const char* compute);

    void use() const { gl_.UseProgram(program_); }
    // -1 (which GL ignores) for a name that the program does not use.
    GLint uniform(const char* name) const { return gl_.GetUniformLocation(program_, name); }

private:
    const Functions& gl_;
    GLuint program_;
};

// A shader storage buffer. Shaders may write it; what they write is seen after MemoryBarrier.
class Buffer {
public:
    Buffer(const Functions& gl, const void* data, std::size_t bytes);
    template <class T>
    Buffer(const Functions& gl, const std::vector<T>& data) : Buffer(gl, data.data(), data.size() * sizeof(T)) {}
    ~Buffer();
    Buffer(const Buffer&) = delete;
    Buffer& operator=(const Buffer&) = delete;

    void bind(GLuint binding) const { gl_.BindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, buffer_); }
    // The first `bytes` of it; waits for the shaders that write them.
    void read(void* out, std::size_t bytes) const;

private:
    const Functions& gl_;
    GLuint buffer_ = 0;
};

// Throws DeviceError where vertex and fragment shaders cannot read two buffers each, which OpenGL leaves open.
void require_storage_buffers(const Functions& gl);

// Two-dimensional, one level, without filtering: texels are fetched, never interpolated.
class Texture {
public:
    Texture(const Functions& gl, GLenum format, GLsizei width, GLsizei height);
    ~Texture();
    Texture(const Texture&) = delete;
    Texture& operator=(const Texture&) = delete;

    void bind(GLuint unit) const;
    // All texels, first row first, `format` and `type` as OpenGL names them.
    void write(GLsizei width, GLsizei height, GLenum format, GLenum type, const void* texels) const;
    GLuint id() const { return texture_; }

private:
    const Functions& gl_;
    GLuint texture_ = 0;
};

// Draws into the colour textures, attached in their order, and the depth texture, if there is one. The textures must
// live as long. Throws DeviceError where the driver cannot draw into them.
class Framebuffer {
public:
    Framebuffer(const Functions& gl, const std::vector<const Texture*>& colors, const Texture* depth = nullptr);
    ~Framebuffer();
    Framebuffer(const Framebuffer&) = delete;
    Framebuffer& operator=(const Framebuffer&) = delete;

    void bind() const { gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_); }
    // All texels of colour texture `attachment`, first row first; `out` has the room for them.
    void read(GLuint attachment, GLsizei width, GLsizei height, GLenum format, GLenum type, void* out) const;

private:
    const Functions& gl_;
    GLuint framebuffer_ = 0;
};

}  // namespace surflux::gl
