#include "surflux/trace/inward.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/parallel.h"
#include "surflux/core/sampling.h"
#include "surflux/neighbors/distinct_places.h"
#include "surflux/neighbors/orientation.h"
#include "surflux/neighbors/point_index.h"
#include "surflux/trace/tracer.h"

namespace surflux {

namespace {

constexpr std::size_t links = 8;       // neighbours that a surfel asks
constexpr int rounds = 40;             // of asking; half of them is as far as an opinion carries
constexpr double own_weight = 0.5;     // of what a surfel has seen itself, against `links` neighbours
constexpr double decided = 0.1;        // opinions run from -1 to 1
constexpr double continuation = 0.5;   // agreement of neighbours in one patch
constexpr double widest_cosine = 0.3;  // of a ray: flatter ones meet the rims of neighbouring disks

Scene turned(const Scene& scene) {
    Scene out = scene;
    for (Vec3& n : out.surfels.normals) n = -n;
    for (Triangle& t : out.surfels.triangles) std::swap(t.b, t.c);
    return out;
}

// Share of the rays from the front of each surfel that leave the scene.
std::vector<double> escapes(const Scene& scene, const InwardOptions& options, const Progress& progress) {
    const Surfels& s = scene.surfels;
    const Tracer tracer(scene);
    std::vector<double> out(s.size(), 0.0);
    parallel_blocks(
        s.size(), 64,
        [&](std::size_t begin, std::size_t end) {
            for (std::size_t k = begin; k < end; ++k) {
                const auto i = static_cast<std::uint32_t>(k);
                const Frame frame = frame_around(s.normals[i]);
                EvenPoints even(2, options.seed, i);
                for (int r = 0; r < options.rays; ++r) {
                    const double* u = even.next();
                    Vec3 d = square_to_cosine_hemisphere(u[0], u[1]);
                    if (d.z < widest_cosine) d = {d.x, d.y, widest_cosine};
                    if (tracer.escapes(i, s.positions[i], frame.to_world(normalized(d)))) out[i] += 1.0 / options.rays;
                }
            }
        },
        progress);
    return out;
}

struct Link {
    std::uint32_t to;
    float agreement;
};

std::vector<std::vector<Link>> make_links(const Surfels& s) {
    // Surfels at the same place (two-sided sheets) have each other's neighbours.
    const auto [places, of_surfel] = distinct_places(s.positions);
    std::vector<std::vector<std::uint32_t>> at(places.size());
    for (std::size_t i = 0; i < s.size(); ++i) at[of_surfel[i]].push_back(static_cast<std::uint32_t>(i));
    const PointIndex index(places);
    std::vector<std::vector<Link>> out(s.size());
    parallel_blocks(places.size(), 256, [&](std::size_t begin, std::size_t end) {
        std::vector<Neighbor> near;
        for (std::size_t p = begin; p < end; ++p) {
            index.nearest(places[p], links + 1, near);
            for (const Neighbor& n : near) {
                if (n.index == p) continue;
                const Vec3 d = places[n.index] - places[p];
                for (std::uint32_t i : at[p])
                    for (std::uint32_t j : at[n.index])
                        out[i].push_back({j, static_cast<float>(agreement(s.normals[i], s.normals[j], d))});
            }
        }
    });
    return out;
}

// What a surfel has seen, and what its neighbours think, in turn; at most of size 1.
void settle(const std::vector<std::vector<Link>>& near, std::vector<double>& opinion) {
    const std::vector<double> seen = opinion;
    std::vector<double> before(seen.size());
    for (int round = 0; round < rounds; ++round) {
        before = opinion;
        parallel_for(seen.size(), 1024, [&](std::size_t i) {
            double sum = own_weight * links * seen[i], weight = own_weight * links * std::abs(seen[i]);
            for (const Link& link : near[i]) {
                // Squared, so that vague neighbours count for little.
                const double a = static_cast<double>(link.agreement) * std::abs(static_cast<double>(link.agreement));
                sum += a * before[link.to];
                weight += std::abs(a);
            }
            opinion[i] = weight > 0.0 ? sum / weight : 0.0;
        });
    }
}

}  // namespace

std::vector<std::uint32_t> inward_patches(const Surfels& surfels, const InwardOptions& options,
                                          const Progress& progress) {
    std::vector<std::uint32_t> patch(surfels.size(), 0);
    if (surfels.size() < 2) return patch;
    Scene scene;
    scene.surfels = surfels;
    scene.object.assign(surfels.size(), 0);
    const auto half = [&](std::size_t before) -> Progress {
        if (!progress) return {};
        return [&progress, before](std::size_t done, std::size_t total) { return progress(before + done, 2 * total); };
    };
    std::vector<double> opinion = escapes(scene, options, half(0));
    const std::vector<double> back = escapes(turned(scene), options, half(surfels.size()));
    for (std::size_t i = 0; i < opinion.size(); ++i) opinion[i] -= back[i];
    const std::vector<std::vector<Link>> near = make_links(surfels);
    settle(near, opinion);

    // Connected regions, by flooding from each surfel that has not been reached yet.
    std::vector<std::vector<std::uint32_t>> regions;
    std::vector<bool> reached(surfels.size(), false);
    for (std::uint32_t seed = 0; seed < surfels.size(); ++seed) {
        if (reached[seed] || opinion[seed] >= -decided) continue;
        std::vector<std::uint32_t> region{seed};
        reached[seed] = true;
        for (std::size_t k = 0; k < region.size(); ++k)
            for (const Link& link : near[region[k]])
                if (!reached[link.to] &&
                    opinion[link.to]<-decided&& static_cast<double>(link.agreement)> continuation) {
                    reached[link.to] = true;
                    region.push_back(link.to);
                }
        if (region.size() >= options.smallest) regions.push_back(std::move(region));
    }
    std::stable_sort(regions.begin(), regions.end(), [](const auto& a, const auto& b) { return a.size() > b.size(); });
    for (std::size_t r = 0; r < regions.size(); ++r)
        for (std::uint32_t i : regions[r]) patch[i] = static_cast<std::uint32_t>(r + 1);
    return patch;
}

}  // namespace surflux
