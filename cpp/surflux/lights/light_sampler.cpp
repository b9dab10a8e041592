#include "surflux/lights/light_sampler.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "surflux/core/morton.h"
#include "surflux/core/sampling.h"
#include "surflux/lights/polygon.h"

namespace surflux {

namespace {

// MIS share of a direction drawn with density cos / pi.
struct CosineShare {
    double cosine;
    double operator()(double other) const { return cosine / (cosine + pi * other); }
};

constexpr std::size_t most_clusters = 8;
constexpr std::size_t most_edges = 256;        // of emissive patches in closed form: as much as many rays
constexpr double least_gap = 0.05;             // of the side of a cluster
constexpr double outstanding = 8.0;            // times the mean exitance: an eighth of what shines at most
constexpr double golden = 0.6180339887498949;  // turns of a square's side that spread candidates evenly

}  // namespace

LightSampler LightSampler::of_surfels(const Scene& scene) {
    return LightSampler(scene, usual_small_emitters, Sources::surfels);
}

struct LightSampler::Emitting {
    Piece piece;
    Vec3 place;
    double area, exitance;
};

LightSampler::LightSampler(const Scene& scene, double small_emitters, Sources sources)
    : surfels_(scene.surfels),
      whole_images_(sources == Sources::whole_images),
      surfels_alone_(sources == Sources::surfels) {
    // One that sends nothing takes no light samples of others.
    for (const Light& light : scene.lights) {
        if (sources == Sources::surfels) break;
        if (sources == Sources::constant_sky) {
            const auto* p = std::get_if<Environment>(&light);
            if (p && p->pixels.empty()) constant_sky_ += p->radiance;
            continue;
        }
        if (const auto* p = std::get_if<PointLight>(&light); p && brightness(p->intensity) > 0.0)
            point_like_.push_back({PointLike::point, p->position, p->intensity, SpotCone({})});
        if (const auto* p = std::get_if<SpotLight>(&light); p && brightness(p->intensity) > 0.0)
            point_like_.push_back({PointLike::spot, p->position, p->intensity, SpotCone(*p)});
        if (const auto* p = std::get_if<PhotometricLight>(&light); p && brightness(p->intensity) > 0.0) {
            point_like_.push_back({PointLike::photometric, p->position, p->intensity, SpotCone({}), webs_.size()});
            webs_.emplace_back(*p);
        }
        if (const auto* p = std::get_if<DirectionalLight>(&light); p && brightness(p->irradiance) > 0.0)
            point_like_.push_back({PointLike::distant, -p->direction, p->irradiance, SpotCone({})});
        if (const auto* p = std::get_if<AreaLight>(&light); p && brightness(p->exitance) > 0.0) {
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
    double all = 0.0, area_emitting = 0.0, power = 0.0;
    std::vector<Emitting> emitting;
    const auto add = [&](const Piece& piece, double area) {
        all += area;
        const double exitance = brightness(surfels_.emission[piece.surfel]);
        if (!(exitance > 0.0) || !(area > 0.0)) return;
        area_emitting += area;
        power += exitance * area;
        emitting.push_back({piece, surfels_.positions[piece.surfel], area, exitance});
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
    if (area_emitting > small_emitters * all) {
        const double least = outstanding * power / area_emitting;
        emitting.erase(std::remove_if(emitting.begin(), emitting.end(),
                                      [&](const Emitting& one) { return !(one.exitance > least); }),
                       emitting.end());
        double bright = 0.0;
        for (const Emitting& one : emitting) bright += one.area;
        if (bright > small_emitters * all) emitting.clear();
    }
    if (!emitting.empty()) take_emitters(emitting);
    number_groups();
    if (surfels_alone_ && candidates_ > 1) find_facets();
}

// Clusters are split where the gap between surfels is widest, if it is no small part of them.
void LightSampler::take_emitters(const std::vector<Emitting>& emitting) {
    sampled_.resize(surfels_.size());
    cluster_of_.resize(surfels_.size());
    // Neighbours stand together, so that evenly spread numbers are evenly spread places; a mesh's own order may be
    // periodic, and then all samples of a batch would fall on like places. Pieces of a surfel stay together.
    std::vector<Vec3> places;
    for (const Emitting& one : emitting) places.push_back(one.place);
    std::vector<std::vector<std::uint32_t>> parts{morton_order(places)};
    struct Gap {
        double width = 0.0, at = 0.0;
        int axis = 0;
    };
    const auto widest_gap = [&](const std::vector<std::uint32_t>& part) {
        Gap out;
        std::vector<std::pair<double, double>> spans;
        for (int axis = 0; axis < 3; ++axis) {
            spans.clear();
            for (const std::uint32_t k : part) {
                const double r = surfels_.radii[emitting[k].piece.surfel];
                spans.push_back({places[k][axis] - r, places[k][axis] + r});
            }
            std::sort(spans.begin(), spans.end());
            double end = spans.front().second, last = end;
            for (const auto& span : spans) last = std::max(last, span.second);
            for (const auto& [from, to] : spans) {
                const double gap = from - end;
                if (gap > out.width && gap > least_gap * (last - spans.front().first))
                    out = {gap, end + 0.5 * gap, axis};
                end = std::max(end, to);
            }
        }
        return out;
    };
    while (parts.size() < most_clusters) {
        Gap widest;
        std::size_t which = 0;
        for (std::size_t p = 0; p < parts.size(); ++p)
            if (const Gap gap = widest_gap(parts[p]); gap.width > widest.width) widest = gap, which = p;
        if (!(widest.width > 0.0)) break;
        std::vector<std::uint32_t> low, high;
        for (const std::uint32_t k : parts[which]) (places[k][widest.axis] < widest.at ? low : high).push_back(k);
        parts[which] = std::move(low);
        parts.push_back(std::move(high));
    }
    for (const std::vector<std::uint32_t>& part : parts) {
        Cluster cluster{static_cast<std::uint32_t>(emitters_.size()), 0};
        for (const std::uint32_t k : part) {
            const Piece& piece = emitting[k].piece;
            emitters_.push_back(piece);
            if (piece.is_disk) candidates_ = 1;
            emitters_up_to_.push_back(cluster.power += emitting[k].exitance * emitting[k].area);
            sampled_[piece.surfel] = 1;
            cluster_of_[piece.surfel] = static_cast<std::uint8_t>(clusters_.size());
        }
        cluster.end = static_cast<std::uint32_t>(emitters_.size());
        for (std::uint32_t k = cluster.begin; k < cluster.end; ++k) emitters_up_to_[k] /= cluster.power;
        clusters_.push_back(cluster);
    }
}

// Suns and skies first: they are the strongest, and walls often stand before them.
void LightSampler::number_groups() {
    const auto next = [&] {
        const int group = std::min(groups_, most_groups - 1);
        groups_ = group + 1;
        return group;
    };
    for (PointLike& light : point_like_)
        if (light.kind == PointLike::distant) light.group = next();
    for (std::size_t k = 0; k < images_.size(); ++k) image_groups_.push_back(next());
    for (Cluster& cluster : clusters_) cluster.group = next();
    for (Rectangle& light : areas_) light.group = next();
    for (PointLike& light : point_like_)
        if (light.kind != PointLike::distant) light.group = next();
}

void LightSampler::find_facets() {
    if (emitters_.empty()) return;
    std::vector<EmissiveFacets::Piece> pieces;
    for (const Piece& p : emitters_)
        pieces.push_back(
            {{p.a, p.b, p.c}, p.normal, surfels_.emission[p.surfel], p.surfel, clusters_[cluster_of_[p.surfel]].group});
    facets_.emplace(pieces, groups_);
    if (facets_->edges() > most_edges) facets_.reset();
}

template <class Weigh>
LightRay LightSampler::resampled(const Vec3& point, const Vec3& normal, double u, double v, double choice, int group,
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
    const auto is_asked = [&](int of) { return group == all_groups || group == of; };
    for (const PointLike& light : point_like_)
        if (is_asked(light.group)) offer(towards(light, point, normal), true);
    for (const Rectangle& light : areas_)
        if (is_asked(light.group)) offer(towards(light, point, normal, u, v), true);
    for (std::size_t k = 0; k < images_.size(); ++k)
        if (is_asked(image_groups_[k])) offer(towards_sky(k, normal, u, v), false);
    // Asked for together, clusters share the candidates.
    const int count = group == all_groups
                          ? std::max(1, candidates_ / static_cast<int>(std::max<std::size_t>(1, clusters_.size())))
                          : candidates_;
    for (const Cluster& cluster : clusters_)
        for (int k = 0; k < count && is_asked(cluster.group); ++k)
            offer(towards_emitters(cluster, count, point, normal, (k + u) / count, std::fmod(v + k * golden, 1.0)),
                  false);
    if (kept_weight > 0.0) kept.irradiance *= sum / kept_weight;
    return kept;
}

LightRay LightSampler::sample(const Vec3& point, const Vec3& normal, double u, double v, double choice,
                              int group) const {
    return resampled(point, normal, u, v, choice, group, [](const LightRay&) {});
}

// Irradiance I = L cos / (p + cos / pi) of radiance L gives way to L value / (p + q) for q the lobe's own density, and
// L cos / p of a light without extent to L value / p.
LightRay LightSampler::sample(const Vec3& point, const GlossyLobe& lobe, double u, double v, double choice,
                              int group) const {
    return resampled(point, lobe.normal(), u, v, choice, group, [&](LightRay& ray) {
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
        if (!light.lights(point)) continue;
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
        if (!light.lights(point) || (hit && distance * short_of_target >= hit.distance)) continue;
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
        const bool is_sampled = samples(hit.surfel);
        if (surfels_alone_ && !is_sampled) return out;
        const double other = is_sampled ? emitter_density(hit.surfel, direction, hit.distance) : 0.0;
        out += share(other) * emission;
    }
    return out;
}

bool LightSampler::Rectangle::lights(const Vec3& point) const {
    return dot(normal, point - corner) > no_height(point, corner, std::max(length(u), length(v)));
}

LightRay LightSampler::towards(const PointLike& light, const Vec3& point, const Vec3& normal) const {
    if (light.kind == PointLike::distant)
        return {light.place, Ray{}.length, std::max(0.0, dot(normal, light.place)) * light.color};
    const Vec3 d = light.place - point;
    const double distance = length(d), cosine = dot(normal, d) / distance;
    if (!(cosine > 0.0)) return {};
    const double share = light.kind == PointLike::spot          ? light.cone.share(-d)
                         : light.kind == PointLike::photometric ? webs_[light.web].share(-d)
                                                                : 1.0;
    return {d / distance, distance, (share * cosine / (distance * distance)) * light.color};
}

// The irradiance that a ray of density p brings, E / pi cos / p, times its share p / (p + cos / pi).
LightRay LightSampler::towards(const Rectangle& light, const Vec3& point, const Vec3& normal, double u,
                               double v) const {
    const Vec3 d = light.corner + u * light.u + v * light.v - point;
    const double distance = length(d), cosine = dot(normal, d) / distance, facing = -dot(light.normal, d) / distance;
    if (!(cosine > 0.0 && facing > 0.0) || !light.lights(point)) return {};
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

LightRay LightSampler::towards_emitters(const Cluster& cluster, int candidates, const Vec3& point, const Vec3& normal,
                                        double u, double v) const {
    const auto first = emitters_up_to_.begin() + cluster.begin, last = emitters_up_to_.begin() + cluster.end;
    const auto at = std::upper_bound(first, last - 1, u);
    const double below = at == first ? 0.0 : at[-1];
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
    const double density = candidates * emitter_density(piece.surfel) * distance * distance / facing;
    const double weighed = emitter_density(piece.surfel, direction, distance);
    const double share = pi * weighed / (pi * weighed + cosine);
    const Rgb irradiance = (cosine / (pi * density) * share) * surfels_.emission[piece.surfel];
    return {direction, Ray{}.length, irradiance, piece.surfel, false, weighed};
}

double LightSampler::emitter_density(std::uint32_t surfel) const {
    return brightness(surfels_.emission[surfel]) / clusters_[cluster_of_[surfel]].power;
}

double LightSampler::emitter_density(std::uint32_t surfel, const Vec3& direction, double distance) const {
    const double facing = std::max(1e-12, -dot(surfels_.normals[surfel], direction));
    return candidates_ * emitter_density(surfel) * distance * distance / facing;
}

}  // namespace surflux
