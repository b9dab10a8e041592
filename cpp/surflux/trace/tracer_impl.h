#pragma once

// What the queries of a Tracer share. Included by trace's .cpp files alone.

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <mutex>
#include <numeric>
#include <string>
#include <vector>

#include "surflux/core/error.h"
#include "surflux/scene/extent.h"
#include "surflux/trace/embree_api.h"
#include "surflux/trace/tracer.h"

namespace surflux {

inline constexpr std::uint32_t no_surfel = Hit::none;
inline constexpr unsigned disk_geometry = 0, triangle_geometry = 1;

// Cosine between the normals of surfels on either side of the sharpest ridge over which disks may stand off a surface.
// Only what is crossed on the harmless side is ignored, so this may be generous; it excludes the far face of a thin
// wall.
inline constexpr float steepest_ridge = 0.0f;
// The same of surfels of different objects.
inline constexpr float other_objects_ridge = 0.5f;
inline float dot3(const float (&a)[3], const float (&b)[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

inline constexpr float infinite = std::numeric_limits<float>::infinity();

struct Tracer::Impl {
    struct DeviceRelease {
        void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
    };
    struct SceneRelease {
        void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
    };
    using Device = std::unique_ptr<std::remove_pointer_t<RTCDevice>, DeviceRelease>;
    using EmbreeScene = std::unique_ptr<std::remove_pointer_t<RTCScene>, SceneRelease>;

    // What Embree reports through its C interface, from whatever thread: no exception may pass through that.
    struct Errors {
        static void keep(void* errors, RTCError code, const char* text);
        void raise();  // the first, where there is one
        std::mutex mutex;
        std::string first;
    };

    // What Embree (position and radius, normal) and the filters need to know of a surfel; lengths here and below in
    // `unit`.
    struct alignas(16) Disk {
        float position[3];
        float radius;  // NaN of what is no disk: Embree leaves it out
        float normal[3];
        float contact;  // what is no farther from it touches it (scene/extent.h)
        std::uint32_t object;
        std::uint32_t twin;  // the surfel that faces the other way at the same place, or no_surfel
        float spread;        // of heights on its surface, where disks of other objects stand for that, too
        bool is_disk() const { return !std::isnan(radius); }
    };

    // The line beyond which a disk has no surface (scene's DiskEnd).
    struct End {
        float normal[3];
        float limit;
        DiskEnd::Kind kind;
    };

    // The disks whose surface one disk rises over towards its rim.
    struct LowerDisks {
        const std::uint32_t *first, *last;
        const std::uint32_t* begin() const { return first; }
        const std::uint32_t* end() const { return last; }
        bool empty() const { return first == last; }
    };

    // The triangles of patches that lie in one place with each of others, `patch` being whose: inside
    // dot(edge, p) <= limit for all three, p from the origin.
    struct Coplanar {
        struct Part {
            Vec3 edge[3];
            double limit[3];
            std::uint32_t patch;
        };
        struct Pair {
            std::uint32_t of, patch;
        };
        std::vector<std::uint32_t> begin;  // per surfel, and one more; empty where there are none
        std::vector<Part> parts;

        // In the order of the pairs.
        void fill(const Impl& impl, const Surfels& s, const std::vector<Pair>& pairs);
        // The first patch that has the place, or no_surfel.
        std::uint32_t find(std::uint32_t of, const Vec3& at) const;
        bool has(std::uint32_t of, std::uint32_t patch) const {
            if (begin.empty() || of == no_surfel) return false;
            for (std::uint32_t p = begin[of]; p < begin[of + 1]; ++p)
                if (parts[p].patch == patch) return true;
            return false;
        }
    };

    std::vector<Disk> disks;               // per surfel, which is Embree's number of a disk
    std::vector<std::uint32_t> end_begin;  // per surfel, and one more
    std::vector<End> ends;
    std::vector<std::uint32_t> triangle_surfel;  // Embree's triangle -> surfel
    std::vector<std::uint32_t> lower_begin;      // per surfel, and one more
    std::vector<std::uint32_t> lower;            // disks around, whose surface each disk rises over towards its rim
    Extent extent;
    Coplanar covers_of;  // patches that cover each, the topmost first
    Coplanar backs_of;   // the other sides of each as a sheet
    Vec3 origin;
    double unit;      // Embree's coordinates are (p - origin) / unit: alike for scenes alike, of whatever size
    double diameter;  // of a ball around the scene
    float largest_contact = 0.0f;  // of all surfels
    Errors errors;                 // outlives the device
    Device device;
    EmbreeScene scene;

    explicit Impl(const Surfels& surfels);

    LowerDisks lower_of(std::uint32_t surfel) const {
        return {lower.data() + lower_begin[surfel], lower.data() + lower_begin[surfel + 1]};
    }

    struct Query {
        embree::Context context;  // first: Embree hands back a pointer to it
        const Impl* impl;
        const Ray* rays = nullptr;      // by Embree's ray id
        bool segments = false;          // which end on a surface or at a light
        const Vec3* nearby = nullptr;   // the normal of a point whose surfel is looked for, and nothing else
        std::uint32_t but = no_surfel;  // what is not of this one's object or surface is looked for, and nothing else
    };

    // The sides of a sheet may be of two objects.
    bool is_of(const Disk& q, std::uint32_t object) const {
        return q.object == object || (q.twin != no_surfel && disks[q.twin].object == object);
    }

    // May the surface of disk q, `height` below or above a place on disk p, be the place's own?
    bool is_one_surface(const Disk& p, const Disk& q, float cosine, float height) const {
        if (is_of(q, p.object)) return cosine > steepest_ridge;
        return cosine > other_objects_ridge && p.spread > 0.0f && q.spread > 0.0f &&
               height <= std::max(p.spread, q.spread);
    }

    // Is q of the object of disk p, or a disk of those that stand for its surface, too, with which it shares its
    // border?
    bool goes_on(const Disk& p, const Disk& q) const {
        const auto cosine = [&] { return dot3(p.normal, q.normal); };
        return is_of(q, p.object) || (p.spread > 0.0f && q.spread > 0.0f && cosine() > other_objects_ridge);
    }

    // Does disk k stand for the same piece of surface as surfel a, at which a ray along `direction` arrives, and is it
    // crossed on the side where it stands off that surface? A tangent disk lies outside a convex surface: a ray that
    // arrives crosses it from the front. Crossed the other way, k is a real obstacle: the far slope of a concave
    // surface. For rays that leave see ignores().
    bool stands_off(std::uint32_t a, std::uint32_t k, const float (&direction)[3]) const {
        const Disk &p = disks[a], &q = disks[k];
        // So far a disk tangent to a sphere can rise above the horizon of another point of it.
        const float reach = 2.0f * q.radius;
        float squared = 0.0f, cosine = 0.0f, along = 0.0f, height = 0.0f;
        for (int axis = 0; axis < 3; ++axis) {
            const float d = p.position[axis] - q.position[axis];
            squared += d * d;
            height += d * q.normal[axis];
            cosine += p.normal[axis] * q.normal[axis];
            along += direction[axis] * q.normal[axis];
        }
        if (squared >= reach * reach) return false;
        // Either side of a two-sided sheet may be the one that Embree reports.
        if (q.twin != no_surfel && cosine < 0.0f) cosine = -cosine, along = -along;
        return along < 0.0f && is_one_surface(p, q, cosine, std::abs(height));
    }

    // What the filters need to know of a crossing.
    struct Crossing {
        const RTCFilterFunctionNArguments* arguments;
        unsigned n;
        std::uint32_t surfel;
        bool is_disk;
        float direction[3];  // of the ray
        float distance() const { return RTCRayN_tfar(arguments->ray, arguments->N, n); }
        float from(const Disk& disk, int axis) const {
            const unsigned count = arguments->N;
            RTCRayN* ray = arguments->ray;
            const float origin = axis == 0   ? RTCRayN_org_x(ray, count, n)
                                 : axis == 1 ? RTCRayN_org_y(ray, count, n)
                                             : RTCRayN_org_z(ray, count, n);
            return origin - disk.position[axis];
        }
        // Of the plane that is crossed, over the origin of the ray.
        float height() const { return distance() * cosine(); }
        float cosine() const {
            RTCHitN* hit = arguments->hit;
            const unsigned count = arguments->N;
            const float normal[3] = {RTCHitN_Ng_x(hit, count, n), RTCHitN_Ng_y(hit, count, n),
                                     RTCHitN_Ng_z(hit, count, n)};
            const float along = normal[0] * direction[0] + normal[1] * direction[1] + normal[2] * direction[2];
            const float squared = normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2];
            return std::abs(along) / std::sqrt(squared);
        }
    };

    // Is there no surface any more where a ray crosses the disk? What looks for surfaces finds them beyond borders,
    // too.
    bool is_beyond_end(const Query& query, const Crossing& hit) const {
        if (!hit.is_disk || end_begin[hit.surfel] == end_begin[hit.surfel + 1]) return false;
        float at[3];
        for (int axis = 0; axis < 3; ++axis)
            at[axis] = hit.from(disks[hit.surfel], axis) + hit.distance() * hit.direction[axis];
        for (std::uint32_t e = end_begin[hit.surfel]; e < end_begin[hit.surfel + 1]; ++e) {
            if (ends[e].kind == DiskEnd::border && query.rays == nullptr) continue;
            const float* n = ends[e].normal;
            if (n[0] * at[0] + n[1] * at[1] + n[2] * at[2] > ends[e].limit) return true;
        }
        return false;
    }

    // A disk is tangent to its surface, so that its rim stands off where that is convex. A ray that crosses the rim
    // from behind without having been inside goes on (rims.cpp). Of disks that overlap the lowest is never passed so:
    // what is closed, or a sheet, blocks from behind as before.
    bool is_over_surface(std::uint32_t from, const Crossing& hit) const {
        const Disk& q = disks[hit.surfel];
        return hit.is_disk && q.twin == no_surfel && dot3(hit.direction, q.normal) > 0.0f &&
               !lower_of(hit.surfel).empty() && passes_under_rim(from, hit);
    }
    bool passes_under_rim(std::uint32_t from, const Crossing& hit) const;
    bool rise_over(const LowerDisks& around, std::uint32_t i) const;

    // Where a ray from surfel `end`, or none, crosses something.
    float contact(std::uint32_t end, const Crossing& hit) const {
        const float there = disks[hit.surfel].contact;
        return end == no_surfel ? there : std::max(there, disks[end].contact);
    }

    // The rule where rays begin. What is met from behind within rounding of the place is the place's own surface, as a
    // patch in the same plane is, or goes on from it, unless it faces the place: that covers it. So do disks that stand
    // off the place's surface: a ray that leaves a convex one crosses its neighbours' from behind.
    bool ignores(const Departure& from, const Crossing& hit) const {
        if (from.surfel == hit.surfel || backs_of.has(from.surfel, hit.surfel)) return true;
        const Disk& q = disks[hit.surfel];
        float along = hit.direction[0] * q.normal[0] + hit.direction[1] * q.normal[1] + hit.direction[2] * q.normal[2];
        if (q.twin == no_surfel && along <= 0.0f) return false;  // nearly always
        if (q.twin != no_surfel && from.surfel == q.twin) return true;
        float cosine = 0.0f;
        for (int axis = 0; axis < 3; ++axis) cosine += static_cast<float>(from.normal[axis]) * q.normal[axis];
        if (q.twin != no_surfel && cosine < 0.0f) cosine = -cosine, along = -along;
        if (along <= 0.0f) return false;
        if (cosine > -0.5f && hit.height() <= 2.0f * contact(from.surfel, hit)) return true;
        if (!hit.is_disk || from.surfel == no_surfel) return false;
        float squared = 0.0f;
        for (int axis = 0; axis < 3; ++axis) squared += hit.from(q, axis) * hit.from(q, axis);
        const float reach = 2.0f * q.radius;
        return squared < reach * reach && is_one_surface(disks[from.surfel], q, cosine, hit.height());
    }

    // The rule where a segment ends. What is met from the front within rounding of the end is what it ends on: a patch
    // in the same plane, or the ceiling that a lamp is let into.
    bool ends_on(float length, const Crossing& hit) const {
        const float left = length - hit.distance();
        if (!(left * hit.cosine() <= 2.0f * contact(no_surfel, hit))) return false;
        const Disk& q = disks[hit.surfel];
        if (q.twin != no_surfel) return true;
        float along = 0.0f;
        for (int axis = 0; axis < 3; ++axis) along += hit.direction[axis] * q.normal[axis];
        return along < 0.0f;
    }

    // A surface that faces away from the point, or is farther along the normal than it may be, is not the point's own.
    bool is_strange(const Vec3& normal, const Crossing& hit) const {
        const Disk& q = disks[hit.surfel];
        const double cosine = dot(normal, {q.normal[0], q.normal[1], q.normal[2]});
        const bool faces = cosine > 0.0 || (q.twin != no_surfel && cosine != 0.0);
        return !faces || hit.distance() > (hit.is_disk ? 0.5f * q.radius : 0.0f) + 4.0f * q.contact;
    }

    // Is a triangle, of another surfel, too far from both ends of a ray for any of their rules? So are nearly all, and
    // nothing has to be known of that surfel, which is seldom in a cache.
    bool is_amid(const Query& query, const Ray& ray, const Crossing& hit) const {
        if (hit.is_disk || ray.to != no_surfel) return false;
        const float cosine = hit.cosine(), farthest = 2.0f * largest_contact;
        if (!(hit.distance() * cosine > farthest)) return false;
        if (query.segments && !((to_local(ray.length) - hit.distance()) * cosine > farthest)) return false;
        const std::uint32_t from = ray.from.surfel;
        return from == no_surfel ||
               (from != hit.surfel && disks[from].twin != hit.surfel && !backs_of.has(from, hit.surfel));
    }

    // Does the query take no notice of what ray `id` crosses there?
    bool passes(const Query& query, const Crossing& hit, unsigned id) const {
        if (query.but != no_surfel) return goes_on(disks[query.but], disks[hit.surfel]);
        if (query.nearby) return is_strange(*query.nearby, hit);
        const Ray& ray = query.rays[id];
        if (ray.from.surfel == hit.surfel) return true;
        if (is_amid(query, ray, hit)) return false;
        if (ignores(ray.from, hit) || is_over_surface(ray.from.surfel, hit)) return true;
        if (!query.segments) return false;
        if (ends_on(to_local(ray.length), hit)) return true;
        return ray.to != no_surfel &&
               (hit.surfel == ray.to || disks[ray.to].twin == hit.surfel || backs_of.has(ray.to, hit.surfel) ||
                (hit.is_disk && stands_off(ray.to, hit.surfel, hit.direction)));
    }

    // Asks for what the filters look up of the surfel that a ray leaves, while others before it are traced.
    void fetch_ahead(const Ray* rays, std::size_t k, std::size_t count) const {
        constexpr std::size_t ahead = 4;
        if (k + ahead < count && rays[k + ahead].from.surfel != no_surfel)
            __builtin_prefetch(&disks[rays[k + ahead].from.surfel].twin);
    }

    static void filter(const RTCFilterFunctionNArguments* arguments) {
        const auto* query = reinterpret_cast<const Query*>(arguments->context);
        const Impl& impl = *query->impl;
        const unsigned count = arguments->N;
        RTCRayN* ray = arguments->ray;
        for (unsigned n = 0; n < count; ++n) {
            if (arguments->valid[n] != -1) continue;
            const unsigned primitive = RTCHitN_primID(arguments->hit, count, n);
            const bool is_disk = RTCHitN_geomID(arguments->hit, count, n) == disk_geometry;
            const Crossing crossing{
                arguments,
                n,
                is_disk ? primitive : impl.triangle_surfel[primitive],
                is_disk,
                {RTCRayN_dir_x(ray, count, n), RTCRayN_dir_y(ray, count, n), RTCRayN_dir_z(ray, count, n)}};
            if (impl.is_beyond_end(*query, crossing) || impl.passes(*query, crossing, RTCRayN_id(ray, count, n)))
                arguments->valid[n] = 0;
        }
    }

    Hit found(const RTCRayHit& hit, const Vec3& direction) const;

    bool covers(const Hit& hit, const Departure& from) const {
        const float* n = disks[hit.surfel].normal;
        return hit.distance <= contact_of(hit.surfel) && dot(from.normal, {n[0], n[1], n[2]}) < -0.5;
    }

    double contact_of(std::uint32_t surfel) const { return unit * static_cast<double>(disks[surfel].contact); }

    void find_lower(const Scene& of, const Progress& progress);
    bool rises_over(const Surfels& s, std::uint32_t i, std::uint32_t j, double distance) const;
    void add_coplanar(const Scene& scene);
    // Where a ray ends, in `unit` from the origin.
    static Vec3 end_of(const RTCRay& ray) {
        const auto along = [&ray](float from, float direction) {
            return static_cast<double>(from + ray.tfar * direction);
        };
        return {along(ray.org_x, ray.dir_x), along(ray.org_y, ray.dir_y), along(ray.org_z, ray.dir_z)};
    }

    // A border that runs into another object is where the two adjoin: there is no end there.
    void drop_joints(const Progress& progress);

    void to_local(const Vec3& p, float (&out)[3]) const {
        for (int axis = 0; axis < 3; ++axis) out[axis] = static_cast<float>((p[axis] - origin[axis]) / unit);
    }
    float to_local(double length) const {
        return static_cast<float>(std::min(length / unit, double{std::numeric_limits<float>::max()}));
    }

    RTCRay ray_from(const Vec3& from, const Vec3& direction, double length) const {
        float org[3];
        to_local(from, org);
        RTCRay ray;
        ray.org_x = org[0], ray.org_y = org[1], ray.org_z = org[2];
        ray.dir_x = static_cast<float>(direction.x);
        ray.dir_y = static_cast<float>(direction.y);
        ray.dir_z = static_cast<float>(direction.z);
        ray.tnear = 0.0f, ray.tfar = to_local(length);
        ray.time = 0.0f, ray.mask = embree::mask_all, ray.id = 0, ray.flags = 0;
        return ray;
    }

    void closest(const Ray* rays, std::size_t count, Hit* hits) const;
    template <class Bool>
    void free(const Ray* rays, std::size_t count, Bool* free) const;

    void build(const Surfels& surfels, const Progress& progress);
    void add_disks();
    void add_triangles(const Surfels& s);
    void attach(RTCGeometry geometry, unsigned id);
};

}  // namespace surflux
