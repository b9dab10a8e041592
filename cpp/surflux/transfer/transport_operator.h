#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/core/vec.h"
#include "surflux/lights/sample_points.h"
#include "surflux/scene/surfels.h"
#include "surflux/solution/solution.h"
#include "surflux/trace/compiled_scene.h"
#include "surflux/transfer/sender_groups.h"
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
};

// The transport operator of a scene, which knows no light (L07 sec. 6.5): from what groups of surfels send to
// irradiance at receivers, the points of a multilevel Shepard basis (L07 4), and from there to groups and surfels.
// Plain data: it refers to nothing. Neither does it know reflectance: senders are given what they send.
//   L07 links basis functions to basis functions. Here rays link receivers to groups of surfels, so that of senders
// nothing is interpolated, whatever their number, and rays that meet far ones count for all of a group.
struct TransportOperator {
    // Of a row: rays of its first and its second half that met a sender, and the mean of their slopes in the tangent
    // plane, in units of 1 / slope_scale.
    struct Link {
        std::uint32_t sender;
        std::uint8_t first, second;
        std::int8_t u, v;
    };
    static constexpr float slope_scale = 15.0f, steepest = 8.0f;
    struct Row {
        std::uint32_t begin = 0, end = 0;  // links
        float per_ray = 0.0f;              // share of the cosine-weighted hemisphere
        float u = 0.0f, v = 0.0f;          // mean slopes of all rays: not quite 0, which is taken off
    };
    // Irradiance and its rotation gradient (Ward and Heckbert 1992): n' . gradient is what a normal n' near the
    // receiver's has more. Together they are vector irradiance, value * normal + gradient, but that light is taken to
    // go on below the horizon of the receiver.
    static constexpr std::size_t tilted_channels = 4;

    std::vector<Vec3> positions, normals;  // of receivers
    std::vector<std::uint32_t> surfels;    // that they lie on
    std::vector<Row> rows;
    std::vector<Link> links;

    // Functions of the basis, coarse levels first: the receiver at the point of each, and its parents, the functions of
    // coarser levels there, that it is the difference from (L07 eq. 10). Behind them those of surfels that the basis is
    // off on: each is 1 on its surfel, where nothing else is.
    std::vector<std::uint32_t> receiver_of, level_begin;
    SparseRows parents;
    SparseRows at_groups;   // the mean of each function over each leaf of the senders
    SparseRows at_surfels;  // over each surfel

    SenderGroups senders;
    SenderSamples samples;
    std::vector<double> areas;  // of each surfel what is not inside geometry

    std::size_t rays = 0;
    std::size_t left_out = 0;  // receivers and surfels that max_memory kept from being refined

    // By receiver, from what all nodes of `senders` send, `channels` interleaved values each.
    void gather(const std::vector<float>& sent, std::size_t channels, std::vector<float>& out) const;
    // The same from three channels with gradients: 3 values, 3 gradients along x, 3 along y, 3 along z.
    void gather_tilted(const std::vector<float>& sent, std::vector<float>& out) const;
    // By function, from values by receiver.
    void coefficients(const std::vector<float>& values, std::size_t channels, std::vector<float>& out) const;
    // What the leaves of the senders receive on the mean, by node, from coefficients.
    void receive(const std::vector<float>& coefficients, std::size_t channels, std::vector<float>& out) const;

    std::size_t bytes() const;
};

// Points are placed and rays shot level by level, around where receivers differ by `epsilon` in what lamps at random
// places in the air bring by way of one reflection (TestLights), or in what they see of the sky (VisibilityTest), or
// receive of it (SkyTest). Surfels whose own rays contradict the basis are receivers, too. Where max_memory would be
// exceeded the next level is left out; where the first one exceeds it, that is an ArgumentError.
TransportOperator build_operator(const CompiledScene& compiled, const OperatorOptions& options,
                                 const StageProgress& progress, Figures& timings);

}  // namespace surflux
