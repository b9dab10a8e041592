#include <limits>

#include "surflux/trace/tracer.h"
#include "surflux/trace/tracer_impl.h"

namespace surflux {

namespace {

constexpr std::size_t together = 16;

// Ray k of sixteen.
void put(RTCRay16& all, std::size_t k, const RTCRay& ray) {
    all.org_x[k] = ray.org_x, all.org_y[k] = ray.org_y, all.org_z[k] = ray.org_z;
    all.dir_x[k] = ray.dir_x, all.dir_y[k] = ray.dir_y, all.dir_z[k] = ray.dir_z;
    all.tnear[k] = ray.tnear, all.tfar[k] = ray.tfar;
    all.time[k] = ray.time, all.mask[k] = ray.mask, all.id[k] = ray.id, all.flags[k] = ray.flags;
}

// The rest of sixteen: rays that end before they begin. Without AVX-512 Embree 3 takes sixteen for two times eight and
// does not ask which of them are valid.
void fill(RTCRay16& all, std::size_t count) {
    RTCRay none{};
    none.dir_z = 1.0f;
    none.tfar = -std::numeric_limits<float>::infinity();
    for (std::size_t k = count; k < together; ++k) put(all, k, none);
}

RTCRayHit hit_of(const RTCRayHit16& all, std::size_t k) {
    RTCRayHit out;
    out.ray.org_x = all.ray.org_x[k], out.ray.org_y = all.ray.org_y[k], out.ray.org_z = all.ray.org_z[k];
    out.ray.dir_x = all.ray.dir_x[k], out.ray.dir_y = all.ray.dir_y[k], out.ray.dir_z = all.ray.dir_z[k];
    out.ray.tfar = all.ray.tfar[k];
    out.hit.geomID = all.hit.geomID[k], out.hit.primID = all.hit.primID[k];
    return out;
}

// visit(begin, count, valid) for sixteen rays after another, of the last of which some may be none.
template <class Visit>
void by_sixteen(std::size_t count, const Visit& visit) {
    for (std::size_t begin = 0; begin < count; begin += together) {
        const std::size_t n = std::min(together, count - begin);
        alignas(64) int valid[together];
        for (std::size_t k = 0; k < together; ++k) valid[k] = k < n ? -1 : 0;
        visit(begin, n, valid);
    }
}

}  // namespace

Ray segment(const Departure& from, const Vec3& to, std::uint32_t surfel) {
    const Vec3 d = to - from.position;
    const double distance = length(d);
    return {from, distance > 0.0 ? d / distance : Vec3{0, 0, 1}, distance, surfel};
}

void Tracer::Impl::closest(const Ray* rays, std::size_t count, Hit* hits) const {
    Query query{{}, this, rays};
    embree::init(query.context);
    for (std::size_t k = 0; k < count; ++k) {
        fetch_ahead(rays, k, count);
        RTCRayHit hit;
        hit.ray = ray_from(rays[k].from.position, rays[k].direction, rays[k].length);
        hit.ray.id = static_cast<unsigned>(k);
        hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        embree::intersect(scene.get(), query.context, hit);
        hits[k] = found(hit, rays[k].direction);
        if (hits[k].front && covers(hits[k], rays[k].from)) hits[k].front = false;
    }
}

template <class Bool>
void Tracer::Impl::free(const Ray* rays, std::size_t count, Bool* free) const {
    Query query{{}, this, rays, true};
    embree::init(query.context);
    for (std::size_t k = 0; k < count; ++k) {
        fetch_ahead(rays, k, count);
        const double share = rays[k].to == no_surfel ? short_of_target : 1.0;
        RTCRay ray = ray_from(rays[k].from.position, rays[k].direction, rays[k].length * share);
        ray.id = static_cast<unsigned>(k);
        embree::occluded(scene.get(), query.context, ray);
        free[k] = ray.tfar >= 0.0f;  // Embree sets it to -inf on a hit
    }
}

void Tracer::closest_coherent(const std::vector<Ray>& rays, std::vector<Hit>& hits) const {
    hits.resize(rays.size());
    Impl::Query query{{}, impl_.get(), rays.data()};
    embree::init(query.context);
    by_sixteen(rays.size(), [&](std::size_t begin, std::size_t n, const int (&valid)[together]) {
        alignas(64) RTCRayHit16 found;
        for (std::size_t k = 0; k < n; ++k) {
            const Ray& ray = rays[begin + k];
            RTCRay one = impl_->ray_from(ray.from.position, ray.direction, ray.length);
            one.id = static_cast<unsigned>(begin + k);
            put(found.ray, k, one);
            found.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
        }
        fill(found.ray, n);
        embree::intersect(valid, impl_->scene.get(), query.context, found);
        for (std::size_t k = 0; k < n; ++k) {
            Hit& hit = hits[begin + k] = impl_->found(hit_of(found, k), rays[begin + k].direction);
            if (hit.front && impl_->covers(hit, rays[begin + k].from)) hit.front = false;
        }
    });
}

void Tracer::free_coherent(const std::vector<Ray>& rays, std::vector<char>& free) const {
    free.resize(rays.size());
    Impl::Query query{{}, impl_.get(), rays.data(), true};
    embree::init(query.context);
    by_sixteen(rays.size(), [&](std::size_t begin, std::size_t n, const int (&valid)[together]) {
        alignas(64) RTCRay16 found;
        for (std::size_t k = 0; k < n; ++k) {
            const Ray& ray = rays[begin + k];
            const double share = ray.to == no_surfel ? short_of_target : 1.0;
            RTCRay one = impl_->ray_from(ray.from.position, ray.direction, ray.length * share);
            one.id = static_cast<unsigned>(begin + k);
            put(found, k, one);
        }
        fill(found, n);
        embree::occluded(valid, impl_->scene.get(), query.context, found);
        for (std::size_t k = 0; k < n; ++k) free[begin + k] = found.tfar[k] >= 0.0f;
    });
}

Hit Tracer::closest(const Ray& ray) const {
    Hit hit;
    impl_->closest(&ray, 1, &hit);
    return hit;
}

void Tracer::closest(const std::vector<Ray>& rays, std::vector<Hit>& hits) const {
    hits.resize(rays.size());
    impl_->closest(rays.data(), rays.size(), hits.data());
}

bool Tracer::free(const Ray& ray) const {
    bool free = false;
    impl_->free(&ray, 1, &free);
    return free;
}

void Tracer::free(const std::vector<Ray>& rays, std::vector<char>& free) const {
    free.resize(rays.size());
    impl_->free(rays.data(), rays.size(), free.data());
}

Departure Tracer::on(std::uint32_t surfel, const Vec3& point) const {
    const float* n = impl_->disks[surfel].normal;
    return {point, {n[0], n[1], n[2]}, surfel};
}

Departure Tracer::departure(const Vec3& point, const Vec3& normal) const {
    Impl::Query query{{}, impl_.get()};
    query.nearby = &normal;
    embree::init(query.context);
    Departure out{point, normal, no_surfel};
    double nearest = std::numeric_limits<double>::infinity();
    // A ray may miss what it begins on.
    const double before = 2.0 * impl_->extent.contact(point);
    for (const Vec3& direction : {normal, -normal}) {
        RTCRayHit hit;
        hit.ray = impl_->ray_from(point - before * direction, direction, impl_->diameter);
        hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        embree::intersect(impl_->scene.get(), query.context, hit);
        const Hit found = impl_->found(hit, direction);
        if (!found || std::abs(found.distance - before) >= nearest) continue;
        nearest = std::abs(found.distance - before);
        out.surfel = found.surfel;
    }
    // Of a sheet, the side that faces the way of the point.
    if (out.surfel != no_surfel) {
        const Impl::Disk& disk = impl_->disks[out.surfel];
        if (dot(normal, {disk.normal[0], disk.normal[1], disk.normal[2]}) < 0.0)
            out.surfel = disk.twin != no_surfel
                             ? disk.twin
                             : impl_->backs_of.find(out.surfel, (point - impl_->origin) / impl_->unit);
    }
    return out;
}

}  // namespace surflux
