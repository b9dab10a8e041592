// What HemisphereGather knows of the noise of its rows, and rows that are shot anew for it.

#include "surflux/meshless/hemisphere_gather.h"

namespace surflux {

double HemisphereGather::standard_error(std::size_t row, const std::vector<Rgb>& sent) const {
    const Gathered& of = rows_[row];
    Rgb reflected;
    for (const std::vector<Sender>* met : {&of.senders, &of.linked})
        for (const Sender& sender : *met)
            reflected += (static_cast<double>(sender.first) - sender.second) * sent[sender.surfel];
    return color_norm(of.row.halves + of.row.share * reflected);
}

void HemisphereGather::aim(const std::vector<Shot>& rows, const Aims& aims, const Progress& progress) {
    shoot_all("aimed rays", rows, &aims, progress);
}

void HemisphereGather::ends(const Place& place, int count, const std::vector<Rgb>& sent, std::vector<End>& out) const {
    HemisphereRow row;
    gather_row(light_.points(), tracer_, place, count, options_.seed + ray_stream, row);
    out.clear();
    for (std::size_t k = 0; k < row.rays.size(); ++k) {
        const Hit& hit = row.hits[k];
        const Ray& ray = row.rays[k];
        if (!hit)
            out.push_back({ray.direction,
                           luminance(light_.skies().found(ray.from.position, place.normal, ray.direction, hit)), true});
        else if (hit.front)
            out.push_back({ray.from.position + hit.distance * ray.direction,
                           luminance(sent[hit.surfel]) + exitance_[hit.surfel] + emission(hit.surfel), false});
    }
}

}  // namespace surflux
