#pragma once

// The shaders of meshless_image.cpp, in the camera's frame (see splat_shaders.h). Places are relative to `origin`, a
// point near what is drawn: seen from afar, differences of places keep their digits. Where there is light to be told
// apart, DIRECT is defined (in a line before these texts) and a second sum goes along.

namespace surflux::meshless_shaders {

constexpr const char* version = "#version 430\n";
constexpr const char* direct_too = "#define DIRECT\n";

constexpr const char* screen_vertex = R"(
void main() { gl_Position = vec4(gl_VertexID == 1 ? 3 : -1, gl_VertexID == 2 ? 3 : -1, 0, 1); }
)";

// What each pixel sees: its place and object (-1: none) and its normal.
constexpr const char* place_fragment = R"(
layout(binding = 0) uniform sampler2D surface;
layout(binding = 1) uniform isampler2D seen;
layout(std430, binding = 1) readonly buffer Objects { int objects[]; };
uniform vec4 ray;
uniform vec4 origin;
layout(location = 0) out vec4 place;
layout(location = 1) out vec4 facing;

void main() {
    vec4 depth_normal = texelFetch(surface, ivec2(gl_FragCoord.xy), 0);
    int surfel = texelFetch(seen, ivec2(gl_FragCoord.xy), 0).r;
    vec3 from_eye = vec3(ray.xy * gl_FragCoord.xy + ray.zw, 1) * depth_normal.x;
    place = vec4(from_eye - origin.xyz, surfel < 0 ? -1.0 : float(objects[surfel]));
    facing = vec4(depth_normal.yzw, 0);
}
)";

// A rectangle of the image around the sphere in which a function is not 0, as near as the sphere's nearest point: what
// is seen before that is not on it, and early depth tests leave it out.
constexpr const char* function_vertex = R"(
struct Function { vec4 center_radius; vec4 normal_object; vec4 all; vec4 direct; };
layout(std430, binding = 0) readonly buffer Functions { Function functions[]; };
const vec2 quad[6] = vec2[6](vec2(0, 0), vec2(1, 0), vec2(0, 1), vec2(0, 1), vec2(1, 0), vec2(1, 1));
uniform vec2 scale;
uniform float near_depth;
uniform float far_depth;
uniform vec4 origin;
flat out vec4 center_shrink;
flat out vec4 normal_object;
flat out vec3 all;
#ifdef DIRECT
flat out vec3 direct;
#endif

// Bounds of x / z over a circle around (x, z): the whole image for one that reaches the plane of the eye.
vec2 bounds(float x, float z, float radius) {
    if (z - radius <= near_depth) return vec2(-1e6, 1e6);
    float tangent = sqrt(x * x + z * z - radius * radius), below = (z - radius) * (z + radius);
    return vec2(x * z - radius * tangent, x * z + radius * tangent) / below;
}

void main() {
    Function f = functions[gl_VertexID / 6];
    center_shrink = vec4(f.center_radius.xyz, 1.0 / (f.center_radius.w * f.center_radius.w));
    normal_object = f.normal_object;
    all = f.all.xyz;
#ifdef DIRECT
    direct = f.direct.xyz;
#endif
    vec3 c = f.center_radius.xyz + origin.xyz;
    float radius = f.center_radius.w + 1e-6 * length(c);
    vec2 x = clamp(scale.x * bounds(c.x, c.z, radius), -1.0, 1.0);
    vec2 y = clamp(scale.y * bounds(c.y, c.z, radius), -1.0, 1.0);
    float nearest = clamp((c.z - radius) / far_depth - 1e-6, 0.0, 1.0);
    gl_Position = vec4(mix(vec2(x.x, y.x), vec2(x.y, y.y), quad[gl_VertexID % 6]), 2.0 * nearest - 1.0, 1);
}
)";

// L07 eqs. 12 and 13, without the loss of digits near t = 1.
constexpr const char* function_fragment = R"(
layout(early_fragment_tests) in;
layout(binding = 0) uniform sampler2D places;
layout(binding = 1) uniform sampler2D facings;
flat in vec4 center_shrink;
flat in vec4 normal_object;
flat in vec3 all;
layout(location = 0) out vec4 sum;
#ifdef DIRECT
flat in vec3 direct;
layout(location = 1) out vec4 direct_sum;
#endif

void main() {
    vec4 place = texelFetch(places, ivec2(gl_FragCoord.xy), 0);
    vec3 d = place.xyz - center_shrink.xyz;
    float squared = dot(d, d) * center_shrink.w;
    if (squared >= 1.0 || place.w != normal_object.w) discard;
    float cosine = dot(texelFetch(facings, ivec2(gl_FragCoord.xy), 0).xyz, normal_object.xyz);
    if (cosine <= 0.0) discard;
    float t = sqrt(squared);
    float weight = (1.0 - t) * (1.0 - t) * (1.0 + 2.0 * t) * cosine;
    sum = vec4(weight * all, weight);
#ifdef DIRECT
    direct_sum = vec4(weight * direct, 0);
#endif
}
)";

// Adds a level, L07 eq. 9. The image's fourth number says that the coarsest level of the object has been there.
constexpr const char* level_fragment = R"(
layout(binding = 0) uniform sampler2D places;
layout(binding = 1) uniform sampler2D sums;
layout(binding = 2) uniform sampler2D direct_sums;
layout(std430, binding = 1) readonly buffer Coarsest { int coarsest[]; };
uniform float level;
layout(location = 0) out vec4 all;
#ifdef DIRECT
layout(location = 1) out vec4 direct;
#endif

void main() {
    vec4 sum = texelFetch(sums, ivec2(gl_FragCoord.xy), 0);
    if (sum.w <= 0.0) discard;
    int object = int(texelFetch(places, ivec2(gl_FragCoord.xy), 0).w);
    all = vec4(sum.xyz / sum.w, coarsest[object] == int(level) ? 1 : 0);
#ifdef DIRECT
    direct = vec4(texelFetch(direct_sums, ivec2(gl_FragCoord.xy), 0).xyz / sum.w, 0);
#endif
}
)";

}  // namespace surflux::meshless_shaders
