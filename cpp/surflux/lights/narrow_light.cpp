#include "surflux/lights/narrow_light.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "surflux/core/parallel.h"
#include "surflux/core/sampling.h"
#include "surflux/core/thread_scratch.h"
#include "surflux/lights/photometric_web.h"
#include "surflux/lights/spot_cone.h"
#include "surflux/neighbors/disk_index.h"
#include "surflux/neighbors/disk_kernel.h"

namespace surflux {

namespace {

constexpr std::uint64_t beam_stream = 0xbea35;
// A spot's circle of light and a lamp's distance, in radii of the disks, from which on centres tell the light: a circle
// of 4 radii holds some 50 centres, whose number is off by 4 %, and of a lamp 3 radii away half a per cent is missed.
// Beyond, centres have no variance.
constexpr double wide_circle = 4.0, far_away = 3.0;
// Rays for each disk in the circle, and bounds of their number.
constexpr std::size_t rays_each = 256, least_rays = 4096, wide_rays = std::size_t{1} << 18,
                      most_rays = std::size_t{1} << 20;
constexpr double wide_cone = 0.3;  // half an angle: rays of wider ones miss most of what is narrow
constexpr double evenness = 0.5;   // of even points' standard error in that of random ones, as in direct.cpp
constexpr double alike = 0.5;      // cosine between normals of one surface, as in area/coincidence

// What leaves a light along a ray, per unit of its colour.
struct Beam {
    Vec3 origin, direction;
    double power;
};

// A light of a known power, as one that may be narrow.
struct Source {
    virtual ~Source() = default;
    // Does it meet the front of disk i, and change within it?
    virtual bool is_narrow(const Surfels& s, std::uint32_t i) const = 0;
    // By a point of [0, 1)^4. Powers are in proportion: they add up to that of the light.
    virtual Beam beam(const double* u) const = 0;
    virtual double power() const = 0;
    // So many that those which meet one disk have a standard error no larger than what its centre would be off by.
    virtual std::size_t fewest_rays() const { return wide_rays; }
};

struct PointSource : Source {
    explicit PointSource(const Vec3& at) : position(at) {}
    bool is_narrow(const Surfels& s, std::uint32_t i) const override {
        const Vec3 d = s.positions[i] - position;
        return dot(s.normals[i], d) < 0.0 && length(d) < far_away * s.radii[i];
    }
    Beam beam(const double* u) const override {
        const double z = 1.0 - 2.0 * u[0], across = std::sqrt(std::max(0.0, 1.0 - z * z)), angle = 2.0 * pi * u[1];
        return {position, {across * std::cos(angle), across * std::sin(angle), z}, 1.0};
    }
    double power() const override { return 4.0 * pi; }
    Vec3 position;
};

struct SpotSource final : PointSource {
    explicit SpotSource(const SpotLight& light)
        : PointSource(light.position), cone(light), frame(frame_around(light.direction)) {}
    bool is_narrow(const Surfels& s, std::uint32_t i) const override {
        const Vec3 d = s.positions[i] - position;
        const double distance = length(d), reach = domain_ratio * s.radii[i];
        if (!(dot(s.normals[i], d) < 0.0)) return false;
        if (distance > reach && cone.angle(d) - std::asin(reach / distance) >= cone.outer()) return false;
        if (distance < far_away * s.radii[i]) return true;
        return cone.outer() < 0.5 * pi && distance * std::tan(cone.outer()) < wide_circle * s.radii[i];
    }
    std::size_t fewest_rays() const override { return cone.outer() < wide_cone ? least_rays : wide_rays; }
    Beam beam(const double* u) const override {
        // Uniform over the cone's directions; 1 - cosine keeps the digits of a narrow one.
        const double half = std::sin(0.5 * cone.outer()), versine = 2.0 * half * half * u[0], angle = 2.0 * pi * u[1];
        const double across = std::sqrt(versine * (2.0 - versine));
        const Vec3 d = frame.to_world({across * std::cos(angle), across * std::sin(angle), 1.0 - versine});
        return {position, d, cone.share(d)};
    }
    double power() const override { return 2.0 * pi * cone.within(pi); }
    SpotCone cone;
    Frame frame;
};

struct PhotometricSource final : PointSource {
    explicit PhotometricSource(const PhotometricLight& light) : PointSource(light.position), web(light), rays(web) {}
    bool is_narrow(const Surfels& s, std::uint32_t i) const override {
        if (PointSource::is_narrow(s, i)) return true;
        const Vec3 d = s.positions[i] - position;
        return dot(s.normals[i], d) < 0.0 && web.beam() < 0.25 * pi &&
               length(d) * std::tan(web.beam()) < wide_circle * s.radii[i];
    }
    Beam beam(const double* u) const override {
        const auto [direction, power] = rays.draw(u[0], u[1]);
        return {position, direction, power};
    }
    double power() const override { return web.power(); }
    PhotometricWeb web;
    PhotometricWeb::Rays rays;
};

struct AreaSource final : Source {
    explicit AreaSource(const AreaLight& of)
        : light(of),
          center(of.corner + 0.5 * (of.edge_u + of.edge_v)),
          front(cross(of.edge_u, of.edge_v)),
          reach(0.5 * std::max(length(of.edge_u + of.edge_v), length(of.edge_u - of.edge_v))),
          frame(frame_around(normalized(front))) {}
    bool is_narrow(const Surfels& s, std::uint32_t i) const override {
        const Vec3 d = s.positions[i] - center;
        const Vec3& n = s.normals[i];
        const double highest = 0.5 * (std::abs(dot(n, light.edge_u)) + std::abs(dot(n, light.edge_v))) - dot(n, d);
        return highest > 0.0 && dot(d, frame.n) > -s.radii[i] && length(d) + reach < far_away * s.radii[i];
    }
    Beam beam(const double* u) const override {
        return {light.corner + u[2] * light.edge_u + u[3] * light.edge_v,
                frame.to_world(square_to_cosine_hemisphere(u[0], u[1])), 1.0};
    }
    double power() const override { return length(front); }
    const AreaLight& light;
    Vec3 center, front;
    double reach;
    Frame frame;
};

std::unique_ptr<Source> source_of(const Light& light) {
    if (const auto* p = std::get_if<PointLight>(&light)) return std::make_unique<PointSource>(p->position);
    if (const auto* p = std::get_if<SpotLight>(&light)) return std::make_unique<SpotSource>(*p);
    if (const auto* p = std::get_if<PhotometricLight>(&light)) return std::make_unique<PhotometricSource>(*p);
    if (const auto* p = std::get_if<AreaLight>(&light)) return std::make_unique<AreaSource>(*p);
    return nullptr;
}

// Who shares what arrives at a place on a disk.
class Sharing {
public:
    struct Share {
        std::uint32_t surfel;
        double share;
    };

    explicit Sharing(const Scene& scene)
        : scene_(scene), ends_(end_ranges(scene.surfels)), disks_(disks_of(scene.surfels)), index_(index_of()) {}

    // Of what meets `hit` at `place`: disks of its surface that reach there and face the light, by their weights.
    void at(std::uint32_t hit, const Vec3& place, const Vec3& direction, std::vector<Share>& out) const {
        const Surfels& s = scene_.surfels;
        thread_local std::vector<Neighbor> near;
        const ThreadScratch scratch(near);
        out.clear();
        index_.reaching(place, 0.0, near, domain_ratio);
        const double least = 1e-10 * s.radii[hit] * s.radii[hit];
        double sum = 0.0, own_square = s.radii[hit] * s.radii[hit];
        for (const Neighbor& found : near)
            if (disks_[found.index] == hit) own_square = std::max(found.distance * found.distance, least);
        for (const Neighbor& found : near) {
            const std::uint32_t k = disks_[found.index];
            if (k != hit && !shares(k, hit, place, direction)) continue;
            const double reach = domain_ratio * s.radii[k],
                         weight = disk_weight(found.distance * found.distance, reach * reach, own_square, least);
            sum += weight;
            out.push_back({k, weight});
        }
        if (!(sum > 0.0)) out.assign(1, {hit, sum = 1.0});
        for (Share& share : out) share.share /= sum;
    }

private:
    static std::vector<std::uint32_t> disks_of(const Surfels& s) {
        const std::vector<std::uint32_t> triangles = triangle_ranges(s);
        std::vector<std::uint32_t> out;
        for (std::uint32_t i = 0; i < s.size(); ++i)
            if (triangles[i] == triangles[i + 1]) out.push_back(i);
        return out;
    }

    DiskIndex index_of() const {
        std::vector<Vec3> centers;
        std::vector<double> radii;
        for (const std::uint32_t i : disks_) {
            centers.push_back(scene_.surfels.positions[i]);
            radii.push_back(scene_.surfels.radii[i]);
        }
        return {centers, radii};
    }

    bool shares(std::uint32_t k, std::uint32_t hit, const Vec3& place, const Vec3& direction) const {
        const Surfels& s = scene_.surfels;
        const Vec3& n = s.normals[k];
        if (!(dot(n, direction) < 0.0) || dot(n, s.normals[hit]) < alike || !same_surface(scene_, hit, k)) return false;
        const Vec3 from = place - s.positions[k];
        if (std::abs(dot(n, from)) > layer_height * (s.radii[k] + s.radii[hit])) return false;
        for (std::uint32_t e = ends_[k]; e < ends_[k + 1]; ++e)
            if (dot(s.ends[e].normal, from) > s.ends[e].limit) return false;
        return true;
    }

    const Scene& scene_;
    std::vector<std::uint32_t> ends_, disks_;
    DiskIndex index_;
};

}  // namespace

NarrowLight::NarrowLight(const Scene& scene, const std::vector<Light>& lights, const Tracer& tracer, std::uint64_t seed,
                         const Progress& progress, std::size_t most)
    : lit_(lights.size()) {
    const Surfels& s = scene.surfels;
    const std::vector<std::uint32_t> triangles = triangle_ranges(s);
    std::unique_ptr<Sharing> sharing;
    for (std::size_t l = 0; l < lights.size(); ++l) {
        const std::unique_ptr<Source> source = source_of(lights[l]);
        if (!source) continue;
        std::vector<char> narrow(s.size());
        parallel_for(s.size(), 4096, [&](std::size_t k) {
            const auto i = static_cast<std::uint32_t>(k);
            narrow[k] = triangles[i] == triangles[i + 1] && source->is_narrow(s, i);
        });
        std::vector<Lit>& lit = lit_[l];
        for (std::uint32_t i = 0; i < s.size(); ++i)
            if (narrow[i]) lit.push_back({i, {}});
        if (lit.empty()) continue;
        if (!sharing) sharing = std::make_unique<Sharing>(scene);

        const std::size_t count =
            std::min(std::clamp(rays_each * lit.size(), source->fewest_rays(), most_rays), std::max(least_rays, most));
        EvenPoints even(4, seed + beam_stream + l, 0);
        std::vector<Beam> beams(count);
        double sum = 0.0;
        for (Beam& beam : beams) sum += (beam = source->beam(even.next())).power;
        if (!(sum > 0.0)) {  // so narrow that doubles have nothing of it: centres tell
            lit.clear();
            continue;
        }
        constexpr std::size_t block = 256;
        std::vector<std::vector<Sharing::Share>> found((count + block - 1) / block);
        parallel_blocks(
            count, block,
            [&](std::size_t begin, std::size_t end) {
                std::vector<Ray> rays;
                std::vector<Hit> hits;
                std::vector<Sharing::Share> shares;
                for (std::size_t k = begin; k < end; ++k)
                    rays.push_back({{beams[k].origin, beams[k].direction, Hit::none}, beams[k].direction});
                tracer.closest(rays, hits);
                for (std::size_t k = begin; k < end; ++k) {
                    const Hit& hit = hits[k - begin];
                    if (!hit || !hit.front || triangles[hit.surfel] != triangles[hit.surfel + 1]) continue;
                    const Vec3& d = beams[k].direction;
                    sharing->at(hit.surfel, beams[k].origin + hit.distance * d, d, shares);
                    for (const Sharing::Share& share : shares)
                        if (narrow[share.surfel])
                            found[begin / block].push_back({share.surfel, share.share * beams[k].power});
                }
            },
            progress);
        for (const auto& some : found)
            for (const Sharing::Share& share : some) {
                const auto at = std::lower_bound(lit.begin(), lit.end(), share.surfel,
                                                 [](const Lit& one, std::uint32_t i) { return one.surfel < i; });
                at->part.irradiance += share.share / sum;
            }
        for (auto& [surfel, part] : lit) {
            const double share = std::min(part.irradiance, 1.0),
                         density = source->power() /
                                   (s.areas.empty() ? pi * s.radii[surfel] * s.radii[surfel] : s.areas[surfel]);
            part = {share * density,
                    evenness * density * std::sqrt(share * (1.0 - share) / static_cast<double>(count))};
        }
    }
}

const NarrowLight::Part* NarrowLight::of(std::size_t light, std::uint32_t surfel) const {
    if (lit_.empty()) return nullptr;
    const std::vector<Lit>& lit = lit_[light];
    const auto at = std::lower_bound(lit.begin(), lit.end(), surfel,
                                     [](const Lit& one, std::uint32_t i) { return one.surfel < i; });
    return at != lit.end() && at->surfel == surfel ? &at->part : nullptr;
}

}  // namespace surflux
