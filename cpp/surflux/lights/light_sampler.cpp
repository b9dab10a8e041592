#include "surflux/lights/light_sampler.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/morton.h"
#include "surflux/core/sampling.h"
#include "surflux/lights/polygon.h"

namespace surflux {

namespace {

// Of light that may be below 0, as skies made of some harmonics are, by its size.
double brightness(const Rgb& c) { return std::abs(c.x) + std::abs(c.y) + std::abs(c.z); }

// MIS share of a direction drawn with density cos / pi.
struct CosineShare {
    double cosine;
    double operator()(double other) const { return cosine / (cosine + pi * other); }
};

constexpr double golden = 0.6180339887498949;  // turns of a square's side that spread candidates evenly

}  // namespace

LightSampler::LightSampler(const Scene& scene, double small_emitters, Sources sources)
    : surfels_(scene.surfels), whole_images_(sources == Sources::whole_images) {
    for (const Light& light : scene.lights) {
        if (sources == Sources::surfels) break;
        if (sources == Sources::constant_sky) {
            const auto* p = std::get_if<Environment>(&light);
            if (p && p->pixels.empty()) constant_sky_ += p->radiance;
            continue;
        }
        if (const auto* p = std::get_if<PointLight>(&light))
            point_like_.push_back({PointLike::point, p->position, p->intensity, SpotCone({})});
        if (const auto* p = std::get_if<SpotLight>(&light))
            point_like_.push_back({PointLike::spot, p->position, p->intensity, SpotCone(*p)});
        if (const auto* p = std::get_if<DirectionalLight>(&light))
            point_like_.push_back({PointLike::distant, -p->direction, p->irradiance, SpotCone({})});
        if (const auto* p = std::get_if<AreaLight>(&light)) {
            const Vec3 across = cross(p->edge_u, p->edge_v);
            const double area = length(across);
            if (area > 0.0) areas_.push_back({p->corner, p->edge_u, p->edge_v, across / area, area, p->exitance});
        }
        if (const auto* p = std::get_if<Environment>(&light)) {
            if (p->pixels.empty())
                constant_sky_ += p->radiance;
            else
                images_.emplace_back(*p);
        }
    }

    if (sources == Sources::constant_sky) return;
    const std::vector<std::uint32_t> begin = triangle_ranges(surfels_);
    double all = 0.0, emitting = 0.0;
    std::vector<Piece> pieces;
    std::vector<double> powers;
    std::vector<Vec3> places;
    const auto add = [&](const Piece& piece, double area) {
        all += area;
        const double weight = brightness(surfels_.emission[piece.surfel]);
        if (!(weight > 0.0) || !(area > 0.0)) return;
        emitting += area;
        pieces.push_back(piece);
        powers.push_back(weight * area);
        places.push_back(piece.is_disk ? piece.a : (piece.a + piece.b + piece.c) / 3.0);
    };
    for (std::uint32_t i = 0; i < surfels_.size(); ++i) {
        if (begin[i] == begin[i + 1]) {
            const double r = surfels_.radii[i];
            add({i, true, surfels_.positions[i], {r, r, r}, {}, surfels_.normals[i]}, pi * r * r);
        }
        for (std::uint32_t k = begin[i]; k < begin[i + 1]; ++k) {
            const Triangle& t = surfels_.triangles[k];
            const double area = area_of(t);
            add({i, false, t.a, t.b, t.c, area > 0.0 ? cross_of(t) / (2.0 * area) : surfels_.normals[i]}, area);
        }
    }
    if (emitting > small_emitters * all) return;
    // Neighbours stand together, so that evenly spread numbers are evenly spread places; a mesh's own order may be
    // periodic, and then all samples of a batch would fall on like places.
    for (std::uint32_t k : morton_order(places)) {
        emitters_.push_back(pieces[k]);
        if (pieces[k].is_disk) candidates_ = 1;
        emitters_up_to_.push_back(power_ += powers[k]);
    }
    for (double& up_to : emitters_up_to_) up_to /= power_;
}

template <class Weigh>
LightRay LightSampler::resampled(const Vec3& point, const Vec3& normal, double u, double v, double choice,
                                 const Weigh& weigh) const {
    // Reservoir of one. Given the candidates, each is kept with its share p of their sum and brings irradiance / p,
    // which is the sum of them all in the mean.
    LightRay kept;
    double kept_weight = 0.0, sum = 0.0;
    const auto offer = [&](LightRay ray, bool is_of_lamp) {
        weigh(ray);
        const double weight = brightness(ray.irradiance);
        if (!(weight > 0.0)) return;
        sum += weight;
        const double share = weight / sum;
        if (choice < share) {
            kept = ray;
            kept.is_of_lamp = is_of_lamp;
            kept_weight = weight;
            choice /= share;
        } else {
            choice = (choice - share) / (1.0 - share);
        }
    };
    for (const PointLike& light : point_like_) offer(towards(light, point, normal), true);
    for (const Rectangle& light : areas_) offer(towards(light, point, normal, u, v), true);
    for (std::size_t k = 0; k < images_.size(); ++k) offer(towards_sky(k, normal, u, v), false);
    for (int k = 0; k < candidates_ && !emitters_.empty(); ++k)
        offer(towards_emitters(point, normal, (k + u) / candidates_, std::fmod(v + k * golden, 1.0)), false);
    if (kept_weight > 0.0) kept.irradiance *= sum / kept_weight;
    return kept;
}

LightRay LightSampler::sample(const Vec3& point, const Vec3& normal, double u, double v, double choice) const {
    return resampled(point, normal, u, v, choice, [](const LightRay&) {});
}

// Irradiance I = L cos / (p + cos / pi) of radiance L gives way to L value / (p + q) for q the lobe's own density, and
// L cos / p of a light without extent to L value / p.
LightRay LightSampler::sample(const Vec3& point, const GlossyLobe& lobe, double u, double v, double choice) const {
    return resampled(point, lobe.normal(), u, v, choice, [&](LightRay& ray) {
        const double cosine = dot(lobe.normal(), ray.direction);
        if (!(cosine > 0.0)) return;
        const double p = ray.density;
        const double scale = p > 0.0 ? (p + cosine / pi) / (p + lobe.density(ray.direction)) : 1.0;
        ray.irradiance = (scale / cosine) * (lobe.value(ray.direction) * ray.irradiance);
    });
}

Rgb LightSampler::unoccluded(const Vec3& point, const Vec3& normal) const {
    Rgb out;
    for (const PointLike& light : point_like_) out += towards(light, point, normal).irradiance;
    for (const Rectangle& light : areas_) {
        if (dot(light.normal, point - light.corner) <= 0.0) continue;
        const Vec3 corners[] = {light.corner, light.corner + light.u, light.corner + light.u + light.v,
                                light.corner + light.v};
        out += element_to_polygon(point, normal, corners, 4) * light.exitance;
    }
    return out;
}

Rgb LightSampler::found(const Vec3& point, const GlossyLobe& lobe, const Vec3& direction, const Hit& hit) const {
    const Rgb value = lobe.value(direction) / pi;
    const double density = lobe.density(direction);
    const auto share = [&](double other) { return value / (density + other); };
    return shares_on_way(point, direction, hit, share) + shares_at_end(direction, hit, share);
}

Rgb LightSampler::found_on_way(const Vec3& point, const Vec3& normal, const Vec3& direction, const Hit& hit) const {
    return shares_on_way(point, direction, hit, CosineShare{dot(normal, direction)});
}

Rgb LightSampler::found_at_end(const Vec3& normal, const Vec3& direction, const Hit& hit) const {
    return shares_at_end(direction, hit, CosineShare{dot(normal, direction)});
}

template <class Share>
Rgb LightSampler::shares_on_way(const Vec3& point, const Vec3& direction, const Hit& hit, const Share& share) const {
    Rgb out;
    for (const Rectangle& light : areas_) {
        const double facing = -dot(light.normal, direction);
        if (facing <= 0.0) continue;
        const double distance = dot(point - light.corner, light.normal) / facing;
        if (distance <= 0.0 || (hit && distance * short_of_target >= hit.distance)) continue;
        const Vec3 across = point + distance * direction - light.corner;
        const double s = dot(across, light.u) / length_squared(light.u);
        const double t = dot(across, light.v) / length_squared(light.v);
        if (s < 0.0 || s >= 1.0 || t < 0.0 || t >= 1.0) continue;
        const double other = distance * distance / (facing * light.area);
        out += share(other) * light.exitance;
    }
    return out;
}

template <class Share>
Rgb LightSampler::shares_at_end(const Vec3& direction, const Hit& hit, const Share& share) const {
    Rgb out;
    if (!hit) {
        out += share(0.0) * (pi * constant_sky_);
        for (std::size_t k = 0; k < images_.size() && !whole_images_; ++k)
            out += (pi * share(images_[k].density(direction))) * images_[k].radiance(direction);
    } else if (hit.front) {
        const Rgb& emission = surfels_.emission[hit.surfel];
        if (brightness(emission) <= 0.0) return emission;
        const double other = emitters_.empty() ? 0.0 : emitter_density(hit.surfel, direction, hit.distance);
        out += share(other) * emission;
    }
    return out;
}

LightRay LightSampler::towards(const PointLike& light, const Vec3& point, const Vec3& normal) const {
    if (light.kind == PointLike::distant)
        return {light.place, Ray{}.length, std::max(0.0, dot(normal, light.place)) * light.color};
    const Vec3 d = light.place - point;
    const double distance = length(d), cosine = dot(normal, d) / distance;
    if (!(cosine > 0.0)) return {};
    const double share = light.kind == PointLike::spot ? light.cone.share(-d) : 1.0;
    return {d / distance, distance, (share * cosine / (distance * distance)) * light.color};
}

// The irradiance that a ray of density p brings, E / pi cos / p, times its share p / (p + cos / pi).
LightRay LightSampler::towards(const Rectangle& light, const Vec3& point, const Vec3& normal, double u,
                               double v) const {
    const Vec3 d = light.corner + u * light.u + v * light.v - point;
    const double distance = length(d), cosine = dot(normal, d) / distance, facing = -dot(light.normal, d) / distance;
    if (!(cosine > 0.0 && facing > 0.0)) return {};
    const double density = distance * distance / (facing * light.area);
    const Rgb irradiance = (cosine / (pi * density + cosine)) * light.exitance;
    return {d / distance, distance, irradiance, Hit::none, false, density};
}

LightRay LightSampler::towards_sky(std::size_t image, const Vec3& normal, double u, double v) const {
    const Vec3 direction = images_[image].sample(u, v);
    const double cosine = dot(normal, direction), density = images_[image].density(direction);
    if (!(cosine > 0.0 && density > 0.0)) return {};
    const double of_others = whole_images_ ? 0.0 : cosine / pi;
    const Rgb irradiance = (cosine / (density + of_others)) * images_[image].radiance(direction);
    return {direction, Ray{}.length, irradiance, Hit::none, false, density};
}

LightRay LightSampler::towards_emitters(const Vec3& point, const Vec3& normal, double u, double v) const {
    const auto at = std::upper_bound(emitters_up_to_.begin(), emitters_up_to_.end() - 1, u);
    const double below = at == emitters_up_to_.begin() ? 0.0 : at[-1];
    const Piece& piece = emitters_[static_cast<std::size_t>(at - emitters_up_to_.begin())];
    u = std::clamp((u - below) / (*at - below), 0.0, 1.0 - 1e-12);
    Vec3 place;
    if (piece.is_disk) {
        const Frame frame = frame_around(piece.normal);
        double x, y;
        square_to_disk(u, v, x, y);
        place = piece.a + piece.b.x * (x * frame.u + y * frame.v);
    } else {
        const Vec3 w = square_to_triangle(u, v);
        place = w.x * piece.a + w.y * piece.b + w.z * piece.c;
    }
    const Vec3 d = place - point;
    const double distance = length(d), cosine = dot(normal, d) / distance;
    // Patches that are not quite flat: the density of the place is by the triangle, the shares by the surfel's normal,
    // which is what found() knows.
    const double facing = std::abs(dot(piece.normal, d)) / distance;
    if (!(cosine > 0.0 && facing > 0.0 && dot(surfels_.normals[piece.surfel], d) < 0.0)) return {};
    const Vec3 direction = d / distance;
    const double density = candidates_ * emitter_density(piece.surfel) * distance * distance / facing;
    const double weighed = emitter_density(piece.surfel, direction, distance);
    const double share = pi * weighed / (pi * weighed + cosine);
    const Rgb irradiance = (cosine / (pi * density) * share) * surfels_.emission[piece.surfel];
    return {direction, Ray{}.length, irradiance, piece.surfel, false, weighed};
}

double LightSampler::emitter_density(std::uint32_t surfel) const {
    return brightness(surfels_.emission[surfel]) / power_;
}

double LightSampler::emitter_density(std::uint32_t surfel, const Vec3& direction, double distance) const {
    const double facing = std::max(1e-12, -dot(surfels_.normals[surfel], direction));
    return candidates_ * emitter_density(surfel) * distance * distance / facing;
}

}  // namespace surflux
