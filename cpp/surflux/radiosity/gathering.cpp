#include "surflux/radiosity/gathering.h"

#include <algorithm>
#include <cmath>

#include "surflux/lights/hemisphere_row.h"

namespace surflux {

namespace {

constexpr std::uint64_t ray_stream = 0x9a7e41;

// Takes from a tilt what the same light from everywhere would give with these rays.
void level(TiltedRgb& light, const Gathering::Row& row) {
    light.u -= static_cast<double>(row.u) * light.value;
    light.v -= static_cast<double>(row.v) * light.value;
}

bool is_lit(const TiltedRgb& light) { return !(light.value == Rgb{}); }

}  // namespace

struct Gathering::Shot {
    std::vector<Link> links;
    Row row{};
    TiltedRgb sky;
    AimedRow aimed;
};

Gathering::Gathering(const SurfelPoints& points, const Tracer& tracer, const SurfelTree& tree,
                     const LightSampler& skies, std::uint64_t seed, const RefinementTuning& tuning, Team team)
    : points_(points),
      tracer_(tracer),
      tree_(tree),
      skies_(skies),
      seed_(seed),
      grazing_(tuning.grazing),
      steepest_(tuning.steepest),
      team_(std::move(team)) {}

bool Gathering::has_sky() const { return std::any_of(sky_.begin(), sky_.end(), is_lit); }

void Gathering::shoot(const Place& receiver, int count, const std::vector<Aim>* aims, Shot& out) const {
    const Frame frame = frame_around(receiver.normal);
    const HemisphereRow& found = out.aimed.found;
    if (aims) {
        gather_aimed_row(points_, tracer_, receiver, count, *aims, seed_ + ray_stream, out.aimed);
    } else {
        gather_row(points_, tracer_, receiver, count, seed_ + ray_stream, out.aimed.found);
        out.aimed.unit = static_cast<std::uint32_t>(count);
    }
    const double all = out.aimed.unit;
    out.links.clear();
    out.sky = {};
    out.row = {};
    const double steepest = steepest_;
    std::uint32_t escaped = 0, absorbed = 0;
    double closeness = 0.0;
    for (std::size_t k = 0; k < found.rays.size(); ++k) {
        const Ray& ray = found.rays[k];
        const Hit& hit = found.hits[k];
        const std::uint16_t units = aims ? out.aimed.units[k] : 1;
        const double share = units / all, rays_like_it = all / units;
        const double cosine = dot(ray.direction, frame.n), steep = std::min(steepest, 1.0 / cosine) * share;
        const double u = steep * dot(ray.direction, frame.u), v = steep * dot(ray.direction, frame.v);
        out.row.u += static_cast<float>(u);
        out.row.v += static_cast<float>(v);
        const auto add = [&](TiltedRgb& to, const Rgb& light) {
            to.value += share * light;
            to.u += u * light;
            to.v += v * light;
        };
        if (!hit) {
            escaped += units;
            add(out.sky, skies_.found(ray.from.position, frame.n, ray.direction, hit));
            continue;
        }
        closeness += share / std::max(hit.distance, tracer_.contact(hit.surfel));
        if (!hit.front) {
            absorbed += units;
            continue;
        }
        // The cone that this ray stands for has pi / (rays cos) of solid angle. Half its width: what a group hides of
        // itself is darker than what of it is seen, so that larger ones send too little.
        const std::uint32_t sender =
            tree_.sender(hit.surfel, ray.from.position + hit.distance * ray.direction,
                         0.5 * hit.distance / std::sqrt(rays_like_it * std::max(grazing_, cosine)));
        // Of a net of 2^m points the first half is one, and so is the second; every other one is not.
        const bool first = aims ? out.aimed.first[k] != 0 : 2 * k < found.rays.size();
        out.links.push_back({sender, first ? units : std::uint16_t{0}, first ? std::uint16_t{0} : units,
                             static_cast<float>(u), static_cast<float>(v)});
    }
    std::stable_sort(out.links.begin(), out.links.end(),
                     [](const Link& a, const Link& b) { return a.sender < b.sender; });
    std::size_t kept = 0;
    for (std::size_t k = 0; k < out.links.size(); ++k) {
        const Link& link = out.links[k];
        if (kept > 0 && out.links[kept - 1].sender == link.sender) {
            Link& same = out.links[kept - 1];
            same.first = static_cast<std::uint16_t>(same.first + link.first);
            same.second = static_cast<std::uint16_t>(same.second + link.second);
            same.u += link.u;
            same.v += link.v;
        } else {
            out.links[kept++] = link;
        }
    }
    out.links.resize(kept);
    level(out.sky, out.row);
    out.row.rays = static_cast<std::uint32_t>(found.rays.size());
    out.row.units = out.aimed.unit;
    out.row.escape = static_cast<float>(escaped / all);
    out.row.absorbed = static_cast<float>(absorbed / all);
    out.row.closeness = static_cast<float>(closeness);
}

void Gathering::add(const std::vector<Place>& receivers, const std::vector<int>& counts, const Progress& progress) {
    add_rows(receivers, counts, nullptr, progress);
}

void Gathering::add_aimed(const std::vector<Place>& receivers, const std::vector<int>& counts, const Aims& aims,
                          const Progress& progress) {
    add_rows(receivers, counts, &aims, progress);
}

void Gathering::aims_of(std::size_t row, const std::vector<double>& sent, std::size_t channels, const Vec3& at,
                        std::vector<Aim>& out) const {
    const Row& r = rows_[row];
    for (const Link& link : links_of(r)) {
        const double* from = sent.data() + link.sender * channels;
        const double light = channels == 1 ? from[0] : luminance({from[0], from[1], from[2]});
        const Vec3 way = tree_.position(tree_.representative(link.sender)) - at;
        const double far = length(way);
        if (far > 0.0)
            out.push_back({way / far, light * light * static_cast<double>(link.first + link.second) / r.units});
    }
}

void Gathering::add_rows(const std::vector<Place>& receivers, const std::vector<int>& counts, const Aims* aims,
                         const Progress& progress) {
    constexpr std::size_t grain = 16;
    const std::size_t before = rows_.size(), first_block = links_.size();
    rows_.resize(before + receivers.size());
    sky_.resize(before + receivers.size());
    links_.resize(first_block + (receivers.size() + grain - 1) / grain);
    const auto digest = [&] {
        Digest of = digest_of_places(seed_, receivers);
        of.add(counts);
        return of.value();
    };
    shared_blocks(
        team_, "rays", digest, receivers.size(), grain,
        [&](std::size_t begin, std::size_t end) {
            const std::size_t block = first_block + begin / grain;
            std::vector<Link> links;
            Shot shot;
            std::vector<Aim> aimed_at;
            for (std::size_t k = begin; k < end; ++k) {
                aimed_at.clear();
                if (aims) (*aims)(k, aimed_at);
                shoot(receivers[k], counts[k], aims ? &aimed_at : nullptr, shot);
                shot.row.block = static_cast<std::uint32_t>(block);
                shot.row.begin = static_cast<std::uint32_t>(links.size());
                links.insert(links.end(), shot.links.begin(), shot.links.end());
                shot.row.end = static_cast<std::uint32_t>(links.size());
                rows_[before + k] = shot.row;
                sky_[before + k] = shot.sky;
            }
            links_[block].assign(links.begin(), links.end());  // as many as there are, and no more
        },
        [&](std::size_t begin, std::size_t end, Packed& to) {
            const Row* rows = rows_.data() + before;
            const TiltedRgb* sky = sky_.data() + before;
            const bool any_sky = std::any_of(sky + begin, sky + end, is_lit);
            to.add(rows + begin, end - begin);
            to.add(any_sky);
            if (any_sky) to.add(sky + begin, end - begin);
            const std::vector<Link>& links = links_[first_block + begin / grain];
            to.add(links.data(), links.size());
        },
        [&](std::size_t begin, std::size_t end, Unpacking& from) {
            from.take(rows_.data() + before + begin, end - begin);
            if (from.take<bool>()) from.take(sky_.data() + before + begin, end - begin);
            std::vector<Link>& links = links_[first_block + begin / grain];
            links.resize(rows_[before + end - 1].end);
            from.take(links.data(), links.size());
        },
        progress);
    for (std::size_t k = before; k < rows_.size(); ++k) rays_ += rows_[k].rays;
    for (std::size_t block = first_block; block < links_.size(); ++block) link_count_ += links_[block].size();
    places_.insert(places_.end(), receivers.begin(), receivers.end());
}

void Gathering::gather(std::size_t row, const std::vector<double>& sent, std::size_t channels, double* out) const {
    const Row& r = rows_[row];
    double sum[3] = {};
    for (const Link& link : links_of(r)) {
        const double* from = sent.data() + link.sender * channels;
        for (std::size_t c = 0; c < channels; ++c) sum[c] += (link.first + link.second) * from[c];
    }
    for (std::size_t c = 0; c < channels; ++c) out[c] = sum[c] / r.units;
}

void Gathering::gather_halves(std::size_t row, const std::vector<double>& sent, std::size_t channels, double* first,
                              double* second) const {
    const Row& r = rows_[row];
    for (std::size_t c = 0; c < channels; ++c) first[c] = second[c] = 0.0;
    for (const Link& link : links_of(r)) {
        for (std::size_t c = 0; c < channels; ++c) {
            const double from = sent[link.sender * channels + c];
            first[c] += link.first * from;
            second[c] += link.second * from;
        }
    }
    for (std::size_t c = 0; c < channels; ++c) {
        first[c] *= 2.0 / r.units;
        second[c] *= 2.0 / r.units;
    }
}

TiltedRgb Gathering::gather_tilted(std::size_t row, const std::vector<double>& sent, std::size_t channels) const {
    const Row& r = rows_[row];
    TiltedRgb out;
    for (const Link& link : links_of(r)) {
        const double* from = sent.data() + link.sender * channels;
        const Rgb light = channels == 1 ? Rgb{from[0], from[0], from[0]} : Rgb{from[0], from[1], from[2]};
        out.value += (static_cast<double>(link.first + link.second) / r.units) * light;
        out.u += static_cast<double>(link.u) * light;
        out.v += static_cast<double>(link.v) * light;
    }
    level(out, r);
    return out;
}

double Gathering::deviation(std::size_t row, const std::vector<double>& sent, std::size_t channels) const {
    const Row& r = rows_[row];
    Rgb sum, squared;
    const auto add = [&](double share, const Rgb& light) {
        sum += share * light;
        squared += share * (light * light);
    };
    for (const Link& link : links_of(r)) {
        const double* from = sent.data() + link.sender * channels;
        add(static_cast<double>(link.first + link.second) / r.units,
            channels == 1 ? Rgb{from[0], from[0], from[0]} : Rgb{from[0], from[1], from[2]});
    }
    const auto escape = static_cast<double>(r.escape);
    if (escape > 0.0) add(escape, sky_[row].value / escape);
    return std::sqrt(std::max(0.0, luminance(squared - sum * sum)));
}

}  // namespace surflux
