#include "surflux/transfer/sky_irradiance.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/error.h"
#include "surflux/core/parallel.h"
#include "surflux/core/sampling.h"

namespace surflux {

namespace {

constexpr std::size_t rays_of_sky = 1152;  // at least, of a receiver, were its horizon down
constexpr std::size_t rays_of_ground = 128;
constexpr std::size_t across = 4;  // directions of a patch that it is integrated by, each way
constexpr std::size_t across_ground = 32;
constexpr int rays_of_sender = 32;
constexpr float finest = 65535.0f;

// Directions that stand for equal parts of each patch.
struct PatchDirections {
    explicit PatchDirections(const SkyPatches& patches) {
        for (std::size_t patch = 0; patch < patches.size(); ++patch) {
            const std::size_t n = patch == 0 ? across_ground : across;
            for (std::size_t i = 0; i < n * n; ++i)
                directions.push_back(patches.place_in(patch,
                                                      (static_cast<double>(i % n) + 0.5) / static_cast<double>(n),
                                                      (static_cast<double>(i / n) + 0.5) / static_cast<double>(n)));
            begin.push_back(directions.size());
        }
    }
    std::vector<Vec3> directions;
    std::vector<std::size_t> begin{0};
};

}  // namespace

SkyIrradiance::SkyIrradiance(const TransportOperator& transport, const SurfelPoints& points, const Tracer& tracer,
                             const SkyPatches& patches, std::uint64_t seed, const Progress& progress,
                             const Team& team) {
    constexpr std::size_t grain = 16;
    const PatchDirections parts(patches);
    const std::size_t rows = transport.rows.size(), of_patch = std::max<std::size_t>(1, rays_of_sky / patches.size());
    std::vector<std::vector<Entry>> found(rows);
    scale.resize(rows);
    shared_blocks(
        team, "sky", [&] { return digest_of(seed, transport.positions); }, rows, grain,
        [&](std::size_t from_row, std::size_t to_row) {
            std::vector<Ray> rays;
            std::vector<char> free;
            struct Patch {
                std::uint16_t index;
                double unoccluded;
                std::size_t first;  // ray
            };
            std::vector<Patch> asked;
            std::vector<double> cosines, values;
            for (std::size_t k = from_row; k < to_row; ++k) {
                const Place place = transport.place(k);
                EvenPoints even(points.extends(place) ? 4 : 2, seed, stream_of(place));
                rays.clear();
                asked.clear();
                cosines.clear();
                const auto shoot = [&](const Vec3& direction, const double* u) {
                    const double cosine = dot(direction, place.normal);
                    if (cosine <= 0.0) return;
                    rays.push_back({{points.at(place, u[2], u[3]), place.normal, place.surfel}, direction});
                    cosines.push_back(cosine);
                };
                for (std::size_t patch = 0; patch < patches.size(); ++patch) {
                    double sum = 0.0, most = 0.0;
                    Vec3 highest;
                    for (std::size_t i = parts.begin[patch]; i < parts.begin[patch + 1]; ++i) {
                        const double cosine = dot(parts.directions[i], place.normal);
                        if (cosine > most) most = cosine, highest = parts.directions[i];
                        sum += std::max(0.0, cosine);
                    }
                    if (sum == 0.0) continue;
                    const auto count = static_cast<double>(parts.begin[patch + 1] - parts.begin[patch]);
                    asked.push_back(
                        {static_cast<std::uint16_t>(patch), patches.solid_angles()[patch] * sum / count, rays.size()});
                    for (std::size_t r = 0; r < (patch == 0 ? rays_of_ground : of_patch); ++r) {
                        const double* u = even.next();
                        shoot(patches.place_in(patch, u[0], u[1]), u);
                    }
                    if (rays.size() == asked.back().first) shoot(highest, even.next());
                }
                tracer.free(rays, free);
                values.clear();
                for (std::size_t a = 0; a < asked.size(); ++a) {
                    const std::size_t last = a + 1 < asked.size() ? asked[a + 1].first : rays.size();
                    double arrived = 0.0, all = 0.0;
                    for (std::size_t r = asked[a].first; r < last; ++r) {
                        all += cosines[r];
                        arrived += free[r] != 0 ? cosines[r] : 0.0;
                    }
                    values.push_back(asked[a].unoccluded * arrived / all);
                }
                const double most = values.empty() ? 0.0 : *std::max_element(values.begin(), values.end());
                scale[k] = static_cast<float>(most) / finest;
                for (std::size_t a = 0; a < asked.size() && most > 0.0; ++a)
                    if (const auto share =
                            static_cast<std::uint16_t>(std::lround(values[a] / most * static_cast<double>(finest)));
                        share > 0)
                        found[k].push_back({asked[a].index, share});
            }
        },
        [&](std::size_t from_row, std::size_t to_row, Packed& to) {
            to.add(scale.data() + from_row, to_row - from_row);
            for (std::size_t k = from_row; k < to_row; ++k) to.add(found[k]);
        },
        [&](std::size_t from_row, std::size_t to_row, Unpacking& from) {
            from.take(scale.data() + from_row, to_row - from_row);
            for (std::size_t k = from_row; k < to_row; ++k) {
                found[k].clear();
                from.append_to(found[k]);
            }
        },
        progress);
    for (const std::vector<Entry>& row : found) {
        entries.insert(entries.end(), row.begin(), row.end());
        begin.push_back(entries.size());
    }
}

void SkyIrradiance::receive(const std::vector<float>& radiances, std::size_t channels, std::vector<float>& out) const {
    const std::size_t rows = scale.size();
    out.resize(rows * channels);
    with_fixed(channels, [&](const auto count) {
        parallel_for(rows, 64, [&](std::size_t k) {
            auto sum = float_sum(count);
            for (std::uint64_t e = begin[k]; e < begin[k + 1]; ++e)
                sum.add(scale[k] * static_cast<float>(entries[e].share), radiances.data() + entries[e].patch * count);
            sum.write(out.data() + k * count);
        });
    });
}

std::size_t SkyIrradiance::bytes() const {
    return begin.size() * sizeof begin[0] + entries.size() * sizeof entries[0] + scale.size() * sizeof scale[0];
}

void SkyIrradiance::require_whole(std::size_t rows, std::size_t patches) const {
    require(begin.size() == rows + 1 && scale.size() == rows && begin.front() == 0 && begin.back() == entries.size() &&
                std::is_sorted(begin.begin(), begin.end()),
            "sky_begin: wanted where each of ", rows, " rows begins");
    for (const float s : scale) require(std::isfinite(s) && s >= 0.0f, "sky_scale: wanted finite numbers");
    for (const Entry& entry : entries) require(entry.patch < patches, "sky: wanted patches below ", patches);
}

// Of the harmonics of natural light: its power falls as the square of the band (Dror, Willsky and Adelson 2004). All
// alike, the noise of rays in the many of the high bands would hide what differs in the few of the low ones.
std::vector<float> SkyTest::amplitudes() {
    std::vector<float> out;
    for (int band = 0; band < order; ++band)
        for (int m = -band; m <= band; ++m) out.push_back(1.0f / static_cast<float>(1 + band));
    return out;
}

struct SkyTest::Scratch {
    std::vector<Ray> rays;
    std::vector<char> free;
    std::vector<double> at = std::vector<double>(SphericalHarmonics::count(order));
};

SkyTest::SkyTest(const SurfelPoints& points, const Tracer& tracer, const SenderGroups& senders,
                 const SenderSamples& samples, const std::vector<float>& reflectance, std::uint64_t seed)
    : RowTest(amplitudes()),
      points_(points),
      tracer_(tracer),
      seed_(seed),
      sent_(senders.size() * SphericalHarmonics::count(order), 0.0f) {
    const std::size_t n = size();
    parallel_blocks(senders.leaves.size(), 16, [&](std::size_t begin, std::size_t end) {
        Scratch scratch;
        std::vector<float> halves(2 * n);
        for (std::size_t leaf = begin; leaf < end; ++leaf) {
            const std::size_t node = senders.leaves[leaf], sample = leaf * samples.of_leaf;
            std::fill(halves.begin(), halves.end(), 0.0f);
            add_direct({samples.position(sample), samples.normal(sample), samples.samples[sample].surfel},
                       rays_of_sender, scratch, halves.data());
            const float* of_node = reflectance.data() + colors * node;
            const Rgb own{static_cast<double>(of_node[0]), static_cast<double>(of_node[1]),
                          static_cast<double>(of_node[2])};
            for (std::size_t c = 0; c < n; ++c)
                sent_[n * node + c] = 0.5f * static_cast<float>(luminance(own)) * (halves[c] + halves[n + c]);
        }
    });
    senders.pull_up(sent_, n);
}

void SkyTest::add_direct(const Place& place, int rays, Scratch& scratch, float* halves) const {
    const Frame frame = frame_around(place.normal);
    EvenPoints even(points_.extends(place) ? 4 : 2, seed_, stream_of(place));
    scratch.rays.clear();
    for (int k = 0; k < rays; ++k) {
        const double* u = even.next();
        scratch.rays.push_back({{points_.at(place, u[2], u[3]), place.normal, place.surfel},
                                frame.to_world(square_to_cosine_hemisphere(u[0], u[1]))});
    }
    tracer_.free(scratch.rays, scratch.free);
    const std::size_t n = size();
    const auto of_ray = static_cast<float>(2.0 * pi / rays);
    for (int k = 0; k < rays; ++k) {
        if (scratch.free[static_cast<std::size_t>(k)] == 0) continue;
        harmonics_.evaluate(scratch.rays[static_cast<std::size_t>(k)].direction, scratch.at.data());
        float* half = halves + (2 * k < rays ? 0 : n);
        for (std::size_t c = 0; c < n; ++c) half[c] += of_ray * static_cast<float>(scratch.at[c]);
    }
}

void SkyTest::find(const ShotRows& of, std::size_t begin, std::size_t end, float* halves) const {
    Scratch scratch;
    for (std::size_t k = begin; k < end; ++k, halves += 2 * size()) {
        const auto rays = static_cast<int>(std::lround(1.0f / of.rows[k].per_ray));
        add_direct(of.place(k), rays, scratch, halves);
        add_reflected(of, k, sent_, halves);
    }
}

}  // namespace surflux
