#pragma once

// The shaders of atlas.cpp. Texels are addressed from their tile's corner, in whole numbers: what is interpolated
// across an atlas of thousands of texels has lost the digits that tell where a disk ends.

namespace surflux::atlas_shaders {

// TexelRange of atlas_tiles.h, and its corner number 0 to 5.
#define SURFLUX_ATLAS_RANGE                                                                                           \
    "#version 430\n"                                                                                                  \
    "uniform vec2 atlas;\n"                                                                                           \
    "const uvec2 quad[6] = uvec2[6](uvec2(0, 0), uvec2(1, 0), uvec2(0, 1), uvec2(0, 1), uvec2(1, 0), uvec2(1, 1));\n" \
    "vec2 unpack(uint pair) { return vec2(pair & 0xffffu, pair >> 16); }\n"                                           \
    "vec4 corner(uvec4 range, int vertex) {\n"                                                                        \
    "    vec2 low = unpack(range.x), high = unpack(range.y);\n"                                                       \
    "    return vec4(2.0 * mix(low, high, vec2(quad[vertex])) / atlas - 1.0, 0, 1);\n"                                \
    "}\n"

// paper: D04 5.3, one quad per neighbour.
constexpr const char* flat_vertex = SURFLUX_ATLAS_RANGE R"(
struct Quad { vec4 axes; vec4 center; uvec4 range; };
layout(std430, binding = 0) readonly buffer Quads { Quad quads[]; };
uniform ivec2 size;
flat out vec4 axes;
flat out vec3 center;  // and stretch
flat out vec2 middle;

void main() {
    Quad q = quads[gl_VertexID / 6];
    axes = q.axes;
    center = q.center.xyz;
    middle = unpack(q.range.z) + vec2(0.25, 0.5) * float(size.y);
    gl_Position = corner(q.range, gl_VertexID % 6);
}
)";

// R and G: numerator and denominator of D04 eq. 7 at the texel's left pixel; B and A: at its right one.
constexpr const char* flat_fragment = R"(#version 430
uniform float falloff;  // -kappa / log 2
flat in vec4 axes;
flat in vec3 center;
flat in vec2 middle;
layout(location = 0) out vec4 sum;

void main() {
    vec2 p = gl_FragCoord.xy - middle;
    vec2 dx = 2.0 * p.x + vec2(-0.5, 0.5) - center.x;
    float dy = p.y - center.y;
    vec2 along = axes.x * dx + axes.y * dy, across = axes.z * dx + axes.w * dy;
    vec2 q = along * along + across * across;
    vec2 w = mix(vec2(0), exp2(falloff * sqrt(q)), lessThanEqual(q, vec2(1)));
    sum = vec4(w.x * center.z, w.x, w.y * center.z, w.y);
}
)";

// One work group a tile: 32 columns at a time, two rows at a time.
#define SURFLUX_ATLAS_SUM                                                      \
    "#version 430\n"                                                           \
    "layout(local_size_x = 32, local_size_y = 2) in;\n"                        \
    "layout(std430, binding = 0) writeonly buffer Areas { float areas[]; };\n" \
    "uniform ivec2 size;\n"                                                    \
    "uniform ivec2 tiles;\n"                                                   \
    "shared float parts[64];\n"                                                \
    "void finish(int tile, float part) {\n"                                    \
    "    parts[gl_LocalInvocationIndex] = part;\n"                             \
    "    barrier();\n"                                                         \
    "    if (gl_LocalInvocationIndex == 0u) {\n"                               \
    "        float total = 0.0;\n"                                             \
    "        for (int k = 0; k < 64; ++k) total += parts[k];\n"                \
    "        areas[tile] = total;\n"                                           \
    "    }\n"                                                                  \
    "}\n"

// D04 eq. 9 over the pixels whose centres lie in the disk.
constexpr const char* flat_sum = SURFLUX_ATLAS_SUM R"(
layout(binding = 0) uniform sampler2D sums;
uniform float falloff;

void main() {
    int tile = int(gl_WorkGroupID.x);
    ivec2 origin = size * ivec2(tile % tiles.x, tile / tiles.x);
    float pixel = 2.0 / float(size.y);
    float part = 0.0;
    for (int y = int(gl_LocalInvocationID.y); y < size.y; y += 2) {
        for (int x = int(gl_LocalInvocationID.x); x < size.x; x += 32) {
            vec2 s = (2.0 * float(x) + vec2(0.5, 1.5)) * pixel - 1.0;
            float t = (float(y) + 0.5) * pixel - 1.0;
            vec2 q = s * s + t * t;
            vec4 sum = texelFetch(sums, origin + ivec2(x, y), 0);
            vec2 own = exp2(falloff * sqrt(q)), total = own + sum.ga;
            vec2 area = own / total * ((own + sum.rb) / total);
            part += (q.x <= 1.0 ? area.x : 0.0) + (q.y <= 1.0 ? area.y : 0.0);
        }
    }
    finish(tile, part * pixel * pixel);
}
)";

// curved, first pass: a tile's directions end and the surface over each point.
constexpr const char* surface_vertex = R"(#version 430
struct Tile { vec4 k_gx; float gy; uint first_end; uint ends; uint unused; };
layout(std430, binding = 0) readonly buffer Tiles { Tile models[]; };
uniform vec2 atlas;
uniform ivec2 size;
uniform ivec2 tiles;
flat out vec3 k;
flat out vec2 g;
flat out uvec2 ends;
flat out ivec2 origin;

void main() {
    int tile = gl_VertexID / 6, corner = gl_VertexID % 6;
    k = models[tile].k_gx.xyz;
    g = vec2(models[tile].k_gx.w, models[tile].gy);
    ends = uvec2(models[tile].first_end, models[tile].first_end + models[tile].ends);
    origin = size * ivec2(tile % tiles.x, tile / tiles.x);
    ivec2 p = origin + size * ivec2(corner == 1 || corner >= 4, corner == 2 || corner == 3 || corner == 5);
    gl_Position = vec4(2.0 * vec2(p) / atlas - 1.0, 0, 1);
}
)";

constexpr const char* surface_fragment = R"(#version 430
layout(std430, binding = 1) readonly buffer Ends { vec4 half_planes[]; };
layout(binding = 0) uniform sampler2D directions;  // cosine and sine
layout(binding = 1) uniform sampler2D rings;       // radii in row 0, weights in row 1
flat in vec3 k;
flat in vec2 g;
flat in uvec2 ends;
flat in ivec2 origin;
layout(location = 0) out vec2 rim;
layout(location = 1) out vec4 height;
layout(location = 2) out vec4 area;

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy) - origin;
    vec2 direction = texelFetch(directions, ivec2(at.x, 0), 0).rg;
    float end = 1.0;
    for (uint i = ends.x; i < ends.y; ++i) {
        vec4 h = half_planes[i];
        float towards = dot(h.xy, direction);
        if (towards > 0.0) end = min(end, h.z / towards);
    }
    rim = end * direction;
    vec4 radius = texelFetch(rings, ivec2(at.y, 0), 0);
    vec4 x = rim.x * radius, y = rim.y * radius;
    vec4 tx = g.x + k.x * x + k.y * y, ty = g.y + k.y * x + k.z * y;
    vec4 nz = sqrt(1.0 - min(tx * tx + ty * ty, vec4(0.75)));
    float own_nz = sqrt(1.0 - min(dot(g, g), 0.75));
    height = -(x * (g.x + tx) + y * (g.y + ty)) / (own_nz + nz);
    area = end * end * texelFetch(rings, ivec2(at.y, 1), 0) / nz;
}
)";

// curved, second pass: one quad per sharer, weights over the surfel's own.
constexpr const char* curved_vertex = SURFLUX_ATLAS_RANGE R"(
struct Quad { vec4 sharer; uvec4 range; };
layout(std430, binding = 0) readonly buffer Quads { Quad quads[]; };
flat out vec4 sharer;
flat out int first_row;

void main() {
    Quad q = quads[gl_VertexID / 6];
    sharer = q.sharer;
    first_row = int(q.range.z >> 16);
    gl_Position = corner(q.range, gl_VertexID % 6);
}
)";

constexpr const char* curved_fragment = R"(
layout(binding = 0) uniform sampler2D rims;
layout(binding = 1) uniform sampler2D heights;
layout(binding = 2) uniform sampler2D rings;
uniform float kappa;
flat in vec4 sharer;
flat in int first_row;
layout(location = 0) out vec4 sum;

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec2 rim = texelFetch(rims, at, 0).rg;
    vec4 z = texelFetch(heights, at, 0);
    vec4 radius = texelFetch(rings, ivec2(at.y - first_row, 0), 0);
    vec4 x = rim.x * radius, y = rim.y * radius;
    vec4 own = x * x + y * y + z * z;
    x -= sharer.x;
    y -= sharer.y;
    z -= sharer.z;
    vec4 q = x * x + y * y + z * z;
    vec4 nearer = own / max(q, 1e-9);
#ifdef CUBED
    vec4 power = nearer * nearer * nearer;
#else
    vec4 power = exp2(min(kappa * log2(nearer), 120.0));
#endif
    sum = power * max(1.0 - q * sharer.w, 0.0);
}
)";

constexpr const char* curved_sum = SURFLUX_ATLAS_SUM R"(
layout(binding = 0) uniform sampler2D rims;
layout(binding = 1) uniform sampler2D heights;
layout(binding = 2) uniform sampler2D rings;
layout(binding = 3) uniform sampler2D areas_over;
layout(binding = 4) uniform sampler2D sums;

void main() {
    int tile = int(gl_WorkGroupID.x);
    ivec2 origin = size * ivec2(tile % tiles.x, tile / tiles.x);
    vec4 part = vec4(0);
    for (int y = int(gl_LocalInvocationID.y); y < size.y; y += 2) {
        for (int x = int(gl_LocalInvocationID.x); x < size.x; x += 32) {
            ivec2 at = origin + ivec2(x, y);
            vec2 rim = texelFetch(rims, at, 0).rg;
            vec4 z = texelFetch(heights, at, 0), radius = texelFetch(rings, ivec2(y, 0), 0);
            vec4 taper = 1.0 - (dot(rim, rim) * radius * radius + z * z);
            vec4 share = taper / (taper + texelFetch(sums, at, 0));
            part += mix(vec4(0), share * texelFetch(areas_over, at, 0), greaterThan(taper, vec4(0)));
        }
    }
    finish(tile, part.x + part.y + part.z + part.w);
}
)";

#undef SURFLUX_ATLAS_RANGE
#undef SURFLUX_ATLAS_SUM

}  // namespace surflux::atlas_shaders
