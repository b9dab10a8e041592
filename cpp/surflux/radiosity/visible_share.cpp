#include "surflux/radiosity/visible_share.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "surflux/core/sampling.h"

namespace surflux {

namespace {

constexpr std::size_t streams = 8;

// What the rays of one stream met, by weight.
struct Stream {
    EvenPoints points;
    double all = 0.0, free = 0.0;
};

struct Estimate {
    double share = 0.0, error = 0.0;  // standard error
    bool mixed = false;               // some free, some not
    bool any = false;
};

// The ratio of sums, and its standard error from how the streams differ (Cochran 1977, eq. 6.9).
Estimate estimate(const std::array<Stream, streams>& tried) {
    double all = 0.0, free = 0.0;
    for (const Stream& s : tried) all += s.all, free += s.free;
    Estimate out;
    if (!(all > 0.0)) return out;
    out.any = true;
    out.share = free / all;
    out.mixed = free > 0.0 && free < all;
    double squares = 0.0;
    for (const Stream& s : tried) squares += (s.free - out.share * s.all) * (s.free - out.share * s.all);
    constexpr double count = streams;
    out.error = std::sqrt(squares * count / (count - 1.0)) / all;
    return out;
}

}  // namespace

VisibleShare::Share VisibleShare::operator()(std::uint32_t i, std::uint32_t j, PairExchange::Range range,
                                             double factor) const {
    using Range = PairExchange::Range;
    if (range == Range::same_surface || shafts_.empty(i, j)) return {};
    const bool near = range == Range::near;
    if (near && pairs_.extent(j) < pairs_.extent(i)) std::swap(i, j);
    const bool patches = pairs_.is_patch(i) && pairs_.is_patch(j);
    const bool by_hemisphere = near && factor > tuning_.hemisphere_factor;
    const Frame frame = frame_around(pairs_.normal(i));
    Share out;
    const auto try_points = [&](Stream& s, std::size_t count) {
        for (std::size_t k = 0; k < count; ++k) {
            const double* u = s.points.next();
            const Vec3 from = pairs_.ray_point(i, range, u[0], u[1]);
            Vec3 to;
            double weight = 1.0;
            if (by_hemisphere) {
                if (!pairs_.meets(j, from, frame.to_world(square_to_cosine_hemisphere(u[2], u[3])), to)) continue;
            } else {
                to = pairs_.ray_point(j, range, u[2], u[3]);
                weight = pairs_.kernel(i, from, j, to);
                if (weight <= 0.0) continue;
            }
            s.all += weight;
            ++out.rays;
            if (tracer_.free(segment(tracer_.on(i, from), to, j))) s.free += weight;
        }
    };
    const auto make = [&](std::size_t k) {
        return Stream{
            EvenPoints(4, seed_ + 0x9e3779b97f4a7c15ull * (k + 1), (static_cast<std::uint64_t>(i) << 32) | j)};
    };
    std::array<Stream, streams> tried{make(0), make(1), make(2), make(3), make(4), make(5), make(6), make(7)};
    // Of disks that are not near there is one point each, and one ray.
    const bool single = !near && !pairs_.is_patch(i) && !pairs_.is_patch(j);
    if (single) {
        try_points(tried[0], 1);
        out.value = tried[0].all > 0.0 ? tried[0].free / tried[0].all : 0.0;
        return out;
    }
    const double allowed = std::max(error_ / std::sqrt(factor), patches ? 0.0 : tuning_.disk_error);
    const double unseen = 3.0 / allowed;
    std::size_t taken = 0;
    Estimate found;
    const std::size_t most = whole_number(patches ? tuning_.most_points : tuning_.most_points_of_disks);
    for (std::size_t points = whole_number(tuning_.first_points);; points *= 2) {
        for (Stream& s : tried) try_points(s, points - taken);
        taken = points;
        found = estimate(tried);
        // Even points are off by less than independent ones, but eight streams say by how much only roughly: a quarter
        // of what independent points would be off by is the least that is believed.
        const double independent =
            std::sqrt(found.share * (1.0 - found.share) / std::max<double>(1.0, static_cast<double>(out.rays)));
        if (found.mixed ? std::max(found.error, independent / 4.0) <= 0.5 * allowed
                        : static_cast<double>(out.rays) >= unseen)
            break;
        if (points >= most) {
            out.precise = !patches;
            break;
        }
    }
    out.value = found.any ? found.share : 0.0;
    return out;
}

}  // namespace surflux
