#include "surflux/trace/tracer.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "surflux/core/error.h"
#include "surflux/core/parallel.h"
#include "surflux/trace/coincident.h"
#include "surflux/trace/embree_api.h"
#include "surflux/trace/tracer_impl.h"

namespace surflux {

namespace {

constexpr double farthest_point = 1e15;  // in units of the tracer: its square is a float, too

}  // namespace

void Tracer::Impl::Errors::keep(void* errors, RTCError code, const char* text) {
    auto& self = *static_cast<Errors*>(errors);
    const std::lock_guard lock(self.mutex);
    if (self.first.empty())
        self.first = message("Embree: ", text ? text : "unknown error", " (code ", static_cast<int>(code), ")");
}

void Tracer::Impl::Errors::raise() {
    const std::lock_guard lock(mutex);
    if (!first.empty()) throw DeviceError(first);
}

Tracer::Impl::Impl(const Surfels& surfels)
    : extent(surfels), origin(extent.middle), unit(extent.unit), diameter(extent.size) {
    for (double reach : extent.reach) diameter = std::max(diameter, 2.0 * reach);
}

Tracer::Tracer(const Scene& scene, const Progress& progress) : impl_(std::make_unique<Impl>(scene.surfels)) {
    const Surfels& s = scene.surfels;
    const Progress starting = standing_at(0, s.size(), progress);
    report(starting, 0, 1);
    const Coincident coincident = find_coincident(scene, starting);
    const std::vector<std::uint32_t> triangles = triangle_ranges(s);
    impl_->disks.resize(s.size());
    const auto add_disk = [&](std::size_t k) {
        const auto i = static_cast<std::uint32_t>(k);
        Impl::Disk& d = impl_->disks[i];
        impl_->to_local(s.positions[i], d.position);
        for (int axis = 0; axis < 3; ++axis) d.normal[axis] = static_cast<float>(s.normals[i][axis]);
        const bool is_disk = triangles[i] == triangles[i + 1] && !coincident.is_copy[i];
        d.radius = is_disk ? impl_->to_local(s.radii[i]) : std::numeric_limits<float>::quiet_NaN();
        d.contact = impl_->to_local(impl_->extent.contact_of(i));
        d.object = scene.object[i];
        d.twin = coincident.twin[i];
        d.spread = scene.spread.empty() ? 0.0f : impl_->to_local(scene.spread[i]);
    };
    parallel_for(s.size(), 4096, add_disk, starting);
    for (const Impl::Disk& d : impl_->disks) impl_->largest_contact = std::max(impl_->largest_contact, d.contact);
    impl_->end_begin = end_ranges(s);
    for (const DiskEnd& e : s.ends)
        impl_->ends.push_back(
            {{static_cast<float>(e.normal.x), static_cast<float>(e.normal.y), static_cast<float>(e.normal.z)},
             impl_->to_local(e.limit),
             e.kind});
    for (const Triangle& t : s.triangles) impl_->triangle_surfel.push_back(t.surfel);
    std::vector<double>().swap(impl_->extent.reach);
    impl_->add_coplanar(scene);
    impl_->find_lower(scene, progress);

    impl_->build(s, progress);
    impl_->drop_joints(progress);
}

Tracer::~Tracer() = default;

Hit Tracer::Impl::found(const RTCRayHit& hit, const Vec3& direction) const {
    if (hit.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
    Hit out;
    out.surfel = hit.hit.geomID == disk_geometry ? hit.hit.primID : triangle_surfel[hit.hit.primID];
    out.distance = unit * static_cast<double>(hit.ray.tfar);
    const auto faces = [&](std::uint32_t k) {
        const float* n = disks[k].normal;
        return dot(direction, {n[0], n[1], n[2]}) < 0.0;
    };
    if (hit.hit.geomID == triangle_geometry) {
        const Vec3 at = end_of(hit.ray);
        // Of the two sides of a sheet the one that faces the ray, of what covers that the one on top.
        const std::uint32_t side = faces(out.surfel) ? no_surfel : backs_of.find(out.surfel, at);
        if (side != no_surfel) out.surfel = side;
        const std::uint32_t top = covers_of.find(out.surfel, at);
        if (top != no_surfel) out.surfel = top;
    }
    out.front = faces(out.surfel);
    const std::uint32_t twin = disks[out.surfel].twin;
    if (!out.front && twin != no_surfel) return {twin, faces(twin), out.distance};
    return out;
}

void Tracer::Impl::Coplanar::fill(const Impl& impl, const Surfels& s, const std::vector<Pair>& pairs) {
    if (pairs.empty()) return;
    const std::vector<std::uint32_t> triangles = triangle_ranges(s);
    begin.assign(s.size() + 1, 0);
    for (const Pair& pair : pairs) begin[pair.of + 1] += triangles[pair.patch + 1] - triangles[pair.patch];
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    parts.resize(begin.back());
    std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
    for (const Pair& pair : pairs)
        for (std::uint32_t t = triangles[pair.patch]; t < triangles[pair.patch + 1]; ++t) {
            const Vec3 corners[3] = {(s.triangles[t].a - impl.origin) / impl.unit,
                                     (s.triangles[t].b - impl.origin) / impl.unit,
                                     (s.triangles[t].c - impl.origin) / impl.unit};
            const Vec3 normal = cross(corners[1] - corners[0], corners[2] - corners[0]);
            Part& part = parts[next[pair.of]++];
            part.patch = pair.patch;
            for (int k = 0; k < 3; ++k) {
                part.edge[k] = cross(corners[(k + 1) % 3] - corners[k], normal);
                part.limit[k] = dot(part.edge[k], corners[k]);
            }
        }
}

std::uint32_t Tracer::Impl::Coplanar::find(std::uint32_t of, const Vec3& at) const {
    if (begin.empty()) return no_surfel;
    for (std::uint32_t p = begin[of]; p < begin[of + 1]; ++p) {
        const Part& part = parts[p];
        bool inside = true;
        for (int k = 0; k < 3; ++k) inside = inside && dot(part.edge[k], at) <= part.limit[k];
        if (inside) return part.patch;
    }
    return no_surfel;
}

void Tracer::Impl::add_coplanar(const Scene& of) {
    std::vector<Coplanar::Pair> covers, backs;
    // Ascending by both: of each patch, the last is on top.
    for (auto cover = of.covers.rbegin(); cover != of.covers.rend(); ++cover)
        covers.push_back({cover->below, cover->above});
    for (const Sheet& sheet : of.sheets) {
        if (disks[sheet.one].twin == sheet.other) continue;  // altogether, which is told without looking where
        backs.push_back({sheet.one, sheet.other});
        backs.push_back({sheet.other, sheet.one});
    }
    covers_of.fill(*this, of.surfels, covers);
    backs_of.fill(*this, of.surfels, backs);
}

void Tracer::require_near(const std::vector<Vec3>& points) const {
    const double limit = farthest_point * impl_->unit;
    for (std::size_t k = 0; k < points.size(); ++k)
        require(length(points[k] - impl_->origin) <= limit, "points: number ", k, " is more than ", limit,
                " away from the scene");
}

double Tracer::contact(std::uint32_t surfel) const { return impl_->contact_of(surfel); }

double Tracer::contact(const Vec3& place) const { return impl_->extent.contact(place); }

std::string embree_version() {
    const std::unique_ptr<RTCDeviceTy, decltype(&rtcReleaseDevice)> device(rtcNewDevice(nullptr), rtcReleaseDevice);
    if (!device) return message(RTC_VERSION_STRING, ", which does not start");
    const auto part = [&](RTCDeviceProperty property) { return rtcGetDeviceProperty(device.get(), property); };
    return message(part(RTC_DEVICE_PROPERTY_VERSION_MAJOR), ".", part(RTC_DEVICE_PROPERTY_VERSION_MINOR), ".",
                   part(RTC_DEVICE_PROPERTY_VERSION_PATCH));
}

}  // namespace surflux
