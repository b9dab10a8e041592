#include "surflux/meshless/hemisphere_gather.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "surflux/core/parallel.h"
#include "surflux/core/sampling.h"
#include "surflux/meshless/gather_sums.h"

namespace surflux {

namespace {

constexpr std::uint64_t light_stream = 0x11647, aimed_stream = 0xa13ed;

// What surfels send of light that is not in the basis.
std::vector<double> exitances(const Surfels& surfels, const SurfaceLight& light) {
    std::vector<double> out(surfels.size());
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = luminance(surfels.reflectance[i] * light.beside_basis(i));
    return out;
}

}  // namespace

HemisphereGather::HemisphereGather(const Scene& scene, const Tracer& tracer, const SurfaceLight& light,
                                   const MultilevelBasis& basis, const SurfelMeans& means, const GatherOptions& options,
                                   Team team)
    : scene_(scene),
      tracer_(tracer),
      light_(light),
      basis_(basis),
      means_(means),
      options_(options),
      team_(std::move(team)),
      exitance_(exitances(scene.surfels, light)),
      lit_(scene.surfels, light.points(), exitance_) {}

// A wide patch does where it is small as seen from `distance`, any other surfel always; but what seems to be inside
// geometry, which has no mean.
bool HemisphereGather::sends_by_mean(std::uint32_t surfel, double distance) const {
    if (means_.outside(surfel) == 0.0) return false;
    const double radius = scene_.surfels.radii[surfel];
    return !means_.is_wide(surfel) || pi * radius * radius < options_.epsilon_omega * distance * distance;
}

// Links an end to the levels from `first_level` on, until supports are small. Would it go on to a finer level?
bool HemisphereGather::link(std::size_t first_level, const OpenEnd& end, Sums& sums) const {
    const double squared = static_cast<double>(end.distance) * static_cast<double>(end.distance);
    for (std::size_t level = first_level; level < basis_.levels(); ++level) {
        means_.at_level(level, end.surfel, end.position, sums.weights);
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

// MIS weight of a hemisphere ray that hits a lit patch: light sampling could have found it too (balance heuristic,
// Veach and Guibas 1995). Densities per unit of area at the hit, times the numbers of samples.
double HemisphereGather::mis_weight(const Ray& ray, const Hit& hit, int light_samples, const Sums& sums) const {
    const double by_light = light_samples > 0 ? light_samples * lit_.density(sums.aim, hit.surfel) : 0.0;
    if (!(by_light > 0.0)) return 1.0;
    const double cosines =
        dot(ray.direction, ray.from.normal) * -dot(ray.direction, scene_.surfels.normals[hit.surfel]);
    const double over = sums.density(ray.direction) * std::max(cosines, 1e-30);
    return 1.0 / (1.0 + by_light * pi * hit.distance * hit.distance / over);
}

// Next event estimation towards lit patches: the samples on them that face the place, each with its MIS weight in its
// gain. Their rays leave from where the hemisphere's do.
void HemisphereGather::sample_lit_patches(const Place& place, int count, Random& random, Sums& sums) const {
    sums.lit_samples.clear(), sums.lit_rays.clear();
    for (int k = 0; k < count; ++k) {
        const double choice = (k + random.uniform()) / count, u = random.uniform(), v = random.uniform();
        const LitPatches::Target to = lit_.sample(sums.aim, choice, u, v);
        const Departure& from = sums.aimed.found.rays[static_cast<std::size_t>(k)].from;
        const Vec3 d = to.point - from.position;
        const double distance = length(d), here = dot(d, place.normal),
                     there = -dot(d, scene_.surfels.normals[to.surfel]);
        if (!(here > 0.0 && there > 0.0)) continue;
        const double squared = distance * distance, irradiance = here * there / (pi * squared * squared);
        const double density = sums.density(d / distance);
        const double densities = density * irradiance + count * lit_.density(sums.aim, to.surfel);
        sums.lit_samples.push_back(
            {to, distance, density, irradiance / densities * scene_.surfels.reflectance[to.surfel], k % 2 != 0});
        sums.lit_rays.push_back({from, d / distance});  // what it meets first decides, not how far it was meant to go
    }
}

// The first bounce of light beside the basis, of a point of a surfel: from a patch that is near by a ray from that
// point.
void HemisphereGather::reflect(const Vec3& at, std::uint32_t i, double distance, double density, const Rgb& gain,
                               bool second_half, Random& random, Sums& sums) const {
    const Surfels& s = scene_.surfels;
    const double radius = s.radii[i];
    if (!light_.points().is_patch(i) ||
        radius * radius * density <= options_.tuning.rays_on_a_patch * distance * distance) {
        sums.add_first(i, gain * light_.beside_basis(i), second_half);
        return;
    }
    const double u[3] = {random.uniform(), random.uniform(), random.uniform()};
    if (light_.has_found()) {
        const Vec3 direction =
            frame_around(s.normals[i]).to_world(square_to_cosine_hemisphere(random.uniform(), random.uniform()));
        sums.ahead.push_back({{at, s.normals[i], i}, direction});
        sums.ahead_gain.push_back({i, gain, second_half});
    }
    light_.towards(at, s.normals[i], u, random, sums.of_lights);
    for (const LightRay& light : sums.of_lights) {
        if (!(light.length > 0.0)) continue;
        sums.towards.add({at, s.normals[i], i}, light);
        sums.gain.push_back({i, gain * light.irradiance, second_half});
    }
}

// By surfel, each once, or as often as its units are more than two bytes can count.
void HemisphereGather::merge(std::vector<Sender>& senders) {
    constexpr std::uint32_t most = std::numeric_limits<std::uint16_t>::max();
    std::sort(senders.begin(), senders.end(), [](const Sender& a, const Sender& b) { return a.surfel < b.surfel; });
    std::size_t kept = 0;
    for (const Sender& of : senders) {
        Sender* same = kept > 0 ? &senders[kept - 1] : nullptr;
        if (same && same->surfel == of.surfel && std::uint32_t{same->first} + of.first <= most &&
            std::uint32_t{same->second} + of.second <= most) {
            same->first = static_cast<std::uint16_t>(same->first + of.first);
            same->second = static_cast<std::uint16_t>(same->second + of.second);
        } else {
            senders[kept++] = of;
        }
    }
    senders.resize(kept);
    senders.shrink_to_fit();
}

void HemisphereGather::shoot(const Place& place, int count, const std::vector<Aim>* aims, Sums& sums,
                             Gathered& out) const {
    const Surfels& s = scene_.surfels;
    int over = count, light_samples = 0;
    if (lit_.aim(place.position, place.normal, sums.aim)) {
        over -= static_cast<int>((1.0 - options_.tuning.over_hemisphere) * lit_.share() * count);
        light_samples = std::min(over, static_cast<int>(options_.tuning.light_samples_for_each * lit_.share() * count));
    }
    const HemisphereRow& shot = sums.aimed.found;
    if (aims) {
        gather_aimed_row(light_.points(), tracer_, place, over, *aims, options_.seed + aimed_stream, sums.aimed);
        sums.frame = frame_around(place.normal);
        light_samples = std::min(light_samples, static_cast<int>(shot.rays.size()));  // they leave from where rays do
    } else {
        gather_row(light_.points(), tracer_, place, over, options_.seed + ray_stream, sums.aimed.found);
        sums.aimed.density.clear();
        sums.aimed.unit = static_cast<std::uint32_t>(over);
    }
    sums.towards.clear(), sums.gain.clear();
    sums.ahead.clear(), sums.ahead_gain.clear();
    sums.lit.clear();
    sums.first = sums.halves[0] = sums.halves[1] = {};
    out.row.rays = shot.rays.size();
    out.row.share = 1.0 / sums.aimed.unit;
    Random random(options_.seed + light_stream, stream_of(place));
    for (std::size_t k = 0; k < shot.rays.size(); ++k) {
        const Ray& ray = shot.rays[k];
        const Hit& hit = shot.hits[k];
        const std::uint16_t units = aims ? sums.aimed.units[k] : 1;
        const double each = units * out.row.share;
        const bool second_half = aims ? sums.aimed.first[k] == 0 : 2 * k >= shot.rays.size();
        const auto sends_from = [&](std::uint32_t i) -> Sender {
            return {i, second_half ? std::uint16_t{0} : units, second_half ? units : std::uint16_t{0}};
        };
        const auto take = [&](Rgb& to, const Rgb& light) {
            to += light;
            sums.halves[second_half] += light;
        };
        const auto found = [&](const LightSampler& lights) {
            return each * lights.found(ray.from.position, place.normal, ray.direction, hit);
        };
        if (!hit.front) {
            (hit ? out.row.into_backs : out.row.escape) += each;
            if (!hit) take(out.row.sky, found(light_.skies()));
            continue;
        }
        const std::uint32_t i = hit.surfel;
        if (finds_emission(i)) take(out.row.emitted, each * s.emission[i]);
        const Rgb rho = each * s.reflectance[i];
        if (rho == Rgb{}) {
            if (sends(i)) out.senders.push_back(sends_from(i));
            continue;
        }
        const Vec3 at = ray.from.position + hit.distance * ray.direction;
        if (!light_.is_dark())
            reflect(at, i, hit.distance, sums.density(ray.direction), mis_weight(ray, hit, light_samples, sums) * rho,
                    second_half, random, sums);
        if (sends_by_mean(i, hit.distance)) {
            out.senders.push_back(sends_from(i));
            continue;
        }
        out.linked.push_back(sends_from(i));
        OpenEnd end{at, i, static_cast<float>(hit.distance), {}};
        for (int c = 0; c < 3; ++c) end.share[c] = static_cast<float>(rho[c]);
        if (link(0, end, sums)) out.open.push_back(end);
    }
    sample_lit_patches(place, light_samples, random, sums);
    tracer_.closest(sums.lit_rays, sums.hits);
    for (std::size_t k = 0; k < sums.lit_samples.size(); ++k) {
        const Sums::LitSample& to = sums.lit_samples[k];
        const Hit& hit = sums.hits[k];
        if (hit.front && hit.surfel == to.at.surfel)
            reflect(to.at.point, to.at.surfel, to.distance, to.density, to.gain, to.second_half, random, sums);
    }
    const std::vector<char>& arrives = sums.towards.trace(tracer_);
    for (std::size_t k = 0; k < arrives.size(); ++k) {
        const Sums::Gain& gain = sums.gain[k];
        if (arrives[k]) sums.add_first(gain.surfel, gain.of, gain.second_half);
    }
    tracer_.closest(sums.ahead, sums.hits);
    for (std::size_t k = 0; k < sums.ahead.size(); ++k) {
        const Sums::Gain& gain = sums.ahead_gain[k];
        const Rgb found = light_.found(sums.ahead[k], sums.hits[k]);
        sums.add_first(gain.surfel, gain.of * found, gain.second_half);
    }
    out.row.first_bounce = sums.first;
    out.row.halves = sums.halves[0] - sums.halves[1];
    merge(out.senders);
    merge(out.linked);
    sums.take(out.links);
    sums.take_lit(out.lit);
    if (has_factors(place)) scale(out);
}

// What other processes know of a row once it has been shot or, of one that they have, what extend() changed: links from
// one on, and open ends.
void HemisphereGather::pack(const Gathered& row, std::size_t first_link, Packed& to) {
    to.add(row.row);
    to.add(row.senders);
    to.add(row.linked);
    to.add(row.lit);
    to.add(static_cast<std::uint64_t>(row.links.size() - first_link));
    to.add(row.links.data() + first_link, row.links.size() - first_link);
    to.add(row.open);
}

void HemisphereGather::unpack(Unpacking& from, std::size_t first_link, Gathered& row) {
    row.row = from.take<Row>();
    for (std::vector<Sender>* met : {&row.senders, &row.linked}) {
        met->clear();
        from.append_to(*met);
    }
    row.lit.clear();
    from.append_to(row.lit);
    row.links.resize(first_link);
    from.append_to(row.links);
    row.open.clear();
    from.append_to(row.open);
}

void HemisphereGather::shoot_all(const char* name, const std::vector<Shot>& rows, const Aims* aims,
                                 const Progress& progress) {
    levels_ = basis_.levels();
    Scratch<Sums> scratch;
    const auto digest = [&] {
        std::vector<Place> places;
        std::vector<int> counts;
        for (const Shot& of : rows) places.push_back(of.place), counts.push_back(of.count);
        return digest_of_rays(options_.seed, places, counts);
    };
    shared_blocks(
        team_, name, digest, rows.size(), 8,
        [&](std::size_t begin, std::size_t end) {
            const Scratch<Sums>::Lent lent(scratch);
            Sums& sums = *lent;
            sums.make_room(basis_.size());
            std::vector<Aim> at;
            for (std::size_t k = begin; k < end; ++k) {
                at.clear();
                if (aims) (*aims)(k, at);
                Gathered& row = rows_[rows[k].row];
                row = {};
                shoot(rows[k].place, rows[k].count, aims ? &at : nullptr, sums, row);
            }
        },
        [&](std::size_t begin, std::size_t end, Packed& to) {
            for (std::size_t k = begin; k < end; ++k) pack(rows_[rows[k].row], 0, to);
        },
        [&](std::size_t begin, std::size_t end, Unpacking& from) {
            for (std::size_t k = begin; k < end; ++k) unpack(from, 0, rows_[rows[k].row]);
        },
        progress);
    count_links();
    for (const Shot& of : rows) rays_ += rows_[of.row].row.rays;
}

void HemisphereGather::add(const std::vector<Place>& places, const std::vector<int>& counts, const Progress& progress) {
    std::vector<Shot> rows;
    for (std::size_t k = 0; k < places.size(); ++k) rows.push_back({rows_.size() + k, places[k], counts[k]});
    rows_.resize(rows_.size() + rows.size());
    shoot_all("rays", rows, nullptr, progress);
}

void HemisphereGather::extend(const Progress& progress) {
    Scratch<Sums> scratch;
    std::vector<std::size_t> links;  // of each row, before
    if (team_.shares())
        for (const Gathered& row : rows_) links.push_back(row.links.size());
    shared_blocks(
        team_, "links", [&] { return digest_of(links); }, rows_.size(), 64,
        [&](std::size_t begin, std::size_t end) {
            const Scratch<Sums>::Lent lent(scratch);
            Sums& sums = *lent;
            sums.make_room(basis_.size());
            for (std::size_t k = begin; k < end; ++k) {
                Gathered& row = rows_[k];
                row.open.erase(std::remove_if(row.open.begin(), row.open.end(),
                                              [&](const OpenEnd& e) { return !link(levels_, e, sums); }),
                               row.open.end());
                sums.take(row.links);
            }
        },
        [&](std::size_t begin, std::size_t end, Packed& to) {
            for (std::size_t k = begin; k < end; ++k) pack(rows_[k], links[k], to);
        },
        [&](std::size_t begin, std::size_t end, Unpacking& from) {
            for (std::size_t k = begin; k < end; ++k) unpack(from, links[k], rows_[k]);
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
    Scratch<Sums> scratch;
    shared_blocks(
        team_, "rays", [&] { return digest_of_rays(options_.seed, places, counts); }, places.size(), 8,
        [&](std::size_t begin, std::size_t end) {
            const Scratch<Sums>::Lent lent(scratch);
            Sums& sums = *lent;
            sums.make_room(basis_.size());
            for (std::size_t k = begin; k < end; ++k) {
                Gathered row;
                shoot(places[k], counts[k], nullptr, sums, row);
                out[k] = {row.row, has_factors(places[k]) ? row.row.power_scale * gather(row, coefficients, sent)
                                                          : gather_unscaled(row, coefficients, sent)};
            }
        },
        [&](std::size_t begin, std::size_t end, Packed& to) { to.add(out.data() + begin, end - begin); },
        [&](std::size_t begin, std::size_t end, Unpacking& from) { from.take(out.data() + begin, end - begin); },
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

Rgb HemisphereGather::gather_linked(const Gathered& of, const std::vector<Rgb>& coefficients) {
    Rgb linked;
    for (const Link& link : of.links) {
        const Rgb& value = coefficients[link.function];
        for (int c = 0; c < 3; ++c) linked[c] += static_cast<double>(link.share[c]) * value[c];
    }
    return linked;
}

Rgb HemisphereGather::gather(const Gathered& of, const std::vector<Rgb>& coefficients, const std::vector<Rgb>& sent) {
    Rgb sum;
    for (const Sender& sender : of.senders) sum += sender.units() * sent[sender.surfel];
    return (of.row.share * of.row.scale) * sum + of.row.linked_scale * gather_linked(of, coefficients);
}

Rgb HemisphereGather::gather_unscaled(const Gathered& of, const std::vector<Rgb>& coefficients,
                                      const std::vector<Rgb>& sent) const {
    Rgb sum;
    for (const Sender& sender : of.senders) {
        const double scale = sender_scale_.empty() ? 1.0 : sender_scale_[sender.surfel];
        sum += (sender.units() / scale) * sent[sender.surfel];
    }
    return of.row.share * sum + gather_linked(of, coefficients);
}

}  // namespace surflux
