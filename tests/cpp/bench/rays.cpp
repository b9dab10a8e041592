// surflux_bench_rays: rays per second of reference_irradiance beside a bare Embree loop over the very same rays.
//
// The linker hands the core's calls of Embree to the functions below (--wrap), which write down each ray of one run.
// The bare loop then asks Embree for the same rays in the same order, in a scene of the same triangles without filters;
// a hair of distance keeps them off the triangle that they leave. One thread each.
//
//     cmake --build build --target surflux_bench_rays && build/tests/cpp/surflux_bench_rays
//
// With any argument it runs the reference alone, for a profiler.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <numeric>

#include "shapes.h"
#include "surflux/core/parallel.h"
#include "surflux/reference/reference.h"
#include "surflux/trace/embree_api.h"

namespace {

struct Recorded {
    RTCRay ray;
    bool occlusion;
    float distance;  // of the hit, or where there is none infinite
};

std::vector<Recorded> recorded;
bool recording = false;

constexpr float infinity = std::numeric_limits<float>::infinity();

float occlusion_distance(const RTCRay& ray) { return ray.tfar < 0.0f ? 0.0f : infinity; }

float hit_distance(const RTCRayHit& hit) { return hit.hit.geomID == RTC_INVALID_GEOMETRY_ID ? infinity : hit.ray.tfar; }

}  // namespace

#if SURFLUX_EMBREE == 4
using Arguments = RTCIntersectArguments;
using OcclusionArguments = RTCOccludedArguments;
#define SURFLUX_ORDER(first, second) second, first
#else
using Arguments = RTCIntersectContext;
using OcclusionArguments = RTCIntersectContext;
#define SURFLUX_ORDER(first, second) first, second
#endif

extern "C" {

void __real_rtcIntersect1(RTCScene, SURFLUX_ORDER(Arguments*, RTCRayHit*));
void __real_rtcOccluded1(RTCScene, SURFLUX_ORDER(OcclusionArguments*, RTCRay*));
void __wrap_rtcIntersect1(RTCScene, SURFLUX_ORDER(Arguments*, RTCRayHit*));
void __wrap_rtcOccluded1(RTCScene, SURFLUX_ORDER(OcclusionArguments*, RTCRay*));

void __wrap_rtcIntersect1(RTCScene scene, SURFLUX_ORDER(Arguments* arguments, RTCRayHit* hit)) {
    if (!recording) return __real_rtcIntersect1(scene, SURFLUX_ORDER(arguments, hit));
    const RTCRay before = hit->ray;
    __real_rtcIntersect1(scene, SURFLUX_ORDER(arguments, hit));
    recorded.push_back({before, false, hit_distance(*hit)});
}

void __wrap_rtcOccluded1(RTCScene scene, SURFLUX_ORDER(OcclusionArguments* arguments, RTCRay* ray)) {
    if (!recording) return __real_rtcOccluded1(scene, SURFLUX_ORDER(arguments, ray));
    const RTCRay before = *ray;
    __real_rtcOccluded1(scene, SURFLUX_ORDER(arguments, ray));
    recorded.push_back({before, true, occlusion_distance(*ray)});
}

}  // extern "C"

namespace surflux {
namespace {

// A ball of triangles, two for each cell of latitude and longitude.
void add_ball(Surfels& s, const Vec3& center, double radius, int rows) {
    const auto at = [&](int a, int b) {
        const double theta = pi * a / rows, phi = pi * b / rows;
        return center +
               radius * Vec3{std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
    };
    for (int a = 0; a < rows; ++a)
        for (int b = 0; b < 2 * rows; ++b) {
            const Vec3 p = at(a, b), q = at(a + 1, b), r = at(a + 1, b + 1), t = at(a, b + 1);
            const auto index = static_cast<std::uint32_t>(s.size());
            s.positions.push_back(0.25 * (p + q + r + t));
            s.normals.push_back(normalized(s.positions.back() - center));
            s.radii.push_back(length(p - r));
            s.areas.push_back(length(cross(q - p, r - p)));
            if (a + 1 < rows) s.triangles.push_back({p, q, r, index});
            if (a > 0) s.triangles.push_back({p, r, t, index});
        }
}

// A closed room with three balls under a lamp: 7000 triangles.
Scene room_of_balls() {
    Surfels balls, lamp;
    add_ball(balls, {0.3, 0.35, 0.25}, 0.25, 24);
    add_ball(balls, {0.7, 0.6, 0.2}, 0.2, 24);
    add_ball(balls, {0.4, 0.75, 0.6}, 0.15, 24);
    shapes::finish(balls, 0.6, 0.0);
    shapes::add_rectangle(lamp, {0.35, 0.35, 0.95}, {0, 0.3, 0}, {0.3, 0, 0}, 1, 1);
    shapes::finish(lamp, 0.3, 10.0);
    return shapes::scene_of({shapes::cube_inside(2, 0.7, 0.0), balls, lamp});
}

class BareScene {
public:
    explicit BareScene(const Surfels& s) : device_(rtcNewDevice(nullptr)), scene_(rtcNewScene(device_)) {
        rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
        RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
        const std::size_t count = s.triangles.size();
        auto* vertex = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                                   RTC_FORMAT_FLOAT3, 3 * sizeof(float), 3 * count));
        auto* index = static_cast<unsigned*>(
            rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(unsigned), count));
        const Box bounds = bounds_of(s);
        const Vec3 origin = 0.5 * (bounds.low + bounds.high);
        for (const Triangle& t : s.triangles)
            for (const Vec3* corner : {&t.a, &t.b, &t.c})
                for (int axis = 0; axis < 3; ++axis) *vertex++ = static_cast<float>((*corner)[axis] - origin[axis]);
        std::iota(index, index + 3 * count, 0u);
        rtcSetGeometryMask(geometry, embree::mask_all);
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(scene_, geometry);
        rtcReleaseGeometry(geometry);
        rtcCommitScene(scene_);
    }
    ~BareScene() {
        rtcReleaseScene(scene_);
        rtcReleaseDevice(device_);
    }
    BareScene(const BareScene&) = delete;
    BareScene& operator=(const BareScene&) = delete;

    // All rays; returns how many found what they found before.
    std::size_t run(const std::vector<Recorded>& rays, float hair) const {
        embree::Context context;
        embree::init(context);
        std::size_t same = 0;
        for (const Recorded& wanted : rays) {
            float distance;
            if (wanted.occlusion) {
                RTCRay ray = wanted.ray;
                ray.tnear = hair;
                embree::occluded(scene_, context, ray);
                distance = occlusion_distance(ray);
            } else {
                RTCRayHit hit;
                hit.ray = wanted.ray;
                hit.ray.tnear = hair;
                hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
                embree::intersect(scene_, context, hit);
                distance = hit_distance(hit);
            }
            same += distance == wanted.distance || std::abs(distance - wanted.distance) < 1e-4f;
        }
        return same;
    }

private:
    RTCDevice device_;
    RTCScene scene_;
};

// Median seconds of five runs after one that is not counted; of the processor, whatever else it does.
template <class Run>
double seconds_of(const Run& run) {
    std::vector<double> seconds;
    for (int k = 0; k < 6; ++k) {
        const std::clock_t start = std::clock();
        run();
        seconds.push_back(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
    }
    std::sort(seconds.begin() + 1, seconds.end());
    return seconds[3];
}

void measure(bool reference_alone) {
    const Scene scene = room_of_balls();
    std::vector<Vec3> points, normals;
    for (std::size_t i = 0; i < scene.surfels.size(); i += 37) {
        points.push_back(scene.surfels.positions[i]);
        normals.push_back(scene.surfels.normals[i]);
    }
    ReferenceOptions options;
    options.samples = 1024;
    const ThreadLimit one(1);
    std::size_t rays = 0;
    const auto reference = [&] { rays = reference_irradiance(scene, points, normals, options).rays; };
    if (reference_alone) {
        seconds_of(reference);
        return;
    }
    recording = true;
    reference();
    recording = false;
    const double ours = seconds_of(reference);

    const BareScene bare(scene.surfels);
    const Box bounds = bounds_of(scene.surfels);
    const auto hair = static_cast<float>(1e-5 * length(bounds.high - bounds.low));
    std::size_t same = 0;
    const double theirs = seconds_of([&] { same = bare.run(recorded, hair); });
    const double millions = 1e-6 * static_cast<double>(recorded.size());
    std::printf("%zu triangles, Embree %d.%d, one thread\n", scene.surfels.triangles.size(), RTC_VERSION_MAJOR,
                RTC_VERSION_MINOR);
    std::printf("reference:   %6.2f M rays/s, %zu rays\n", 1e-6 * static_cast<double>(rays) / ours, rays);
    std::printf("bare Embree: %6.2f M rays/s, %zu rays, %.4f %% of them with the same hits\n", millions / theirs,
                recorded.size(), 100.0 * static_cast<double>(same) / static_cast<double>(recorded.size()));
    std::printf("bare Embree takes %.0f %% of the reference's seconds\n", 100.0 * theirs / ours);
}

}  // namespace
}  // namespace surflux

int main(int argc, char**) { surflux::measure(argc > 1); }
