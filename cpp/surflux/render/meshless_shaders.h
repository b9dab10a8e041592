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
    ivec2 names = texelFetch(seen, ivec2(gl_FragCoord.xy), 0).rg;
    int surfel = names.x;
    vec3 from_eye = vec3(ray.xy * gl_FragCoord.xy + ray.zw, 1) * depth_normal.x;
    place = vec4(from_eye - origin.xyz, surfel < 0 ? -1.0 : float(objects[surfel]));
    // A back, whose group is odd, is lit as its front, which faces away.
    facing = vec4((names.y & 1) == 1 ? -depth_normal.yzw : depth_normal.yzw, 0);
}
)";

// A function's rectangle of the image, as near as the nearest point of the sphere around its support: what is seen
// before that is not on it, and early depth tests leave it out.
constexpr const char* function_vertex = R"(
struct Function { vec4 center_shrink; vec4 normal_object; vec4 all_nearest; vec4 direct; vec4 value_gathered;
                  vec4 direct_value; vec4 corners; vec4 cuts[2]; };
layout(std430, binding = 0) readonly buffer Functions { Function functions[]; };
const vec2 quad[6] = vec2[6](vec2(0, 0), vec2(1, 0), vec2(0, 1), vec2(0, 1), vec2(1, 0), vec2(1, 1));
flat out vec4 center_shrink;
flat out vec4 normal_object;
flat out vec3 all;
flat out vec4 value_gathered;
flat out vec4 first_cut;
flat out vec4 second_cut;
#ifdef DIRECT
flat out vec3 direct;
flat out vec3 direct_value;
#endif

void main() {
    Function f = functions[gl_VertexID / 6];
    center_shrink = f.center_shrink;
    normal_object = f.normal_object;
    all = f.all_nearest.xyz;
    value_gathered = f.value_gathered;
    first_cut = f.cuts[0];
    second_cut = f.cuts[1];
#ifdef DIRECT
    direct = f.direct.xyz;
    direct_value = f.direct_value.xyz;
#endif
    gl_Position = vec4(mix(f.corners.xy, f.corners.zw, quad[gl_VertexID % 6]), 2.0 * f.all_nearest.w - 1.0, 1);
}
)";

// L07 eqs. 12 and 13, without the loss of digits near t = 1; values, and the squares of their largest channels in the
// unit, of functions at whose points light was gathered.
constexpr const char* function_fragment = R"(
layout(early_fragment_tests) in;
layout(binding = 0) uniform sampler2D places;
layout(binding = 1) uniform sampler2D facings;
uniform float unit;
flat in vec4 center_shrink;
flat in vec4 normal_object;
flat in vec3 all;
flat in vec4 value_gathered;
flat in vec4 first_cut;
flat in vec4 second_cut;
layout(location = 0) out vec4 sum;
layout(location = 1) out vec4 values;
layout(location = 2) out float squares;
#ifdef DIRECT
flat in vec3 direct;
flat in vec3 direct_value;
layout(location = 3) out vec4 direct_sum;
layout(location = 4) out vec4 direct_values;
#endif

void main() {
    vec4 place = texelFetch(places, ivec2(gl_FragCoord.xy), 0);
    vec3 d = place.xyz - center_shrink.xyz;
    float squared = dot(d, d) * center_shrink.w;
    if (squared >= 1.0 || place.w != normal_object.w) discard;
    float cosine = dot(texelFetch(facings, ivec2(gl_FragCoord.xy), 0).xyz, normal_object.xyz);
    if (cosine <= 0.0) discard;
    if (dot(place.xyz, first_cut.xyz) < first_cut.w || dot(place.xyz, second_cut.xyz) < second_cut.w) discard;
    float t = sqrt(squared);
    float weight = (1.0 - t) * (1.0 - t) * (1.0 + 2.0 * t) * (cosine * cosine) * (cosine * cosine);
    float of_value = unit * max(value_gathered.x, max(value_gathered.y, value_gathered.z));
    sum = vec4(weight * all, weight);
    values = weight * value_gathered;
    squares = weight * of_value * of_value;
#ifdef DIRECT
    direct_sum = vec4(weight * direct, 0);
    direct_values = vec4(weight * direct_value, 0);
#endif
}
)";

// Adds a level to what coarser ones brought, as LevelLight does. The image's fourth number says that the coarsest level
// of the object has been there.
constexpr const char* level_fragment = R"(
layout(binding = 0) uniform sampler2D places;
layout(binding = 1) uniform sampler2D sums;
layout(binding = 2) uniform sampler2D value_sums;
layout(binding = 3) uniform sampler2D square_sums;
layout(binding = 4) uniform sampler2D before;
layout(binding = 5) uniform sampler2D direct_sums;
layout(binding = 6) uniform sampler2D direct_value_sums;
layout(binding = 7) uniform sampler2D direct_before;
layout(std430, binding = 1) readonly buffer Coarsest { int coarsest[]; };
uniform float level;
uniform float unit;
uniform vec4 limits;
layout(location = 0) out vec4 all;
#ifdef DIRECT
layout(location = 1) out vec4 direct;
#endif

vec3 limited(vec3 slope, float most) {
    float largest = max(abs(slope.x), max(abs(slope.y), abs(slope.z)));
    return largest > most ? slope * (most / largest) : slope;
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    all = texelFetch(before, pixel, 0);
#ifdef DIRECT
    direct = texelFetch(direct_before, pixel, 0);
#endif
    vec4 sum = texelFetch(sums, pixel, 0);
    if (sum.w <= 0.0) return;
    int object = int(texelFetch(places, pixel, 0).w);
    bool is_coarsest = coarsest[object] == int(level);
    if (is_coarsest) all.w = 1.0;
    vec4 values = texelFetch(value_sums, pixel, 0);
    if (values.w <= 0.0) return;
    // MultilevelBasis fades finer levels at their rims.
    float fade = is_coarsest ? 1.0 : smoothstep(0.0, 1.0, sum.w);
    float share = fade * min(1.0, values.w / sum.w);
    vec3 mean = values.xyz / values.w;
    float middle = unit * max(mean.x, max(mean.y, mean.z));
    float deviation = sqrt(max(0.0, texelFetch(square_sums, pixel, 0).x / values.w - middle * middle));
    float most = max(0.0, limits.x * deviation + limits.y * middle) / unit;
    all.xyz += share * (mean + limited(all.xyz + sum.xyz / values.w - mean, most) - all.xyz);
#ifdef DIRECT
    mean = texelFetch(direct_value_sums, pixel, 0).xyz / values.w;
    vec3 change = texelFetch(direct_sums, pixel, 0).xyz / values.w;
    direct.xyz += share * (mean + limited(direct.xyz + change - mean, most) - direct.xyz);
#endif
}
)";

}  // namespace surflux::meshless_shaders
