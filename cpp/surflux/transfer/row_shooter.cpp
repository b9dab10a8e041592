#include "surflux/transfer/row_shooter.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "surflux/core/error.h"
#include "surflux/core/parallel.h"
#include "surflux/lights/hemisphere_row.h"

namespace surflux {

namespace {

using Link = ShotRows::Link;

constexpr std::uint64_t ray_stream = 0x7a51;
constexpr double grazing = 0.25;  // cosine below which cones are taken to be no wider

}  // namespace

struct RowShooter::Shot {
    HemisphereRow found;
    struct Met {
        std::uint32_t sender;
        bool first;
        float u, v;
    };
    std::vector<Met> met;
    ShotRows::Row row;
    std::vector<Link> links;
};

void RowShooter::shoot(const Place& place, int count, Shot& shot) const {
    const Frame frame = frame_around(place.normal);
    gather_row(points_, tracer_, place, count, seed_ + ray_stream, shot.found);
    ShotRows::Row& row = shot.row = {};
    row.per_ray = 1.0f / static_cast<float>(count);
    shot.met.clear();
    int escaped = 0, into_backs = 0;
    for (int k = 0; k < count; ++k) {
        const Ray& ray = shot.found.rays[static_cast<std::size_t>(k)];
        const Hit& hit = shot.found.hits[static_cast<std::size_t>(k)];
        const double cosine = dot(ray.direction, frame.n),
                     steep = std::min(static_cast<double>(ShotRows::steepest), 1.0 / cosine);
        const auto u = static_cast<float>(steep * dot(ray.direction, frame.u));
        const auto v = static_cast<float>(steep * dot(ray.direction, frame.v));
        row.u += row.per_ray * u;
        row.v += row.per_ray * v;
        if (!hit || !hit.front) {
            (hit ? into_backs : escaped) += 1;
            continue;
        }
        // The cone that this ray stands for has pi / (count cos) of solid angle.
        const double reach = hit.distance / std::sqrt(count * std::max(grazing, cosine));
        shot.met.push_back({senders_.sender(hit.surfel, reach), 2 * k < count, u, v});
    }
    const auto share = [&](int rays) {
        return static_cast<std::uint16_t>(std::lround(ShotRows::share_scale * row.per_ray * static_cast<float>(rays)));
    };
    row.escape = share(escaped), row.into_backs = share(into_backs);
    std::stable_sort(shot.met.begin(), shot.met.end(),
                     [](const Shot::Met& a, const Shot::Met& b) { return a.sender < b.sender; });
    shot.links.clear();
    for (std::size_t from = 0, to = 0; from < shot.met.size(); from = to) {
        std::size_t first = 0, second = 0;
        float sum_u = 0.0f, sum_v = 0.0f;
        for (; to < shot.met.size() && shot.met[to].sender == shot.met[from].sender; ++to) {
            const Shot::Met& met = shot.met[to];
            if (first + second == ShotRows::most_rays) break;
            (met.first ? first : second) += 1;
            sum_u += met.u;
            sum_v += met.v;
        }
        const float scale = ShotRows::slope_scale / static_cast<float>(first + second);
        shot.links.push_back({shot.met[from].sender, static_cast<std::uint8_t>(first),
                              static_cast<std::uint8_t>(second), static_cast<std::int8_t>(std::lround(scale * sum_u)),
                              static_cast<std::int8_t>(std::lround(scale * sum_v))});
    }
}

void RowShooter::add(const std::vector<Place>& places, const std::vector<int>& counts, ShotRows& out,
                     const Progress& progress) const {
    constexpr std::size_t grain = 16;
    const std::size_t before = out.rows.size();
    out.rows.resize(before + places.size());
    std::vector<std::vector<Link>> found((places.size() + grain - 1) / grain);  // by blocks
    shared_blocks(
        team_, "rays", [&] { return digest_of_rays(seed_, places, counts); }, places.size(), grain,
        [&](std::size_t begin, std::size_t end) {
            Shot shot;
            std::vector<Link>& links = found[begin / grain];
            for (std::size_t k = begin; k < end; ++k) {
                shoot(places[k], counts[k], shot);
                shot.row.begin = static_cast<std::uint32_t>(links.size());
                links.insert(links.end(), shot.links.begin(), shot.links.end());
                shot.row.end = static_cast<std::uint32_t>(links.size());
                out.rows[before + k] = shot.row;
            }
        },
        [&](std::size_t begin, std::size_t end, Packed& to) {
            to.add(out.rows.data() + before + begin, end - begin);
            to.add(found[begin / grain]);
        },
        [&](std::size_t begin, std::size_t end, Unpacking& from) {
            from.take(out.rows.data() + before + begin, end - begin);
            found[begin / grain].clear();
            from.append_to(found[begin / grain]);
        },
        progress);
    for (std::size_t block = 0; block < found.size(); ++block) {
        const auto at = static_cast<std::uint32_t>(out.links.size());
        out.links.insert(out.links.end(), found[block].begin(), found[block].end());
        require(out.links.size() <= std::numeric_limits<std::uint32_t>::max(),
                "more than 2^32 links: a larger epsilon_t or fewer rays take less");
        std::vector<Link>().swap(found[block]);
        for (std::size_t k = block * grain; k < std::min(places.size(), (block + 1) * grain); ++k) {
            out.rows[before + k].begin += at;
            out.rows[before + k].end += at;
        }
    }
    for (std::size_t k = 0; k < places.size(); ++k) {
        out.positions.push_back(places[k].position);
        out.normals.push_back(places[k].normal);
        out.surfels.push_back(places[k].surfel);
        out.shapes.push_back(places[k].shape);
        out.rays += static_cast<std::size_t>(counts[k]);
    }
}

}  // namespace surflux
