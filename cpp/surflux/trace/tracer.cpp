#include "surflux/trace/tracer.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "surflux/core/error.h"
#include "surflux/trace/embree_api.h"
#include "surflux/trace/tracer_impl.h"

namespace surflux {

namespace {

void throw_on_error(void*, RTCError code, const char* text) {
    throw DeviceError(message("Embree: ", text ? text : "unknown error", " (code ", static_cast<int>(code), ")"));
}

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
    impl_->contact = static_cast<float>(contact_distance(box));
    for (double radius : s.radii) impl_->diagonal = std::max(impl_->diagonal, box.diagonal() + 2.0 * radius);
    require(impl_->diagonal < largest_extent, "scene: it is ", impl_->diagonal, " across, wanted less than ",
            largest_extent);
    impl_->disks.resize(s.size());
    for (std::uint32_t i = 0; i < s.size(); ++i) {
        Impl::Disk& d = impl_->disks[i];
        impl_->to_local(s.positions[i], d.position);
        for (int axis = 0; axis < 3; ++axis) d.normal[axis] = static_cast<float>(s.normals[i][axis]);
        d.radius = static_cast<float>(s.radii[i]);
        d.object = scene.object[i];
        d.twin = twin[i];
        d.spread = scene.spread.empty() ? 0.0f : static_cast<float>(scene.spread[i]);
        if (triangles[i] == triangles[i + 1]) impl_->disk_surfel.push_back(i);
    }
    impl_->end_begin = end_ranges(s);
    for (const DiskEnd& e : s.ends)
        impl_->ends.push_back(
            {{static_cast<float>(e.normal.x), static_cast<float>(e.normal.y), static_cast<float>(e.normal.z)},
             static_cast<float>(e.limit),
             e.kind});
    for (const Triangle& t : s.triangles) impl_->triangle_surfel.push_back(t.surfel);
    impl_->add_covers(scene);

    impl_->device.reset(rtcNewDevice(nullptr));
    if (!impl_->device) throw DeviceError("Embree: no device could be made on this processor");
    rtcSetDeviceErrorFunction(impl_->device.get(), throw_on_error, nullptr);
    impl_->scene.reset(rtcNewScene(impl_->device.get()));
    rtcSetSceneFlags(impl_->scene.get(), RTC_SCENE_FLAG_ROBUST);  // no ray slips between adjacent triangles
    impl_->add_disks(s);
    impl_->add_triangles(s);
    rtcCommitScene(impl_->scene.get());
    impl_->drop_joints();
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
    return impl_->free(impl_->leaving(i, from), j, impl_->segment(from, to), length(to - from));
}

bool Tracer::visible(std::uint32_t i, const Vec3& from, const Vec3& to) const {
    return impl_->free(impl_->leaving(i, from), no_surfel, impl_->segment(from, to), length(to - from));
}

bool Tracer::escapes(std::uint32_t i, const Vec3& from, const Vec3& direction) const {
    return impl_->free(impl_->leaving(i, from), no_surfel, impl_->ray_from(from, direction, infinite), infinite);
}

Hit Tracer::Impl::found(const RTCRayHit& hit, const Vec3& direction) const {
    if (hit.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
    Hit out;
    out.surfel = hit.hit.geomID == disk_geometry ? disk_surfel[hit.hit.primID] : triangle_surfel[hit.hit.primID];
    if (hit.hit.geomID == triangle_geometry) out.surfel = topmost(out.surfel, hit.ray);
    out.distance = static_cast<double>(hit.ray.tfar);
    if (hit.hit.geomID == disk_geometry && has_ends(out.surfel)) {
        const RTCRay& ray = hit.ray;
        const float* p = disks[out.surfel].position;
        const float at[3] = {ray.org_x + ray.tfar * ray.dir_x - p[0], ray.org_y + ray.tfar * ray.dir_y - p[1],
                             ray.org_z + ray.tfar * ray.dir_z - p[2]};
        if (is_beyond(DiskEnd::border, out.surfel, at)) return out;  // no front
    }
    const auto faces = [&](std::uint32_t k) {
        const float* n = disks[k].normal;
        return dot(direction, {n[0], n[1], n[2]}) < 0.0;
    };
    out.front = faces(out.surfel);
    const std::uint32_t twin = disks[out.surfel].twin;
    if (!out.front && twin != no_surfel) return {twin, faces(twin), out.distance};
    return out;
}

void Tracer::Impl::add_covers(const Scene& of) {
    if (of.covers.empty()) return;
    const Surfels& s = of.surfels;
    const std::vector<std::uint32_t> begin = triangle_ranges(s);
    cover_begin.assign(s.size() + 1, 0);
    // Ascending by both: of each patch, the last is on top.
    for (auto cover = of.covers.rbegin(); cover != of.covers.rend(); ++cover)
        cover_begin[cover->below + 1] += begin[cover->above + 1] - begin[cover->above];
    std::partial_sum(cover_begin.begin(), cover_begin.end(), cover_begin.begin());
    cover_parts.resize(cover_begin.back());
    std::vector<std::uint32_t> next(cover_begin.begin(), cover_begin.end() - 1);
    for (auto cover = of.covers.rbegin(); cover != of.covers.rend(); ++cover)
        for (std::uint32_t t = begin[cover->above]; t < begin[cover->above + 1]; ++t) {
            const Vec3 corners[3] = {s.triangles[t].a - origin, s.triangles[t].b - origin, s.triangles[t].c - origin};
            const Vec3 normal = cross_of(s.triangles[t]);
            CoverPart& part = cover_parts[next[cover->below]++];
            part.above = cover->above;
            for (int k = 0; k < 3; ++k) {
                part.edge[k] = cross(corners[(k + 1) % 3] - corners[k], normal);
                part.limit[k] = dot(part.edge[k], corners[k]);
            }
        }
}

std::uint32_t Tracer::Impl::topmost(std::uint32_t surfel, const RTCRay& ray) const {
    if (cover_begin.empty()) return surfel;
    const auto along = [&ray](float from, float direction) { return static_cast<double>(from + ray.tfar * direction); };
    const Vec3 at{along(ray.org_x, ray.dir_x), along(ray.org_y, ray.dir_y), along(ray.org_z, ray.dir_z)};
    for (std::uint32_t p = cover_begin[surfel]; p < cover_begin[surfel + 1]; ++p) {
        const CoverPart& part = cover_parts[p];
        bool inside = true;
        for (int k = 0; k < 3; ++k) inside = inside && dot(part.edge[k], at) <= part.limit[k];
        if (inside) return part.above;
    }
    return surfel;
}

void Tracer::Impl::drop_joints() {
    const auto meets_another = [this](std::uint32_t i, const Vec3& from, const Vec3& direction, float length) {
        Query query{{}, this, nullptr, no_surfel};
        query.but = disks[i].object;
        embree::init(query.context);
        RTCRay ray = ray_from(from, direction, length);
        embree::occluded(scene.get(), query.context, ray);
        return ray.tfar < 0.0f;
    };
    const auto vec = [](const float (&v)[3]) { return Vec3{v[0], v[1], v[2]}; };
    for (std::uint32_t i = 0; i + 1 < end_begin.size(); ++i)
        for (std::uint32_t e = end_begin[i]; e < end_begin[i + 1]; ++e) {
            if (ends[e].kind != DiskEnd::border) continue;
            const Disk& disk = disks[i];
            const Vec3 outwards = vec(ends[e].normal), normal = vec(disk.normal), center = origin + vec(disk.position);
            // Another's surface across what sticks out, or along it.
            const Vec3 beyond = center + (0.5 * static_cast<double>(ends[e].limit + disk.radius)) * outwards;
            const float high = 0.25f * disk.radius;
            if (meets_another(i, center, outwards, disk.radius) ||
                meets_another(i, beyond + static_cast<double>(high) * normal, -normal, 2.0f * high))
                ends[e].limit = infinite;
        }
}

Hit Tracer::closest(std::uint32_t i, const Vec3& from, const Vec3& direction) const {
    const Departure leaving = impl_->leaving(i, from);
    Impl::Query query{{}, impl_.get(), &leaving, no_surfel};
    embree::init(query.context);
    RTCRayHit hit;
    hit.ray = impl_->ray_from(from, direction, infinite);
    hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    embree::intersect(impl_->scene.get(), query.context, hit);
    return impl_->found(hit, direction);
}

std::string embree_version() { return message(RTC_VERSION_MAJOR, ".", RTC_VERSION_MINOR, ".", RTC_VERSION_PATCH); }

}  // namespace surflux
