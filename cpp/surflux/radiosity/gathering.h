#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/core/span.h"
#include "surflux/core/team.h"
#include "surflux/lights/aimed_row.h"
#include "surflux/lights/light_sampler.h"
#include "surflux/lights/sample_points.h"
#include "surflux/radiosity/surfel_tree.h"
#include "surflux/radiosity/tuning.h"
#include "surflux/scene/scene.h"
#include "surflux/solution/nodal_field.h"
#include "surflux/trace/tracer.h"

namespace surflux {

// The transport operator as a sparse matrix estimated by rays: for each receiver a row of links, each the share of its
// cosine-weighted hemisphere that a sender fills; with what escapes and what back faces absorb it makes 1. A ray's
// sender is the largest group that the cone the ray stands for covers: far senders act through their groups, near ones
// are surfels.
//   Shot once and kept: every bounce, every channel and every iteration of the refinement is one sparse product.
class Gathering {
public:
    struct Link {
        std::uint32_t sender;
        std::uint16_t first, second;  // units of either half of all rays that met it
        float u, v;                   // sum of the rays' slopes in the tangent plane, for TiltedRgb
    };
    struct Row {
        std::uint32_t block, begin, end;  // links
        std::uint32_t rays,
            units;  // a ray is one unit; of aimed ones (lights/aimed_row.h) each is as many as it stands for
        float escape, absorbed;  // shares
        float closeness;         // mean of 1 / distance of what the rays met
        float u, v;              // sum of the slopes of all rays: not quite 0, which is taken off (gather_tilted)
        double met() const { return 1.0 - static_cast<double>(escape) - static_cast<double>(absorbed); }
        bool is_aimed() const { return units != rays; }
        // Covered by something: it sees nothing but backs.
        bool is_buried() const { return begin == end && escape == 0.0f; }
    };
    // The sky is in no link: rays find that of one colour here; images of it are lights (LitPoints).
    Gathering(const SurfelPoints& points, const Tracer& tracer, const SurfelTree& tree, const LightSampler& skies,
              std::uint64_t seed, const RefinementTuning& tuning = {}, Team team = {});

    // More receivers, with as many rays each as `counts` has; evenest by powers of 2.
    void add(const std::vector<Place>& receivers, const std::vector<int>& counts, const Progress& progress = {});

    // Receivers whose rays are aimed at what is known to send (lights/aimed_row.h): `aims` gives that of each.
    using Aims = std::function<void(std::size_t receiver, std::vector<Aim>& out)>;
    void add_aimed(const std::vector<Place>& receivers, const std::vector<int>& counts, const Aims& aims,
                   const Progress& progress = {});
    // What a row knows of where light comes from, for a place nearby.
    void aims_of(std::size_t row, const std::vector<double>& sent, std::size_t channels, const Vec3& at,
                 std::vector<Aim>& out) const;

    std::size_t size() const { return rows_.size(); }
    const Place& place(std::size_t row) const { return places_[row]; }
    const Row& row(std::size_t row) const { return rows_[row]; }
    std::size_t links() const { return link_count_; }
    std::size_t rays() const { return rays_; }
    bool has_sky() const;  // whether any found anything of it
    // Per row, what its rays found of the sky.
    const std::vector<TiltedRgb>& sky() const { return sky_; }

    // Calls visit(sender, share) for all nodes that rays of a row met.
    template <class Visit>
    void for_senders(std::size_t row, const Visit& visit) const {
        const Row& r = rows_[row];
        for (const Link& link : links_of(r))
            visit(link.sender, static_cast<double>(link.first + link.second) / r.units);
    }
    // Irradiance of row from what all senders send, `channels` interleaved.
    void gather(std::size_t row, const std::vector<double>& sent, std::size_t channels, double* out) const;
    // The same of each half of the rays: they differ by about twice the standard error of the whole.
    void gather_halves(std::size_t row, const std::vector<double>& sent, std::size_t channels, double* first,
                       double* second) const;
    // The same for tilted normals, in 3 channels or one; the same light from everywhere has no tilt.
    TiltedRgb gather_tilted(std::size_t row, const std::vector<double>& sent, std::size_t channels) const;
    // How much what single rays bring differs: standard deviation, of channels by the weights of luminance.
    double deviation(std::size_t row, const std::vector<double>& sent, std::size_t channels) const;

private:
    struct Shot;
    Span<Link> links_of(const Row& row) const {
        const Link* of_block = links_[row.block].data();
        return {of_block + row.begin, of_block + row.end};
    }
    void shoot(const Place& receiver, int count, const std::vector<Aim>* aims, Shot& out) const;
    void add_rows(const std::vector<Place>& receivers, const std::vector<int>& counts, const Aims* aims,
                  const Progress& progress);

    const SurfelPoints& points_;
    const Tracer& tracer_;
    const SurfelTree& tree_;
    const LightSampler& skies_;
    std::uint64_t seed_;
    double grazing_, steepest_;
    Team team_;
    std::vector<Place> places_;
    std::vector<Row> rows_;
    std::vector<std::vector<Link>> links_;  // of some rows each
    std::vector<TiltedRgb> sky_;
    std::size_t rays_ = 0, link_count_ = 0;
};

}  // namespace surflux
