#pragma once

// The shaders of surface_pass.cpp and splat.cpp. Everything is in the camera's frame: x right, y down, z depth, the eye
// at the origin. Image row 0 is on top and is row 0 of the framebuffer. Clip z only cuts what is nearer than
// `near_depth`; the depth test compares gl_FragDepth, which is linear in depth, so that its precision is that of a
// float everywhere.

namespace surflux::splat_shaders {

// Splat and FlatTriangle of surface_pass.h, as the buffers hold them.
#define SURFLUX_SPLAT_BUFFER                                                                                        \
    "#version 430\n"                                                                                                \
    "struct Splat { vec4 center_kernel; vec4 normal_disk; vec4 radiance_index; };\n"                                \
    "layout(std430, binding = 0) readonly buffer Splats { Splat splats[]; };\n"                                     \
    "const vec2 quad[6] = vec2[6](vec2(-1, -1), vec2(1, -1), vec2(-1, 1), vec2(-1, 1), vec2(1, -1), vec2(1, 1));\n" \
    "const vec4 nowhere = vec4(2, 2, 2, 1);\n"

// Pass 1, disks: the quad around each disk.
constexpr const char* disk_vertex = SURFLUX_SPLAT_BUFFER R"(
uniform vec2 scale;
uniform float near_depth;
out vec2 local;
flat out float sag;
flat out vec3 normal;
flat out int index;

void main() {
    Splat splat = splats[gl_VertexID / 6];
    local = quad[gl_VertexID % 6];
    normal = splat.normal_disk.xyz;
    index = floatBitsToInt(splat.radiance_index.w);
    gl_Position = nowhere;
    sag = 0.4 * splat.normal_disk.w;
    if (splat.normal_disk.w <= 0.0 || dot(normal, splat.center_kernel.xyz) >= 0.0) return;
    // Orthonormal frame around the normal, Duff et al. 2017, as in core/vec.h.
    float s = normal.z < 0.0 ? -1.0 : 1.0;
    float a = -1.0 / (s + normal.z), b = normal.x * normal.y * a;
    vec3 u = vec3(1.0 + s * normal.x * normal.x * a, s * b, -s * normal.x);
    vec3 v = vec3(b, s + normal.y * normal.y * a, -normal.y);
    vec3 p = splat.center_kernel.xyz + splat.normal_disk.w * (local.x * u + local.y * v);
    gl_Position = vec4(p.xy * scale, p.z - 2.0 * near_depth, p.z);
}
)";

// Pass 1, triangles of patches and of emitters.
constexpr const char* triangle_vertex = R"(#version 430
struct Triangle { vec4 corner[3]; vec4 normal_index; };
layout(std430, binding = 0) readonly buffer Triangles { Triangle triangles[]; };
uniform vec2 scale;
uniform float near_depth;
out vec2 local;
flat out float sag;
flat out vec3 normal;
flat out int index;

void main() {
    sag = 0.0;
    Triangle t = triangles[gl_VertexID / 3];
    vec3 p = t.corner[gl_VertexID % 3].xyz;
    local = vec2(0);
    normal = t.normal_index.xyz;
    index = floatBitsToInt(t.normal_index.w);
    gl_Position = vec4(p.xy * scale, p.z - 2.0 * near_depth, p.z);
}
)";

constexpr const char* surface_fragment = R"(#version 430
in vec2 local;
flat in float sag;
flat in vec3 normal;
flat in int index;
uniform float far_depth;
layout(location = 0) out vec4 depth_normal;
layout(location = 1) out int seen;

void main() {
    if (dot(local, local) > 1.0) discard;
    float depth = 1.0 / gl_FragCoord.w;
    depth_normal = vec4(depth, normal);
    seen = index;
    // The disk as a paraboloid: of disks that overlap the one whose centre is nearest wins, not the one that sticks out.
    // An emitter in the plane of a ceiling is in front of it.
    gl_FragDepth = (depth + sag * dot(local, local)) / far_depth * (index < -1 ? 0.99999 : 1.0);
}
)";

// Pass 2: a rectangle of the image around the ellipsoid in which a splat's kernel is not 0: radius `kernel` in its
// plane, `thickness` times that along its normal.
constexpr const char* blend_vertex = SURFLUX_SPLAT_BUFFER R"(
uniform vec2 scale;
uniform float near_depth;
uniform float thickness;
flat out vec4 center_kernel;
flat out vec3 normal;
flat out vec3 radiance;
flat out int index;

// Bounds of x / z over a box around `c`; what reaches behind the eye is bounded on one side only, or not at all.
vec2 bounds(float c, float half_size, float z_low, float z_high) {
    float low = c - half_size, high = c + half_size;
    if (z_low <= near_depth) return vec2(low > 0.0 ? low / z_high : -1e6, high < 0.0 ? high / z_high : 1e6);
    return vec2(low / (low < 0.0 ? z_low : z_high), high / (high < 0.0 ? z_high : z_low));
}

void main() {
    Splat splat = splats[gl_VertexID / 6];
    center_kernel = splat.center_kernel;
    normal = splat.normal_disk.xyz;
    radiance = splat.radiance_index.xyz;
    index = floatBitsToInt(splat.radiance_index.w);
    vec3 squared = normal * normal;
    vec3 size = center_kernel.w * sqrt(max(vec3(0), 1.0 - squared + thickness * thickness * squared));
    vec3 c = center_kernel.xyz;
    vec2 x = scale.x * bounds(c.x, size.x, c.z - size.z, c.z + size.z);
    vec2 y = scale.y * bounds(c.y, size.y, c.z - size.z, c.z + size.z);
    vec2 low = clamp(vec2(x.x, y.x), -1.0, 1.0), high = clamp(vec2(x.y, y.y), -1.0, 1.0);
    gl_Position = vec4(mix(low, high, quad[gl_VertexID % 6] * 0.5 + 0.5), 0, 1);
}
)";

// The weight depends on the point of the surface that the pixel sees, not on where a ray meets the splat's plane: it is
// the same from every eye and needs no care at grazing angles. Where the normals differ it fades, so that nothing
// bleeds across a crease, and one object takes nothing from another, however near. Emitters and the background take
// nothing at all.
constexpr const char* blend_fragment = R"(#version 430
layout(binding = 0) uniform sampler2D surface;
layout(binding = 1) uniform isampler2D seen;
layout(std430, binding = 1) readonly buffer Objects { int objects[]; };
flat in int index;
uniform vec4 ray;
uniform float thickness;
flat in vec4 center_kernel;
flat in vec3 normal;
flat in vec3 radiance;
layout(location = 0) out vec4 sum;

void main() {
    vec4 depth_normal = texelFetch(surface, ivec2(gl_FragCoord.xy), 0);
    float agreement = smoothstep(0.5, 0.95, dot(depth_normal.yzw, normal));
    int there = texelFetch(seen, ivec2(gl_FragCoord.xy), 0).r;
    if (agreement <= 0.0 || there < 0 || objects[there] != objects[index]) discard;
    vec3 d = vec3(ray.xy * gl_FragCoord.xy + ray.zw, 1) * depth_normal.x - center_kernel.xyz;
    float height = dot(d, normal);
    float raised = height / thickness;
    float s = (dot(d, d) - height * height + raised * raised) / (center_kernel.w * center_kernel.w);
    if (s >= 1.0) discard;
    float weight = agreement * exp(-2.0 * s) * (1.0 - s) * (1.0 - s);
    sum = weight * vec4(radiance, 1);
}
)";

#undef SURFLUX_SPLAT_BUFFER

}  // namespace surflux::splat_shaders
