#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/core/team.h"
#include "surflux/core/vec.h"
#include "surflux/lights/sample_points.h"
#include "surflux/scene/surfels.h"
#include "surflux/solution/solution.h"
#include "surflux/trace/compiled_scene.h"
#include "surflux/transfer/sender_groups.h"
#include "surflux/transfer/shot_rows.h"
#include "surflux/transfer/sparse_rows.h"

namespace surflux {

struct OperatorOptions {
    enum class Lighting { local, distant, sky };
    Lighting lighting = Lighting::local;
    int levels = 6;                 // of the basis, at most
    double radius = 0.0;            // of the Poisson disks of the first; 0: by the size of each object
    double epsilon = 0.1;           // what a receiver may be off by before it is refined: of the RMS of test lights,
                                    // of distant light the RMS over the sphere of what it sees
    int rays = 512;                 // of a receiver
    std::size_t senders = 65536;    // groups of surfels whose light is known
    std::size_t samples = 4;        // of unoccluded light in each of those
    std::size_t test_lights = 512;  // lamps, by which receivers are refined
    std::optional<Box> region;      // in which lamps will be; none: anywhere in the air
    double max_memory = 0.0;  // bytes for the operator and for finding it; 0: three quarters of available_memory()
    std::uint64_t seed = 0;
    Team team = {};  // of processes that share out what is expensive
};

// The transport operator of a scene, which knows no light (L07 sec. 6.5): from what groups of surfels send to
// irradiance at receivers, the points of a multilevel Shepard basis (L07 4), and from there to groups and surfels.
// Plain data: it refers to nothing. Neither does it know reflectance: senders are given what they send.
//   L07 links basis functions to basis functions. Here rays link receivers to groups of surfels, so that of senders
// nothing is interpolated, whatever their number, and rays that meet far ones count for all of a group.
//   It is applied once more for each reflection. T + T^2 + T^3 (L07 6.5), formed once, would be nearly dense between
// groups: T^2 alone has 15 % of all entries in Sponza, 660 million, where T has 4.3 million links, and 97 % in statues.
struct TransportOperator {
    using Row = ShotRows::Row;
    // What rays of a row met: a sender, by the upper 24 bits, and by the others how many rays.
    using Link = std::uint32_t;
    static constexpr int ray_bits = 8;
    static constexpr std::size_t most_senders = std::size_t{1} << (32 - ray_bits);
    static std::uint32_t sender(Link link) { return link >> ray_bits; }
    static float rays_of(Link link) { return static_cast<float>(link & ((1u << ray_bits) - 1u)); }
    // Their mean slopes, as ShotRows has them.
    struct Slope {
        std::int8_t u, v;
    };
    // Irradiance and its rotation gradient (Ward and Heckbert 1992): n' . gradient is what a normal n' near the
    // receiver's has more. Together they are vector irradiance, value * normal + gradient, but that light is taken to
    // go on below the horizon of the receiver. Of each color its value, then the gradient along x, y and z.
    static constexpr std::size_t tilted_channels = 4 * 3;

    // Receivers, in the order of the functions that are theirs: level by level, neighbours near each other.
    std::vector<Vec3> positions, normals;
    std::vector<std::uint32_t> surfels;  // that they lie on
    std::vector<Row> rows;
    std::vector<Link> links;
    std::vector<Slope> slopes;  // of links
    // Where a row's rays leave: all of its surfel where it is of surfels' own, else a point.
    Place place(std::size_t row) const;

    // Functions of the basis, coarse levels first: the receiver at the point of each, and its parents, the functions of
    // coarser levels there, that it is the difference from (L07 eq. 10). Behind them those of patches in nooks and
    // of surfels that the basis is off on, a function for each cluster: 1 on its surfels (in nooks in proportion to
    // what is not inside geometry), where nothing else is.
    std::vector<std::uint32_t> receiver_of, level_begin;
    SparseRows parents;
    SparseRows at_groups;   // the mean of each function over each leaf of the senders
    SparseRows at_surfels;  // over each surfel

    SenderGroups senders;
    SenderSamples samples;      // none where no lamps are to light them
    std::vector<double> areas;  // of each surfel what is not inside geometry

    // What is reflected again goes by way of the first levels alone, and of rows of surfels' own: another gather blurs
    // it. Other functions are not in at_groups.
    std::size_t bounce_levels = std::numeric_limits<std::size_t>::max();
    std::size_t rays = 0;
    std::size_t left_out = 0;  // receivers and surfels that max_memory kept from being refined

    // All receivers and functions, or those for reflections.
    enum class Part { all, bounces };
    // By receiver, from what all nodes of `senders` send, `channels` interleaved values each. Of a part, all others are
    // left as they are.
    void gather(const std::vector<float>& sent, std::size_t channels, std::vector<float>& out,
                Part part = Part::all) const;
    // From `colors`, with gradients: `tilted_channels` of each receiver.
    void gather_tilted(const std::vector<float>& sent, std::vector<float>& out) const;
    // By function, from values by receiver.
    void coefficients(const std::vector<float>& values, std::size_t channels, std::vector<float>& out,
                      Part part = Part::all) const;
    // What the leaves of the senders receive on the mean, by node, from coefficients: others are left as they are.
    void receive(const std::vector<float>& coefficients, std::size_t channels, std::vector<float>& out) const;

    // Of what each surfel sends the shares that leave the scene and that backs absorb, by rays of receivers: two
    // channels.
    std::vector<float> losses() const;

    std::size_t bytes() const;

    // Levels of the basis; behind them stands one of surfels' own rows.
    std::size_t own_level() const { return level_begin.size() - 2; }
    // Rows are in the order of their functions: first those of coarse levels, last those of surfels' own.
    std::size_t first_own_row() const { return rows.size() - (level_begin.back() - level_begin[own_level()]); }
    // The first level that is not for reflections.
    std::size_t bounce_end() const { return std::min(bounce_levels, own_level()); }
};

// Points are placed and rays shot level by level, around where receivers differ by `epsilon` in what lamps at random
// places in the air bring by way of one reflection (TestLights), or in what they see of the sky (VisibilityTest), or
// receive of it (SkyTest). Of patches in nooks, and of surfels whose own rays contradict the basis, each cluster has a
// receiver, too. Where max_memory would be exceeded the next level is left out; where the first one exceeds it, that is
// an ArgumentError.
TransportOperator build_operator(const CompiledScene& compiled, const OperatorOptions& options,
                                 const StageProgress& progress, Figures& timings);

}  // namespace surflux
