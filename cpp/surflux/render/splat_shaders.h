#pragma once

// The shaders of surface_pass.cpp and splat.cpp. Everything is in the camera's frame: x right, y down, z depth, the eye
// at the origin. `parallel` is 1 where all rays go along z, else 0. Image row 0 is on top and is row 0 of the
// framebuffer, which holds a band of the image's rows. Clip z only cuts what is nearer than `near_depth`; the depth
// test compares gl_FragDepth, which is linear in depth, so that its precision is that of a float everywhere.

namespace surflux::splat_shaders {

// For a vertex shader: how the pixels of a box (splats.h) are covered; `band`: width and rows of the framebuffer, its
// first row, and the vertices of a primitive: 6 of two triangles, or 1 of a point. A point's square has its middle
// within the band, else it would be clipped.
constexpr const char* box = R"(#version 430
const vec2 quad[6] = vec2[6](vec2(0, 0), vec2(1, 0), vec2(0, 1), vec2(0, 1), vec2(1, 0), vec2(1, 1));
uniform vec4 band;
int primitive() { return gl_VertexID / int(band.w); }
vec4 corner_of(ivec4 box) {
    vec2 low = vec2(box.xy) - vec2(0, band.z), high = vec2(box.zw) - vec2(0, band.z);
    vec2 at = mix(low, high, quad[gl_VertexID % 6]);
    gl_PointSize = 1.0;
    if (band.w == 1.0) {
        float size = max(high.x - low.x, high.y - low.y);
        gl_PointSize = size;
        at = clamp(low, vec2(0), band.xy - size) + 0.5 * size;
    }
    return vec4(2.0 * at / band.xy - 1.0, 0, 1);
}
)";

// Pass 1, disks: DrawnDisk. `box` goes before this text.
constexpr const char* disk_vertex = R"(
struct Disk {
    vec4 center_radius; vec4 normal_along; vec4 direction_across; vec4 sag_names; vec4 creases[2]; ivec4 box;
};
layout(std430, binding = 0) readonly buffer Disks { Disk disks[]; };
flat out vec4 center_radius;
flat out vec4 normal_along;
flat out vec4 direction_across;
flat out float sag;
flat out ivec2 names;
flat out vec4 creases[2];

void main() {
    Disk disk = disks[primitive()];
    center_radius = disk.center_radius;
    normal_along = disk.normal_along;
    direction_across = disk.direction_across;
    sag = disk.sag_names.x;
    names = floatBitsToInt(disk.sag_names.yz);
    creases = disk.creases;
    gl_Position = corner_of(disk.box);
}
)";

// Where the ray meets the disk bent to a paraboloid, its height over the tangent plane (along x^2 + across y^2) / 2.
// Distances count from the depth of the centre, where numbers are small.
constexpr const char* disk_fragment = R"(#version 430
flat in vec4 center_radius;
flat in vec4 normal_along;
flat in vec4 direction_across;
flat in float sag;
flat in ivec2 names;
flat in vec4 creases[2];
uniform vec4 ray;
uniform float parallel;
uniform float near_depth;
uniform float far_depth;
layout(location = 0) out vec4 depth_normal;
layout(location = 1) out ivec2 seen;

void main() {
    vec2 place = ray.xy * gl_FragCoord.xy + ray.zw;
    vec3 way = vec3(parallel > 0.0 ? vec2(0) : place, 1), n = normal_along.xyz, u = direction_across.xyz;
    vec3 at_center = parallel > 0.0 ? vec3(place, center_radius.z) : way * center_radius.z;
    vec3 v = cross(n, u), from = at_center - center_radius.xyz;
    vec2 bend = vec2(normal_along.w, direction_across.w);
    vec2 start = vec2(dot(from, u), dot(from, v)), go = vec2(dot(way, u), dot(way, v));
    // a t^2 + 2 b t + c = 0; the front is where the left side rises.
    float a = 0.5 * dot(bend, go * go), b = 0.5 * (dot(bend, start * go) - dot(way, n));
    float c = 0.5 * dot(bend, start * start) - dot(from, n), d = b * b - a * c;
    if (d < 0.0) discard;
    float root = sqrt(d), t = b >= 0.0 ? -c / (b + root) : (root - b) / a;
    if (b < 0.0 && a == 0.0) discard;
    float depth = center_radius.z + t;
    vec2 local = start + t * go;
    float squared = dot(local, local) / (center_radius.w * center_radius.w);
    if (!(squared <= 1.0) || depth <= near_depth) discard;
    vec3 at = local.x * u + local.y * v;
    if (dot(at, creases[0].xyz) > creases[0].w || dot(at, creases[1].xyz) > creases[1].w) discard;
    depth_normal = vec4(depth, normalize(n - bend.x * local.x * u - bend.y * local.y * v));
    seen = names;
    // Of disks that overlap the one whose centre is nearest wins, not the one that sticks out.
    // Of the two sides of a sheet that is the front.
    gl_FragDepth = (depth + sag * squared) / far_depth * ((names.y & 1) == 1 ? 1.00001 : 1.0);
}
)";

// Pass 1, triangles of patches and of emitters: FlatTriangle. The band is a part of the image's height.
constexpr const char* triangle_vertex = R"(#version 430
struct Triangle { vec4 corner[3]; vec4 normal_index; ivec4 group; };
layout(std430, binding = 0) readonly buffer Triangles { Triangle triangles[]; };
uniform vec4 scale;
uniform float parallel;
uniform float near_depth;
uniform float far_depth;
flat out vec3 normal;
flat out ivec2 names;
out float deep;

void main() {
    Triangle t = triangles[gl_VertexID / 3];
    vec3 p = t.corner[gl_VertexID % 3].xyz;
    normal = t.normal_index.xyz;
    names = ivec2(floatBitsToInt(t.normal_index.w), t.group.x);
    deep = p.z;
    gl_Position = parallel > 0.0
        ? vec4(p.x * scale.x, p.y * scale.y + scale.z, 2.0 * (p.z - near_depth) / far_depth - 1.0, 1)
        : vec4(p.x * scale.x, p.y * scale.y + p.z * scale.z, p.z - 2.0 * near_depth, p.z);
}
)";

constexpr const char* triangle_fragment = R"(#version 430
flat in vec3 normal;
flat in ivec2 names;
in float deep;
uniform float parallel;
uniform float far_depth;
layout(location = 0) out vec4 depth_normal;
layout(location = 1) out ivec2 seen;

void main() {
    float depth = parallel > 0.0 ? deep : 1.0 / gl_FragCoord.w;
    depth_normal = vec4(depth, normal);
    seen = names;
    // An emitter in the plane of a ceiling is in front of it.
    gl_FragDepth = depth / far_depth * (names.x < -1 ? 0.99999 : (names.y & 1) == 1 ? 1.00001 : 1.0);
}
)";

// Pass 2, DrawnKernel, and LAYERS values of each (`box` and a line that says how many go before these
// texts).
constexpr const char* kernel_vertex = R"(
struct Kernel {
    vec4 center_group; vec4 normal_amplitude; vec4 direction_agreement; vec4 shrink_index; ivec4 box; ivec4 walls;
};
layout(std430, binding = 0) readonly buffer Kernels { Kernel kernels[]; };
layout(std430, binding = 1) readonly buffer Values { vec4 values[]; };
flat out vec4 center_group;
flat out vec4 normal_amplitude;
flat out vec4 direction_agreement;
flat out vec3 shrink;
flat out ivec2 walls;
flat out vec3 value[LAYERS];

void main() {
    int at = primitive();
    Kernel kernel = kernels[at];
    center_group = kernel.center_group;
    normal_amplitude = kernel.normal_amplitude;
    direction_agreement = kernel.direction_agreement;
    shrink = kernel.shrink_index.xyz;
    walls = kernel.walls.xy;
    for (int k = 0; k < LAYERS; ++k) value[k] = values[LAYERS * at + k].xyz;
    gl_Position = corner_of(kernel.box);
}
)";

// The weight depends on the point of the surface that the pixel sees, not on where a ray meets the tangent plane: it
// needs no care at grazing angles. Where the normals differ it fades, so that nothing bleeds across a crease - less so
// where a pixel sees many surfels, whose mean it shows -, and one object takes nothing from another, however near.
// Emitters and the background take nothing at all.
constexpr const char* kernel_fragment = R"(
layout(binding = 0) uniform sampler2D surface;
layout(binding = 1) uniform isampler2D seen;
layout(std430, binding = 2) readonly buffer Walls { vec4 ends[]; };
uniform vec4 ray;
uniform float parallel;
flat in vec4 center_group;
flat in vec4 normal_amplitude;
flat in vec4 direction_agreement;
flat in vec3 shrink;
flat in ivec2 walls;
flat in vec3 value[LAYERS];
layout(location = 0) out vec4 sum[LAYERS];

// As is_behind of kernel_walls.h has it.
float outer(vec2 a, vec2 b) { return a.x * b.y - a.y * b.x; }
bool is_behind(vec4 wall, vec2 place) {
    vec2 a = wall.xy, b = wall.zw;
    return outer(a, b) * outer(b - a, place - a) < 0.0 && outer(place, a) * outer(place, b) < 0.0;
}

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    if (texelFetch(seen, at, 0).y != floatBitsToInt(center_group.w)) discard;
    vec4 depth_normal = texelFetch(surface, at, 0);
    vec2 place = ray.xy * gl_FragCoord.xy + ray.zw;
    vec3 d = (parallel > 0.0 ? vec3(place, depth_normal.x) : vec3(place, 1) * depth_normal.x) - center_group.xyz;
    vec3 n = normal_amplitude.xyz, u = direction_agreement.xyz;
    vec3 local = vec3(dot(d, u), dot(d, cross(n, u)), dot(d, n));
    float s = dot(local * local, shrink);
    if (s >= 1.0) discard;
    float close = direction_agreement.w;
    float agreement = smoothstep(0.5 * close, mix(0.5, 0.95, close), dot(depth_normal.yzw, n));
    if (agreement <= 0.0) discard;
    float weight = normal_amplitude.w * agreement * exp(-2.0 * s) * (1.0 - s) * (1.0 - s);
    for (int k = walls.x; k < walls.y; ++k)
        if (is_behind(ends[k], local.xy)) { weight *= 1e-6; break; }
    for (int k = 0; k < LAYERS; ++k) sum[k] = weight * vec4(value[k], 1);
}
)";

}  // namespace surflux::splat_shaders
