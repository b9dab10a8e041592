#include "surflux/transfer/group_light.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <mutex>
#include <numeric>
#include <utility>

#include "surflux/core/parallel.h"
#include "surflux/core/random.h"
#include "surflux/core/sampling.h"
#include "surflux/trace/tracer.h"
#include "surflux/transfer/shadow_rays.h"

namespace surflux {

namespace {

constexpr std::size_t grain = 64;  // nodes whose rays are traced together
constexpr std::uint64_t light_stream = 0x6c1, ray_stream = 0x6c2, beam_stream = 0x6c3, end_stream = 0x6c4,
                        drawn_stream = 0x6c5;
constexpr int points_of_light = 64;  // of which one is to be over the horizon
// Of a light that is wide beside its distance: so many times the rays, at most so many from a leaf, each to one of so
// many points over the horizon.
constexpr std::size_t more_rays = 4, most_wide = 64;
constexpr int candidates = 2;
constexpr std::size_t together = 16;  // places whose light is asked for at once

Vec3 vec(const float (&v)[3]) {
    return {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
}

}  // namespace

struct GroupLight::Unoccluded {
    std::vector<float> kernels;  // of each sample
    std::vector<Vec3> from;      // where its shadow ray ends; empty where that is one place for all
    std::vector<char> is_wide;   // of each sample (Emitter::is_wide_at): each ray from there ends elsewhere
    Vec3 from_all;
    std::vector<float> means;  // of the kernel, by leaf
    std::vector<float> power;  // that each node would send
    // Of leaves that light meets between all of their samples: where, and from where.
    struct Met {
        Departure place;
        Vec3 from;
    };
    std::map<std::size_t, Met> beams;
    std::mutex mutex;  // of these
    // Of leaves with disks that share what is narrower than they are: what these have, occluded, and of all of the
    // leaf.
    std::map<std::size_t, double> shared;
};

GroupLight::GroupLight(const CompiledScene& scene, const SenderGroups& groups, const SenderSamples& samples,
                       const SurfelPoints& points, const std::vector<double>& areas)
    : scene_(scene),
      groups_(groups),
      samples_(samples),
      points_(points),
      areas_(areas),
      extents_(groups.leaves.size()) {
    const Surfels& s = scene.scene().surfels;
    for (std::uint32_t i = 0; i < s.size() && !has_disks_; ++i) has_disks_ = !points.is_patch(i);
    const SurfelsOfLeaves all(groups);
    number_ = all.number;
    first_lit_.assign(1, 0);
    for (std::size_t leaf = 0; leaf < extents_.size(); ++leaf) {
        all.for_leaf(leaf, [&](std::uint32_t i) {
            if (areas[i] > 0.0) lit_.emplace_back().surfel = i;
        });
        first_lit_.push_back(static_cast<std::uint32_t>(lit_.size()));
    }
    parallel_for(extents_.size(), 256, [&](std::size_t leaf) { describe(leaf); });
}

void GroupLight::describe(std::size_t leaf) {
    const Surfels& s = scene_.scene().surfels;
    Extent& extent = extents_[leaf];
    NormalCone& cone = extent.normals;
    double count = 0.0;
    for_lit(leaf, [&](std::uint32_t i) { cone.center += s.positions[i], cone.axis += s.normals[i], count += 1.0; });
    cone.center = cone.center / std::max(1.0, count);
    cone.axis = cone.axis / std::max(1.0, count);
    for (std::uint32_t k = first_lit_[leaf]; k < first_lit_[leaf + 1]; ++k) {
        const std::uint32_t i = lit_[k].surfel;
        const Vec3 from_center = s.positions[i] - cone.center;
        extent.radius = std::max(extent.radius, length(from_center) + s.radii[i]);
        cone.height = std::max(cone.height, -dot(s.normals[i], from_center));
        cone.spread = std::max(cone.spread, length(s.normals[i] - cone.axis));
        for (int axis = 0; axis < 3; ++axis) {
            lit_[k].from_center[axis] = static_cast<float>(from_center[axis]);
            lit_[k].normal[axis] = static_cast<float>(s.normals[i][axis]);
        }
        lit_[k].radius = static_cast<float>(s.radii[i]);
        lit_[k].area = static_cast<float>(areas_[i]);
    }
}

Receiver GroupLight::whole(std::uint32_t surfel) const {
    const Surfels& s = scene_.scene().surfels;
    return {points_, surfel, surfel, s.positions[surfel], s.normals[surfel], true};
}

// But what disks share.
double GroupLight::mean_over_surfels(const Emitter& light, const NarrowLight& narrow, std::size_t leaf) const {
    const Vec3& center = extents_[leaf].normals.center;
    double sum = 0.0, all = 0.0;
    const LitSurfel* members[together];
    Vec3 at[together], normals[together];
    double kernels[together];
    std::size_t count = 0;
    const auto add = [&] {
        light.kernels_at(at, normals, count, kernels);
        for (std::size_t k = 0; k < count; ++k) {
            const LitSurfel& of = *members[k];
            sum += static_cast<double>(of.area) * (light.is_even_in(at[k], static_cast<double>(of.radius))
                                                       ? kernels[k]
                                                       : light.mean_kernel(whole(of.surfel)));
        }
        count = 0;
    };
    for (std::uint32_t k = first_lit_[leaf]; k < first_lit_[leaf + 1]; ++k) {
        const LitSurfel& of = lit_[k];
        all += static_cast<double>(of.area);
        if (narrow.of(light.index, of.surfel) != nullptr) continue;
        members[count] = &of, at[count] = center + vec(of.from_center), normals[count] = vec(of.normal);
        if (++count == together) add();
    }
    add();
    return all > 0.0 ? sum / all : 0.0;
}

// On the surfel of a leaf that has most of the light.
void GroupLight::find_beam(const Emitter& light, const NarrowLight& narrow, std::size_t leaf, std::uint64_t seed,
                           Unoccluded& out) const {
    const Surfels& s = scene_.scene().surfels;
    double most = 0.0;
    Unoccluded::Met met{};
    for_lit(leaf, [&](std::uint32_t i) {
        const Receiver receiver = whole(i);
        const double power = areas_[i] * light.mean_kernel(receiver);
        if (!(power > most) || narrow.of(light.index, i) != nullptr) return;
        most = power;
        met.place = {s.positions[i], s.normals[i], i};
        std::vector<Triangle> lit;
        light.find_lit(receiver, lit);
        const auto less = [](const Triangle& a, const Triangle& b) { return area_of(a) < area_of(b); };
        if (const auto largest = std::max_element(lit.begin(), lit.end(), less); largest != lit.end())
            met.place.position = points_.inset(i, (largest->a + largest->b + largest->c) / 3.0);
    });
    // Of a lamp that hardly rises over the horizon a point that does.
    EvenPoints even(2, seed + beam_stream, leaf);
    double highest = -1.0;
    for (int k = 0; k < points_of_light; ++k) {
        const double* u = even.next();
        const Arrival arrival = light.arrival(met.place.position, met.place.normal, u[0], u[1]);
        if (arrival.kernel > highest) highest = arrival.kernel, met.from = arrival.from;
    }
    const std::lock_guard lock(out.mutex);
    out.beams[leaf] = met;
}

void GroupLight::find_unoccluded(const Emitter& light, const NarrowLight& narrow, const std::vector<float>& reflectance,
                                 std::uint64_t seed, Unoccluded& out) const {
    const std::size_t leaves = groups_.leaves.size(), n = samples_.of_leaf;
    if (!narrow.is_empty())
        for (const auto& [surfel, part] : narrow.lit(light.index))
            if (areas_[surfel] > 0.0)
                out.shared[number_[groups_.leaf_of_surfel[surfel]]] += areas_[surfel] * part.irradiance;
    for (auto& [leaf, sum] : out.shared) {
        double area = 0.0;
        for_lit(leaf, [&](std::uint32_t i) { area += areas_[i]; });
        sum /= area;
    }
    out.kernels.resize(leaves * n);
    out.means.resize(leaves);
    out.power.resize(groups_.size());
    if (light.extended) out.from.resize(leaves * n);
    out.is_wide.assign(light.extended ? leaves * n : 0, 0);
    if (leaves > 0) out.from_all = light.arrival(samples_.position(0), samples_.normal(0), 0.5, 0.5).from;
    parallel_blocks(leaves, 256, [&](std::size_t begin, std::size_t end) {
        std::vector<Vec3> at(n), normals(n);
        std::vector<double> kernels(n);
        std::vector<std::pair<std::size_t, double>> uneven;  // leaves, and the sums of their samples
        const auto keep = [&](std::size_t leaf, double mean) {
            const std::size_t node = groups_.leaves[leaf];
            double reflected = 0.0;
            for (int c = 0; c < 3; ++c)
                reflected +=
                    light.color[c] * static_cast<double>(reflectance[colors * node + static_cast<std::size_t>(c)]);
            out.means[leaf] = static_cast<float>(mean);
            out.power[node] = groups_.nodes[node].area * static_cast<float>(reflected) * out.means[leaf];
        };
        for (std::size_t leaf = begin; leaf < end; ++leaf) {
            if (light.is_behind(extents_[leaf].normals)) continue;
            for (std::size_t k = 0; k < n; ++k)
                at[k] = samples_.position(leaf * n + k), normals[k] = samples_.normal(leaf * n + k);
            if (light.extended) {
                EvenPoints even(2, seed + light_stream, leaf);
                for (std::size_t k = 0, p = leaf * n; k < n; ++k, ++p) {
                    const double* u = even.next();
                    const Arrival arrival = light.arrival(at[k], normals[k], u[0], u[1]);
                    out.from[p] = arrival.from;
                    out.is_wide[p] = light.is_wide_at(at[k]);
                    kernels[k] = out.is_wide[p] ? light.kernel_at(at[k], normals[k]) : arrival.kernel;
                }
            } else {
                light.kernels_at(at.data(), normals.data(), n, kernels.data());
            }
            double sum = 0.0;
            for (std::size_t k = 0, p = leaf * n; k < n; ++k, ++p) {
                if (narrow.of(light.index, samples_.samples[p].surfel) != nullptr) continue;
                out.kernels[p] = static_cast<float>(kernels[k]);
                sum += kernels[k];
            }
            if (!light.is_even_in(extents_[leaf].normals.center, extents_[leaf].radius) || out.shared.count(leaf) > 0) {
                uneven.emplace_back(leaf, sum);
            } else {
                keep(leaf, sum / static_cast<double>(n));
            }
        }
        for (const auto& [leaf, sum] : uneven) {
            const double mean = mean_over_surfels(light, narrow, leaf);
            if (mean > 0.0 && !(sum > 0.0)) find_beam(light, narrow, leaf, seed, out);
            keep(leaf, mean);
        }
    });
    for (std::size_t k = groups_.size(); k-- > 0;)
        if (const SenderGroups::Node& node = groups_.nodes[k]; !node.is_leaf())
            out.power[k] = out.power[node.child] + out.power[node.child + 1];
}

// How many samples of a leaf the light is wide at.
std::size_t GroupLight::wide_samples(const Unoccluded& light, std::size_t leaf) const {
    if (light.is_wide.empty()) return 0;
    const char* of_leaf = light.is_wide.data() + leaf * samples_.of_leaf;
    return static_cast<std::size_t>(std::count(of_leaf, of_leaf + samples_.of_leaf, 1));
}

// The share of all that the groups would send of light that is wide where they are.
double GroupLight::wide_share(const Unoccluded& light) const {
    if (light.is_wide.empty() || !(light.power[0] > 0.0f)) return 0.0;
    double wide = 0.0;
    for (std::size_t leaf = 0; leaf < groups_.leaves.size(); ++leaf)
        wide += static_cast<double>(light.power[groups_.leaves[leaf]]) *
                static_cast<double>(wide_samples(light, leaf)) / static_cast<double>(samples_.of_leaf);
    return wide / static_cast<double>(light.power[0]);
}

// Where a ray from a sample ends: at one of some points of the light, drawn by what they bring.
Vec3 GroupLight::end_of(const Emitter& emitter, std::size_t sample, Random& random) const {
    Vec3 from;
    double all = 0.0;
    int over_horizon = 0;
    for (int k = 0; k < points_of_light && over_horizon < candidates; ++k) {
        const double s = random.uniform(), t = random.uniform();
        const Arrival arrival = emitter.arrival(samples_.position(sample), samples_.normal(sample), s, t);
        over_horizon += arrival.kernel > 0.0;
        all += arrival.kernel;
        if (random.uniform() * all <= arrival.kernel) from = arrival.from;
    }
    return from;
}

// Samples that the rays of a node leave, drawn by what they would send.
void GroupLight::aim(const ShadowRays& shot, const Unoccluded& light, std::uint64_t seed,
                     std::vector<std::size_t>& samples) const {
    Random random(seed + ray_stream, shot.node);
    std::uint32_t at = shot.node;
    while (!groups_.nodes[at].is_leaf()) {
        const std::uint32_t child = groups_.nodes[at].child;
        at = child +
             (random.uniform() * static_cast<double>(light.power[at]) >= static_cast<double>(light.power[child]) &&
              light.power[child + 1] > 0.0f);
    }
    const std::size_t n = samples_.of_leaf;
    const float* kernel = light.kernels.data() + number_[at] * n;
    const double sum = std::accumulate(kernel, kernel + n, 0.0);
    const double offset = random.uniform();
    double up_to = static_cast<double>(kernel[0]);
    for (std::size_t k = 0, p = 0; k < shot.rays; ++k) {
        const double to = (static_cast<double>(k) + offset) / static_cast<double>(shot.rays) * sum;
        while ((up_to <= to || kernel[p] == 0.0f) && p + 1 < n) up_to += static_cast<double>(kernel[++p]);
        samples.push_back(number_[at] * n + p);
    }
}

std::vector<float> GroupLight::irradiance(const std::vector<Light>& lights, const std::vector<float>& reflectance,
                                          const GroupLightOptions& options) const {
    const Tracer& tracer = scene_.tracer();
    std::vector<float> out(colors * groups_.size(), 0.0f);
    const auto emitters = emitters_of(lights);
    const NarrowLight narrow = has_disks_ && options.shares_narrow
                                   ? NarrowLight(scene_.scene(), lights, tracer, options.seed, {}, options.rays)
                                   : NarrowLight();
    for (const std::unique_ptr<Emitter>& light : emitters) {  // with the same random numbers: light is additive
        Unoccluded all;
        find_unoccluded(*light, narrow, reflectance, options.seed, all);
        const auto more = static_cast<double>(more_rays - 1) * wide_share(all);
        const auto most_rays = [&](std::uint32_t leaf) {
            return wide_samples(all, number_[leaf]) > 0 ? most_wide : samples_.of_leaf;
        };
        const std::vector<ShadowRays> shots = plan_shadow_rays(
            groups_, all.power, options.rays + static_cast<std::size_t>(more * static_cast<double>(options.rays)),
            options.shares_across, options.seed + drawn_stream, most_rays);
        parallel_blocks(shots.size(), grain, [&](std::size_t begin, std::size_t end) {
            std::vector<std::size_t> samples;
            std::vector<Ray> rays;
            std::vector<char> free;
            for (std::size_t k = begin; k < end; ++k) aim(shots[k], all, options.seed, samples);
            Random random(options.seed + end_stream, begin);
            for (const std::size_t p : samples) {
                Vec3 from = light->extended ? all.from[p] : all.from_all;
                if (!all.is_wide.empty() && all.is_wide[p]) from = end_of(*light, p, random);
                Departure place{samples_.position(p), samples_.normal(p), samples_.samples[p].surfel};
                if (const auto beam = all.beams.find(p / samples_.of_leaf); beam != all.beams.end())
                    place = beam->second.place, from = beam->second.from;
                rays.push_back(light->distant ? Ray{place, from} : segment(place, from));
            }
            tracer.free(rays, free);
            std::vector<std::uint32_t> below;
            for (std::size_t k = begin, r = 0; k < end; ++k) {
                float arrived = 0.0f;
                for (const std::size_t last = r + shots[k].rays; r < last; ++r) arrived += free[r] != 0 ? 1.0f : 0.0f;
                if (arrived == 0.0f) continue;
                const float share = shots[k].weight * arrived / static_cast<float>(shots[k].rays);
                for (below.assign(1, shots[k].node); !below.empty();) {
                    const std::uint32_t node = below.back();
                    below.pop_back();
                    if (!groups_.nodes[node].is_leaf()) {
                        below.push_back(groups_.nodes[node].child);
                        below.push_back(groups_.nodes[node].child + 1);
                        continue;
                    }
                    const float mean = share * all.means[number_[node]];
                    for (int c = 0; c < 3; ++c)
                        out[colors * node + static_cast<std::size_t>(c)] += mean * static_cast<float>(light->color[c]);
                }
            }
        });
        for (const auto& [leaf, mean] : all.shared)
            for (int c = 0; c < 3; ++c)
                out[colors * groups_.leaves[leaf] + static_cast<std::size_t>(c)] +=
                    static_cast<float>(mean * light->color[c]);
    }
    return out;
}

}  // namespace surflux
