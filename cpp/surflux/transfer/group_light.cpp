#include "surflux/transfer/group_light.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "surflux/core/parallel.h"
#include "surflux/core/random.h"
#include "surflux/core/sampling.h"
#include "surflux/lights/emitter.h"
#include "surflux/trace/tracer.h"

namespace surflux {

namespace {

constexpr std::size_t grain = 64;  // groups whose rays are traced together
constexpr std::uint64_t light_stream = 0x6c1, ray_stream = 0x6c2;

}  // namespace

std::vector<float> GroupLight::irradiance(const std::vector<Light>& lights, const std::vector<float>& reflectance,
                                          const GroupLightOptions& options) const {
    const Tracer& tracer = scene_.tracer();
    const Surfels& s = scene_.scene().surfels;
    const std::size_t leaves = groups_.leaves.size(), n = samples_.of_leaf;
    std::vector<float> out(3 * groups_.size(), 0.0f);
    std::vector<float> kernels(leaves * n), power(leaves), stands_for(leaves);
    std::vector<Vec3> from(leaves * n);
    const auto emitters = emitters_of(lights);
    for (const std::unique_ptr<Emitter>& light : emitters) {  // with the same random numbers: light is additive
        parallel_for(leaves, grain, [&](std::size_t leaf) {
            EvenPoints even(2, options.seed + light_stream, leaf);
            double sum = 0.0;
            for (std::size_t p = leaf * n; p < (leaf + 1) * n; ++p) {
                const double* u = even.next();
                const Arrival arrival =
                    light->arrival(samples_.positions[p], s.normals[samples_.surfels[p]], u[0], u[1]);
                kernels[p] = static_cast<float>(arrival.kernel);
                from[p] = arrival.from;
                sum += arrival.kernel;
            }
            const std::size_t node = groups_.leaves[leaf];
            double reflected = 0.0;
            for (int c = 0; c < 3; ++c)
                reflected += light->color[c] * static_cast<double>(reflectance[3 * node + static_cast<std::size_t>(c)]);
            power[leaf] = static_cast<float>(static_cast<double>(groups_.nodes[node].area) * reflected * sum);
        });
        double all = 0.0;
        for (const float p : power) all += static_cast<double>(p);
        const double rays_by_power = all > 0.0 ? static_cast<double>(options.rays) / all : 0.0;
        parallel_blocks(leaves, grain, [&](std::size_t begin, std::size_t end) {
            std::vector<Ray> rays;
            std::vector<char> free;
            std::vector<std::size_t> first{0};
            for (std::size_t leaf = begin; leaf < end; ++leaf) {
                const float* kernel = kernels.data() + leaf * n;
                double sum = 0.0;
                for (std::size_t p = 0; p < n; ++p) sum += static_cast<double>(kernel[p]);
                if (sum > 0.0) {
                    Random random(options.seed + ray_stream, leaf);
                    const double wanted = rays_by_power * static_cast<double>(power[leaf]);
                    const bool is_asked = wanted >= 1.0 || random.uniform() < wanted;
                    stands_for[leaf] = is_asked && wanted < 1.0 ? static_cast<float>(1.0 / wanted) : 1.0f;
                    const std::size_t count =
                        is_asked ? std::clamp<std::size_t>(static_cast<std::size_t>(wanted), 1, n) : 0;
                    const double offset = random.uniform();
                    double up_to = static_cast<double>(kernel[0]);
                    for (std::size_t k = 0, p = 0; k < count; ++k) {
                        const double at = (static_cast<double>(k) + offset) / static_cast<double>(count) * sum;
                        while (up_to <= at && p + 1 < n) up_to += static_cast<double>(kernel[++p]);
                        const std::uint32_t i = samples_.surfels[leaf * n + p];
                        const Departure place{samples_.positions[leaf * n + p], s.normals[i], i};
                        const Vec3& to = from[leaf * n + p];
                        rays.push_back(light->distant ? Ray{place, to} : segment(place, to));
                    }
                }
                first.push_back(rays.size());
            }
            tracer.free(rays, free);
            for (std::size_t leaf = begin; leaf < end; ++leaf) {
                const std::size_t k = leaf - begin, count = first[k + 1] - first[k];
                if (count == 0) continue;
                double sum = 0.0, arrived = 0.0;
                for (std::size_t p = leaf * n; p < (leaf + 1) * n; ++p) sum += static_cast<double>(kernels[p]);
                for (std::size_t r = first[k]; r < first[k + 1]; ++r) arrived += free[r] != 0;
                const double mean = static_cast<double>(stands_for[leaf]) * sum / static_cast<double>(n) * arrived /
                                    static_cast<double>(count);
                for (int c = 0; c < 3; ++c)
                    out[3 * groups_.leaves[leaf] + static_cast<std::size_t>(c)] +=
                        static_cast<float>(mean * light->color[c]);
            }
        });
    }
    return out;
}

}  // namespace surflux
