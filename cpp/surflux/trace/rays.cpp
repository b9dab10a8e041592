#include "surflux/trace/tracer.h"
#include "surflux/trace/tracer_impl.h"

namespace surflux {

Ray segment(const Departure& from, const Vec3& to, std::uint32_t surfel) {
    const Vec3 d = to - from.position;
    const double distance = length(d);
    return {from, distance > 0.0 ? d / distance : Vec3{0, 0, 1}, distance, surfel};
}

void Tracer::Impl::closest(const Ray* rays, std::size_t count, Hit* hits) const {
    Query query{{}, this, rays};
    embree::init(query.context);
    for (std::size_t k = 0; k < count; ++k) {
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
        const double share = rays[k].to == no_surfel ? short_of_target : 1.0;
        RTCRay ray = ray_from(rays[k].from.position, rays[k].direction, rays[k].length * share);
        ray.id = static_cast<unsigned>(k);
        embree::occluded(scene.get(), query.context, ray);
        free[k] = ray.tfar >= 0.0f;  // Embree sets it to -inf on a hit
    }
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
