#include "surflux/trace/tracer.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "surflux/core/error.h"
#include "surflux/trace/embree_api.h"

namespace surflux {

namespace {

constexpr std::uint32_t no_surfel = Hit::none;
constexpr unsigned disk_geometry = 0, triangle_geometry = 1;

// Cosine between the normals of surfels on either side of the sharpest ridge over which disks may stand off a surface.
// Only what is crossed on the harmless side is ignored, so this may be generous; it excludes the far face of a thin
// wall.
constexpr float steepest_ridge = 0.0f;

void throw_on_error(void*, RTCError code, const char* text) {
    throw DeviceError(message("Embree: ", text ? text : "unknown error", " (code ", static_cast<int>(code), ")"));
}

struct DeviceRelease {
    void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
};
struct SceneRelease {
    void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};
using Device = std::unique_ptr<std::remove_pointer_t<RTCDevice>, DeviceRelease>;
using EmbreeScene = std::unique_ptr<std::remove_pointer_t<RTCScene>, SceneRelease>;

// What the filters need to know of a surfel.
struct Disk {
    float position[3];
    float normal[3];
    float radius;
    std::uint32_t object;
    std::uint32_t twin;  // the surfel that faces the other way at the same place, or no_surfel
};

// For each surfel the one that is its back (Surfels made two-sided), found by place.
std::vector<std::uint32_t> find_twins(const Scene& scene) {
    const Surfels& s = scene.surfels;
    std::vector<std::uint32_t> order(s.size()), twin(s.size(), no_surfel);
    std::iota(order.begin(), order.end(), 0u);
    const auto before = [&](std::uint32_t a, std::uint32_t b) {
        const Vec3 &p = s.positions[a], &q = s.positions[b];
        if (p.x != q.x) return p.x < q.x;
        if (p.y != q.y) return p.y < q.y;
        if (p.z != q.z) return p.z < q.z;
        return a < b;
    };
    std::sort(order.begin(), order.end(), before);
    for (std::size_t first = 0; first < order.size();) {
        std::size_t last = first + 1;
        while (last < order.size() && s.positions[order[last]] == s.positions[order[first]]) ++last;
        for (std::size_t a = first; a < last; ++a)
            for (std::size_t b = a + 1; b < last; ++b) {
                const std::uint32_t i = order[a], j = order[b];
                if (twin[i] == no_surfel && twin[j] == no_surfel && scene.object[i] == scene.object[j] &&
                    s.radii[i] == s.radii[j] && dot(s.normals[i], s.normals[j]) < -0.999999) {
                    twin[i] = j;
                    twin[j] = i;
                }
            }
        first = last;
    }
    return twin;
}

}  // namespace

struct Tracer::Impl {
    std::vector<Disk> disks;                     // per surfel
    std::vector<std::uint32_t> disk_surfel;      // Embree's disk -> surfel
    std::vector<std::uint32_t> triangle_surfel;  // Embree's triangle -> surfel
    Vec3 origin;
    double diagonal = 0.0;  // of the scene, disks included
    Device device;
    EmbreeScene scene;

    struct Query {
        embree::Context context;  // first: Embree hands back a pointer to it
        const Impl* impl;
        std::uint32_t from, to;
    };

    // Does disk k stand for the same piece of surface as surfel a, and does a ray along `direction` cross it on the
    // side where it stands off that surface? A tangent disk lies outside a convex surface: a ray that leaves a crosses
    // its neighbours from behind, one that arrives at a from the front. Crossed the other way, k is a real obstacle:
    // the far slope of a concave surface.
    bool stands_off(std::uint32_t a, std::uint32_t k, const float (&direction)[3], bool leaving) const {
        const Disk &p = disks[a], &q = disks[k];
        if (p.object != q.object) return false;
        // So far a disk tangent to a sphere can rise above the horizon of another point of it.
        const float reach = 2.0f * q.radius;
        float squared = 0.0f, cosine = 0.0f, along = 0.0f;
        for (int axis = 0; axis < 3; ++axis) {
            const float d = p.position[axis] - q.position[axis];
            squared += d * d;
            cosine += p.normal[axis] * q.normal[axis];
            along += direction[axis] * q.normal[axis];
        }
        if (squared >= reach * reach) return false;
        // Either side of a two-sided sheet may be the one that Embree reports.
        if (q.twin != no_surfel && cosine < 0.0f) cosine = -cosine, along = -along;
        return cosine > steepest_ridge && (leaving ? along > 0.0f : along < 0.0f);
    }

    bool ignores(std::uint32_t end, std::uint32_t k, bool is_disk, const float (&direction)[3], bool leaving) const {
        if (end == no_surfel) return false;
        return end == k || disks[end].twin == k || (is_disk && stands_off(end, k, direction, leaving));
    }

    static void filter(const RTCFilterFunctionNArguments* arguments) {
        const auto* query = reinterpret_cast<const Query*>(arguments->context);
        const Impl& impl = *query->impl;
        for (unsigned n = 0; n < arguments->N; ++n) {
            if (arguments->valid[n] != -1) continue;
            const unsigned primitive = RTCHitN_primID(arguments->hit, arguments->N, n);
            const bool is_disk = RTCHitN_geomID(arguments->hit, arguments->N, n) == disk_geometry;
            const std::uint32_t k = is_disk ? impl.disk_surfel[primitive] : impl.triangle_surfel[primitive];
            const float direction[3] = {RTCRayN_dir_x(arguments->ray, arguments->N, n),
                                        RTCRayN_dir_y(arguments->ray, arguments->N, n),
                                        RTCRayN_dir_z(arguments->ray, arguments->N, n)};
            if (impl.ignores(query->from, k, is_disk, direction, true) ||
                impl.ignores(query->to, k, is_disk, direction, false))
                arguments->valid[n] = 0;
        }
    }

    void to_local(const Vec3& p, float (&out)[3]) const {
        for (int axis = 0; axis < 3; ++axis) out[axis] = static_cast<float>(p[axis] - origin[axis]);
    }

    RTCRay ray_from(const Vec3& from, const Vec3& direction, float far) const {
        float org[3];
        to_local(from, org);
        RTCRay ray;
        ray.org_x = org[0], ray.org_y = org[1], ray.org_z = org[2];
        ray.dir_x = static_cast<float>(direction.x);
        ray.dir_y = static_cast<float>(direction.y);
        ray.dir_z = static_cast<float>(direction.z);
        ray.tnear = 0.0f, ray.tfar = far;
        ray.time = 0.0f, ray.mask = embree::mask_all, ray.id = 0, ray.flags = 0;
        return ray;
    }

    RTCRay segment(const Vec3& from, const Vec3& to) const;

    bool free(std::uint32_t i, std::uint32_t j, RTCRay ray) const {
        Query query{{}, this, i, j};
        embree::init(query.context);
        embree::occluded(scene.get(), query.context, ray);
        return ray.tfar >= 0.0f;  // Embree sets it to -inf on a hit
    }

    void attach(RTCGeometry geometry, unsigned id) {
        rtcSetGeometryMask(geometry, embree::mask_all);
        rtcSetGeometryOccludedFilterFunction(geometry, filter);
        rtcSetGeometryIntersectFilterFunction(geometry, filter);
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(scene.get(), geometry, id);
        rtcReleaseGeometry(geometry);
    }

    void add_disks(const Surfels& s) {
        if (disk_surfel.empty()) return;
        RTCGeometry geometry = rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_ORIENTED_DISC_POINT);
        auto* vertex = static_cast<float*>(rtcSetNewGeometryBuffer(
            geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, 4 * sizeof(float), disk_surfel.size()));
        auto* normal = static_cast<float*>(rtcSetNewGeometryBuffer(
            geometry, RTC_BUFFER_TYPE_NORMAL, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), disk_surfel.size()));
        for (std::uint32_t i : disk_surfel) {
            float p[3];
            to_local(s.positions[i], p);
            for (int axis = 0; axis < 3; ++axis) {
                *vertex++ = p[axis];
                *normal++ = static_cast<float>(s.normals[i][axis]);
            }
            *vertex++ = static_cast<float>(s.radii[i]);
        }
        attach(geometry, disk_geometry);
    }

    void add_triangles(const Surfels& s) {
        if (s.triangles.empty()) return;
        RTCGeometry geometry = rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
        const std::size_t count = s.triangles.size();
        auto* vertex = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                                   RTC_FORMAT_FLOAT3, 3 * sizeof(float), 3 * count));
        auto* index = static_cast<unsigned*>(
            rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(unsigned), count));
        for (const Triangle& t : s.triangles)
            for (const Vec3* corner : {&t.a, &t.b, &t.c}) {
                float p[3];
                to_local(*corner, p);
                vertex = std::copy(p, p + 3, vertex);
            }
        std::iota(index, index + 3 * count, 0u);
        attach(geometry, triangle_geometry);
    }
};

namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

// Embree takes no coordinates beyond 1.8e18; their squares, too, must stay floats.
constexpr double largest_extent = 1e15;

}  // namespace

Tracer::Tracer(const Scene& scene) : impl_(std::make_unique<Impl>()) {
    const Surfels& s = scene.surfels;
    const std::vector<std::uint32_t> twin = find_twins(scene);
    const std::vector<std::uint32_t> triangles = triangle_ranges(s);
    const Box box = bounds_of(s);
    impl_->origin = box.center();
    impl_->diagonal = box.diagonal();
    for (double radius : s.radii) impl_->diagonal = std::max(impl_->diagonal, box.diagonal() + 2.0 * radius);
    require(impl_->diagonal < largest_extent, "scene: it is ", impl_->diagonal, " across, wanted less than ",
            largest_extent);
    impl_->disks.resize(s.size());
    for (std::uint32_t i = 0; i < s.size(); ++i) {
        Disk& d = impl_->disks[i];
        impl_->to_local(s.positions[i], d.position);
        for (int axis = 0; axis < 3; ++axis) d.normal[axis] = static_cast<float>(s.normals[i][axis]);
        d.radius = static_cast<float>(s.radii[i]);
        d.object = scene.object[i];
        d.twin = twin[i];
        if (triangles[i] == triangles[i + 1]) impl_->disk_surfel.push_back(i);
    }
    for (const Triangle& t : s.triangles) impl_->triangle_surfel.push_back(t.surfel);

    impl_->device.reset(rtcNewDevice(nullptr));
    if (!impl_->device) throw DeviceError("Embree: no device could be made on this processor");
    rtcSetDeviceErrorFunction(impl_->device.get(), throw_on_error, nullptr);
    impl_->scene.reset(rtcNewScene(impl_->device.get()));
    rtcSetSceneFlags(impl_->scene.get(), RTC_SCENE_FLAG_ROBUST);  // no ray slips between adjacent triangles
    impl_->add_disks(s);
    impl_->add_triangles(s);
    rtcCommitScene(impl_->scene.get());
}

Tracer::~Tracer() = default;

// A ray of unit direction that ends short of the target by a hair: what lies on the target's own plane does not block.
// A target far outside the scene is as good as one at its edge.
RTCRay Tracer::Impl::segment(const Vec3& from, const Vec3& to) const {
    const Vec3 d = to - from;
    const double distance = length(d);
    if (!(distance > 0.0)) return ray_from(from, {0, 0, 1}, 0.0f);
    return ray_from(from, d / distance, static_cast<float>(std::min(distance * (1.0 - 1e-5), 4.0 * diagonal)));
}

bool Tracer::visible(std::uint32_t i, const Vec3& from, std::uint32_t j, const Vec3& to) const {
    return impl_->free(i, j, impl_->segment(from, to));
}

bool Tracer::visible(std::uint32_t i, const Vec3& from, const Vec3& to) const {
    return impl_->free(i, no_surfel, impl_->segment(from, to));
}

bool Tracer::escapes(std::uint32_t i, const Vec3& from, const Vec3& direction) const {
    return impl_->free(i, no_surfel, impl_->ray_from(from, direction, infinity));
}

Hit Tracer::closest(std::uint32_t i, const Vec3& from, const Vec3& direction) const {
    Impl::Query query{{}, impl_.get(), i, no_surfel};
    embree::init(query.context);
    RTCRayHit hit;
    hit.ray = impl_->ray_from(from, direction, infinity);
    hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    embree::intersect(impl_->scene.get(), query.context, hit);
    if (hit.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
    Hit found;
    found.surfel =
        hit.hit.geomID == disk_geometry ? impl_->disk_surfel[hit.hit.primID] : impl_->triangle_surfel[hit.hit.primID];
    found.distance = static_cast<double>(hit.ray.tfar);
    const auto faces = [&](std::uint32_t k) {
        const float* n = impl_->disks[k].normal;
        return dot(direction, {n[0], n[1], n[2]}) < 0.0;
    };
    found.front = faces(found.surfel);
    const std::uint32_t twin = impl_->disks[found.surfel].twin;
    if (!found.front && twin != no_surfel) return {twin, faces(twin), found.distance};
    return found;
}

std::string embree_version() { return message(RTC_VERSION_MAJOR, ".", RTC_VERSION_MINOR, ".", RTC_VERSION_PATCH); }

}  // namespace surflux
