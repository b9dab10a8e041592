#include "surflux/trace/tracer.h"
#include "surflux/trace/tracer_impl.h"

namespace surflux {

void Tracer::closest(const std::vector<Ray>& rays, std::vector<Hit>& hits) const {
    hits.resize(rays.size());
    Impl::Query query{{}, impl_.get(), nullptr, no_surfel, rays.data()};
    embree::init(query.context);
    for (std::size_t k = 0; k < rays.size(); ++k) {
        RTCRayHit hit;
        hit.ray = impl_->ray_from(rays[k].from.position, rays[k].direction, rays[k].length);
        hit.ray.id = static_cast<unsigned>(k);
        hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        embree::intersect(impl_->scene.get(), query.context, hit);
        hits[k] = impl_->found(hit, rays[k].direction);
    }
}

void Tracer::free(const std::vector<Ray>& rays, std::vector<char>& free) const {
    free.resize(rays.size());
    Impl::Query query{{}, impl_.get(), nullptr, no_surfel, rays.data()};
    query.segments = true;
    embree::init(query.context);
    for (std::size_t k = 0; k < rays.size(); ++k) {
        RTCRay ray = impl_->ray_from(rays[k].from.position, rays[k].direction, rays[k].length);
        ray.id = static_cast<unsigned>(k);
        embree::occluded(impl_->scene.get(), query.context, ray);
        free[k] = ray.tfar >= 0.0f;
    }
}

Departure Tracer::departure(const Vec3& point, const Vec3& normal) const {
    Impl::Query query{{}, impl_.get(), nullptr, no_surfel};
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
    // Of a two-sided sheet, the side that faces the way of the point.
    if (out.surfel != no_surfel) {
        const Impl::Disk& disk = impl_->disks[out.surfel];
        if (dot(normal, {disk.normal[0], disk.normal[1], disk.normal[2]}) < 0.0) out.surfel = disk.twin;
    }
    return out;
}

}  // namespace surflux
