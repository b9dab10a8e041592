#include "surflux/meshless/hemisphere_gather.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/parallel.h"
#include "surflux/core/sampling.h"
#include "surflux/lights/hemisphere.h"

namespace surflux {

namespace {

constexpr std::uint64_t gather_stream = 0x6a71e4, light_stream = 0x11647;
// A patch on which about this many rays end or more is not sent by its mean: it is nearer than light may change on it.
constexpr double rays_on_a_patch = 4.0;

}  // namespace

// Shares of all functions, of which most are 0.
class HemisphereGather::Sums {
public:
    // Those of this thread, anew also after a pass that was left by an exception.
    static Sums& of_thread(std::size_t functions) {
        thread_local Sums sums;
        for (const std::uint32_t function : sums.touched_) sums.sums_[function] = {};
        sums.touched_.clear();
        if (sums.sums_.size() < functions) sums.sums_.resize(functions);
        return sums;
    }
    void add(std::uint32_t function, double weight, const float (&share)[3]) {
        Sum& sum = sums_[function];
        if (!sum.touched) {
            sum.touched = true;
            touched_.push_back(function);
        }
        for (int c = 0; c < 3; ++c) sum.share[c] += weight * static_cast<double>(share[c]);
    }
    // Appends them by function, and begins anew.
    void take(std::vector<Link>& out) {
        std::sort(touched_.begin(), touched_.end());
        out.reserve(out.size() + touched_.size());
        for (const std::uint32_t function : touched_) {
            Sum& sum = sums_[function];
            out.push_back({function,
                           {static_cast<float>(sum.share[0]), static_cast<float>(sum.share[1]),
                            static_cast<float>(sum.share[2])}});
            sum = {};
        }
        touched_.clear();
    }

    std::vector<BasisWeight> weights;
    std::vector<Ray> rays, towards;
    std::vector<Hit> hits;
    std::vector<LightRay> light;
    std::vector<Rgb> gain;
    std::vector<char> second_half;

private:
    struct Sum {
        double share[3] = {};
        bool touched = false;
    };
    std::vector<Sum> sums_;
    std::vector<std::uint32_t> touched_;
};

HemisphereGather::HemisphereGather(const Scene& scene, const Tracer& tracer, const SurfaceLight& light,
                                   const MultilevelBasis& basis, const SurfelMeans& means, const GatherOptions& options)
    : scene_(scene),
      tracer_(tracer),
      light_(light),
      basis_(basis),
      means_(means),
      options_(options),
      contact_(contact_distance(bounds_of(scene.surfels))) {}

// A wide patch does where it is small as seen from `distance`, any other surfel always; but what seems to be inside
// geometry, which has no mean.
bool HemisphereGather::sends_by_mean(std::uint32_t surfel, double distance) const {
    if (means_.outside(surfel) == 0.0) return false;
    const double radius = scene_.surfels.radii[surfel];
    return !means_.is_wide(surfel) || pi * radius * radius < options_.epsilon_omega * distance * distance;
}

// Links an end to the levels from `first_level` on, until supports are small. Would it go on to a finer level?
bool HemisphereGather::link(std::size_t first_level, const OpenEnd& end, Sums& sums) const {
    const Vec3& normal = scene_.surfels.normals[end.surfel];
    const double squared = static_cast<double>(end.distance) * static_cast<double>(end.distance);
    for (std::size_t level = first_level; level < basis_.levels(); ++level) {
        basis_.at_level(level, end.position, normal, scene_.object[end.surfel], sums.weights);
        if (sums.weights.empty()) return false;  // finer levels lie within
        double support = 0.0;
        for (const BasisWeight& w : sums.weights) {
            sums.add(w.function, w.weight, end.share);
            const double radius = basis_.radius(level, w.function);
            support += radius * radius;
        }
        support *= pi / static_cast<double>(sums.weights.size());
        if (support < options_.epsilon_omega * squared) return false;
    }
    return true;
}

void HemisphereGather::shoot(const Place& place, int count, Sums& sums, Gathered& out) const {
    const Surfels& s = scene_.surfels;
    const double each = 1.0 / count;
    cosine_rays(light_.points(), place, count, options_.seed + gather_stream, sums.rays);
    tracer_.closest(sums.rays, sums.hits);
    sums.towards.clear(), sums.light.clear(), sums.gain.clear(), sums.second_half.clear();
    out.row.share = each;
    Random random(options_.seed + light_stream, stream_of(place));
    Rgb halves[2];
    for (std::size_t k = 0; k < sums.rays.size(); ++k) {
        const Ray& ray = sums.rays[k];
        const Hit& hit = sums.hits[k];
        const auto take = [&](Rgb& to, const Rgb& light) {
            to += light;
            halves[2 * k >= sums.rays.size()] += light;
        };
        const auto found = [&](const LightSampler& lights) {
            return each * lights.found(ray.from.position, place.normal, ray.direction, hit);
        };
        if (!hit || absorbs(hit, place.normal, s, contact_)) {
            out.row.left += each;
            if (!hit) take(out.row.sky, found(light_.skies()));
            continue;
        }
        const std::uint32_t i = hit.surfel;
        take(out.row.emitted, light_.emitters().empty() ? each * s.emission[i] : found(light_.emitters()));
        const Rgb rho = each * s.reflectance[i];
        if (rho == Rgb{}) continue;
        const Vec3 at = ray.from.position + hit.distance * ray.direction;
        if (!options_.direct_in_basis && !light_.is_dark()) {
            const double radius = s.radii[i];
            if (light_.points().is_patch(i) &&
                radius * radius * count > rays_on_a_patch * hit.distance * hit.distance) {
                const double u[3] = {random.uniform(), random.uniform(), random.uniform()};
                const LightRay light = light_.towards(at, s.normals[i], u);
                if (light.length > 0.0) {
                    sums.towards.push_back({{at, s.normals[i], i}, light.direction, light.length});
                    sums.light.push_back(light);
                    sums.gain.push_back(rho * light.irradiance);
                    sums.second_half.push_back(2 * k >= sums.rays.size());
                }
            } else {
                take(out.row.first, rho * light_.at_surfel(i));
            }
        }
        if (sends_by_mean(i, hit.distance)) {
            out.senders.push_back(i);
            continue;
        }
        OpenEnd end{at, i, static_cast<float>(hit.distance), {}};
        for (int c = 0; c < 3; ++c) end.share[c] = static_cast<float>(rho[c]);
        if (link(0, end, sums)) out.open.push_back(end);
    }
    tracer_.closest(sums.towards, sums.hits);
    for (std::size_t k = 0; k < sums.towards.size(); ++k) {
        if (!sums.light[k].arrives(sums.hits[k])) continue;
        out.row.first += sums.gain[k];
        halves[sums.second_half[k] != 0] += sums.gain[k];
    }
    out.row.noise = std::abs(luminance(halves[0] - halves[1]));
    std::sort(out.senders.begin(), out.senders.end());
    out.senders.shrink_to_fit();
    sums.take(out.links);
}

void HemisphereGather::add(const std::vector<Place>& places, const std::vector<int>& counts, const Progress& progress) {
    const std::size_t before = rows_.size();
    rows_.resize(before + places.size());
    levels_ = basis_.levels();
    parallel_blocks(
        places.size(), 8,
        [&](std::size_t begin, std::size_t end) {
            Sums& sums = Sums::of_thread(basis_.size());
            for (std::size_t k = begin; k < end; ++k) shoot(places[k], counts[k], sums, rows_[before + k]);
        },
        progress);
    count_links();
    for (const int count : counts) rays_ += static_cast<std::size_t>(count);
}

void HemisphereGather::extend(const Progress& progress) {
    parallel_blocks(
        rows_.size(), 64,
        [&](std::size_t begin, std::size_t end) {
            Sums& sums = Sums::of_thread(basis_.size());
            for (std::size_t k = begin; k < end; ++k) {
                Gathered& row = rows_[k];
                row.open.erase(std::remove_if(row.open.begin(), row.open.end(),
                                              [&](const OpenEnd& e) { return !link(levels_, e, sums); }),
                               row.open.end());
                sums.take(row.links);
            }
        },
        progress);
    levels_ = basis_.levels();
    count_links();
}

std::vector<HemisphereGather::Once> HemisphereGather::once(const std::vector<Place>& places,
                                                           const std::vector<int>& counts,
                                                           const std::vector<Rgb>& coefficients,
                                                           const std::vector<Rgb>& sent, const Progress& progress) {
    std::vector<Once> out(places.size());
    parallel_blocks(
        places.size(), 8,
        [&](std::size_t begin, std::size_t end) {
            Sums& sums = Sums::of_thread(basis_.size());
            for (std::size_t k = begin; k < end; ++k) {
                Gathered row;
                shoot(places[k], counts[k], sums, row);
                out[k] = {row.row, gather(row, coefficients, sent)};
            }
        },
        progress);
    for (const int count : counts) rays_ += static_cast<std::size_t>(count);
    return out;
}

void HemisphereGather::clear() {
    std::vector<Gathered>().swap(rows_);
    count_links();
}

void HemisphereGather::count_links() {
    links_ = 0;
    for (const Gathered& row : rows_) links_ += row.senders.size() + row.links.size();
}

void HemisphereGather::sent(const std::vector<Rgb>& coefficients, std::vector<Rgb>& out) const {
    const Surfels& s = scene_.surfels;
    out.resize(s.size());
    parallel_for(s.size(), 256, [&](std::size_t i) {
        const double outside = means_.outside(i);
        out[i] = outside > 0.0 ? s.reflectance[i] * (means_.mean(i, coefficients) / outside) : Rgb{};
    });
}

Rgb HemisphereGather::gather(const Gathered& of, const std::vector<Rgb>& coefficients, const std::vector<Rgb>& sent) {
    Rgb sum;
    for (const std::uint32_t i : of.senders) sum += sent[i];
    sum = of.row.share * sum;
    for (const Link& link : of.links) {
        const Rgb& value = coefficients[link.function];
        for (int c = 0; c < 3; ++c) sum[c] += static_cast<double>(link.share[c]) * value[c];
    }
    return sum;
}

}  // namespace surflux
