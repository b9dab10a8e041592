// What HemisphereGather does about energy: what surfels send with their factors, and the factors of rows that follow.

#include <algorithm>
#include <utility>

#include "surflux/core/parallel.h"
#include "surflux/meshless/hemisphere_gather.h"

namespace surflux {

void HemisphereGather::sent(const std::vector<Rgb>& coefficients, std::vector<Rgb>& out) const {
    const Surfels& s = scene_.surfels;
    out.resize(s.size());
    parallel_for(s.size(), 256, [&](std::size_t i) {
        const double outside = means_.outside(i);
        const double scale = sender_scale_.empty() ? 1.0 : sender_scale_[i];
        out[i] = outside > 0.0 ? s.reflectance[i] * (means_.mean(i, coefficients) * (scale / outside)) : Rgb{};
    });
}

void HemisphereGather::set_sender_scale(std::vector<double> scale_of) {
    sender_scale_ = std::move(scale_of);
    scale_all();
}

void HemisphereGather::set_sender_power(SenderPower power) {
    sender_power_ = std::move(power);
    scale_all();
}

void HemisphereGather::scale_all() {
    parallel_for(rows_.size(), 64, [&](std::size_t k) { scale(rows_[k]); });
}

void HemisphereGather::scale(Gathered& of) const {
    if (sender_scale_.empty()) return;
    // The factor of a sum of light that is one of each sender's.
    struct Factor {
        double before = 0.0, after = 0.0;
        void add(double light, double factor) { before += light, after += factor * light; }
        double value() const { return before > 0.0 ? after / before : 1.0; }
    };
    Factor all, linked, lit, emitted, reflected;
    const bool keeps_power = !sender_power_.radiosity.empty();
    double units = 0.0;
    const auto add = [&](const Sender& sender) {
        const std::uint32_t i = sender.surfel;
        const double factor = sender_scale_[i], times = sender.units();
        units += times;
        all.add(times, factor);
        emitted.add(times * emission(i), keeps_power ? factor * sender_power_.emitted[i] : factor);
        if (keeps_power) reflected.add(times * factor * sender_power_.radiosity[i], sender_power_.reflected[i]);
        return factor;
    };
    for (const Sender& sender : of.senders) add(sender);
    for (const Sender& sender : of.linked) linked.add(sender.units(), add(sender));
    for (const Lit& of_surfel : of.lit) {
        const std::uint32_t i = of_surfel.surfel;
        lit.add(static_cast<double>(of_surfel.luminance),
                keeps_power ? sender_scale_[i] * sender_power_.exitance[i] : sender_scale_[i]);
    }
    Row& row = of.row;
    // Rays that met nothing which sends make a row complete, as in scale_by_reciprocity.
    all.add(std::max(0.0, 1.0 / row.share - units), 1.0);
    row.scale = 1.0 / all.value();
    row.linked_scale = row.scale * linked.value();
    row.first_scale = row.scale * lit.value();
    row.emitted_scale = row.scale * emitted.value();
    row.power_scale = reflected.value();
}

}  // namespace surflux
