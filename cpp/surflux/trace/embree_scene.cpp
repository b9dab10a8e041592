#include <algorithm>
#include <cmath>
#include <cstddef>
#include <exception>
#include <numeric>
#include <thread>

#include "surflux/core/available_memory.h"
#include "surflux/core/error.h"
#include "surflux/core/parallel.h"
#include "surflux/trace/tracer_impl.h"

// How Embree gets the scene of a Tracer.
namespace surflux {

namespace {

DeviceError no_device(RTCError why) {
    if (why == RTC_ERROR_UNSUPPORTED_CPU) return DeviceError("Embree: this processor lacks instructions that it needs");
    const char* lacks = why == RTC_ERROR_OUT_OF_MEMORY ? "memory" : "memory or of threads";
    return DeviceError(message("Embree: no device could be made for want of ", lacks, ": this process has ",
                               std::round(available_memory() / 1e6), " MB left"));
}

}  // namespace

namespace {

// Embree tells of its build from any of its threads; reports are made on the thread that called, and what they throw
// must not pass through Embree.
struct Monitor {
    const Progress& progress;
    std::thread::id caller;
    std::exception_ptr thrown;

    static bool told(void* of, double done) {
        auto& self = *static_cast<Monitor*>(of);
        if (std::this_thread::get_id() != self.caller) return true;
        constexpr std::size_t steps = 1000;
        try {
            report(self.progress, static_cast<std::size_t>(steps * std::clamp(done, 0.0, 1.0)), steps);
        } catch (...) {
            self.thrown = std::current_exception();
        }
        return !self.thrown;
    }
};

}  // namespace

void Tracer::Impl::build(const Surfels& surfels, const Progress& progress) {
    device.reset(rtcNewDevice(nullptr));
    if (!device) throw no_device(rtcGetDeviceError(nullptr));
    rtcSetDeviceErrorFunction(device.get(), Errors::keep, &errors);
    scene.reset(rtcNewScene(device.get()));
    rtcSetSceneFlags(scene.get(), RTC_SCENE_FLAG_ROBUST);  // no ray slips between adjacent triangles
    add_disks();
    add_triangles(surfels);
    Monitor monitor{progress, std::this_thread::get_id(), nullptr};
    if (progress) rtcSetSceneProgressMonitorFunction(scene.get(), Monitor::told, &monitor);
    within_limit([&] { rtcCommitScene(scene.get()); });
    if (monitor.thrown) std::rethrow_exception(monitor.thrown);
    rtcSetSceneProgressMonitorFunction(scene.get(), nullptr, nullptr);
    errors.raise();
}

void Tracer::Impl::attach(RTCGeometry geometry, unsigned id) {
    rtcSetGeometryMask(geometry, embree::mask_all);
    rtcSetGeometryOccludedFilterFunction(geometry, filter);
    rtcSetGeometryIntersectFilterFunction(geometry, filter);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene.get(), geometry, id);
    rtcReleaseGeometry(geometry);
}

void Tracer::Impl::add_disks() {
    if (std::none_of(disks.begin(), disks.end(), [](const Disk& disk) { return disk.is_disk(); })) return;
    RTCGeometry geometry = rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_ORIENTED_DISC_POINT);
    // Embree loads 16 bytes at a time, of normals too, from where these are aligned.
    static_assert(offsetof(Disk, position) % 16 == 0 && offsetof(Disk, radius) == offsetof(Disk, position) + 12 &&
                  offsetof(Disk, normal) % 16 == 0);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, disks.data(),
                               offsetof(Disk, position), sizeof(Disk), disks.size());
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_NORMAL, 0, RTC_FORMAT_FLOAT3, disks.data(),
                               offsetof(Disk, normal), sizeof(Disk), disks.size());
    errors.raise();
    attach(geometry, disk_geometry);
}

void Tracer::Impl::add_triangles(const Surfels& s) {
    if (s.triangles.empty()) return;
    RTCGeometry geometry = rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
    const std::size_t count = s.triangles.size();
    auto* vertex = static_cast<float*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), 3 * count));
    auto* index = static_cast<unsigned*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(unsigned), count));
    errors.raise();
    for (const Triangle& t : s.triangles)
        for (const Vec3* corner : {&t.a, &t.b, &t.c}) {
            float p[3];
            to_local(*corner, p);
            vertex = std::copy(p, p + 3, vertex);
        }
    std::iota(index, index + 3 * count, 0u);
    attach(geometry, triangle_geometry);
}

void Tracer::Impl::drop_joints(const Progress& progress) {
    const auto meets_another = [this](std::uint32_t i, const Vec3& from, const Vec3& direction, double length) {
        Query query{{}, this};
        query.but = i;
        embree::init(query.context);
        RTCRay ray = ray_from(from, direction, length);
        embree::occluded(scene.get(), query.context, ray);
        return ray.tfar < 0.0f;
    };
    const auto vec = [](const float (&v)[3]) { return Vec3{v[0], v[1], v[2]}; };
    const auto drop = [&](std::size_t k) {
        const auto i = static_cast<std::uint32_t>(k);
        const Disk& disk = disks[i];
        if (!disk.is_disk()) return;
        for (std::uint32_t e = end_begin[i]; e < end_begin[i + 1]; ++e) {
            if (ends[e].kind != DiskEnd::border) continue;
            const Vec3 outwards = vec(ends[e].normal), normal = vec(disk.normal),
                       center = origin + unit * vec(disk.position);
            const double radius = unit * static_cast<double>(disk.radius);
            // Another's surface across what sticks out, straight on or aslant as in corners, or along it.
            const Vec3 beyond = center + 0.5 * (unit * static_cast<double>(ends[e].limit) + radius) * outwards;
            const Vec3 aside = cross(normal, outwards);
            const double high = 0.25 * radius;
            bool is_joint = false;
            for (const double turn : {0.0, -0.5, 0.5, -1.0, 1.0}) {
                const Vec3 ahead = normalized(outwards + turn * aside);
                is_joint = is_joint || meets_another(i, center, ahead, radius) ||
                           meets_another(i, beyond + 0.5 * turn * radius * aside + high * normal, -normal, 2.0 * high);
            }
            if (is_joint) ends[e].limit = infinite;
        }
    };
    parallel_for(disks.size(), 1024, drop, progress);
}

}  // namespace surflux
