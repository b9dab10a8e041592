#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/neighbors/orientation.h"
#include "surflux/scene/surfels.h"

namespace surflux {

struct SheetOptions {
    std::size_t smallest = 20;  // surfels of a sheet; fewer are noise
    int rays = 8;               // from each side of a surfel that is asked
    std::uint64_t seed = 0;
    std::vector<Vec3> witnesses;  // places in the air, such as of a scanner: what closes around one is a room
    // Normals are estimates whose signs say nothing: contacts are found by rays, and no patch is doubted.
    bool estimated = false;
};

// Which side of a sheet is seen. `body`: it closes around something, and is seen from outside; `room`: it closes around
// what has bodies in it, or a witness, and is seen from inside; `open`: it is seen from both sides, so that rays do not
// tell.
enum class SheetKind : std::uint8_t { body, room, open };

// Surfels that continue each other, whichever way their normals point. In front of it is what most of them face.
struct OrientedSheet {
    std::size_t size = 0;
    SheetKind kind = SheetKind::open;
    bool backwards = false;  // the side that is seen is the one behind; of open sheets never
    double against = 0.0;    // share of its surfels that face the other way than most
    // Share of its links that contradict the sides it has been given: below .001 on surfaces, .009 and more on trees,
    // leaves, and walls that are thinner than points are apart. Above .002 links alone turn nothing but what faces
    // backwards as a whole.
    double tangled = 0.0;
    bool settled = false;  // tangled, but of each of its patches rays say which side is seen (patch_votes.h)
    double flat = 0.0;     // length of its mean normal: 0 of what closes, 1 of a plane
    double margin = 0.0;   // of the light that comes to it, in front less behind: from -1 to 1
    double bodies = 0.0;   // of the rays from it that meet closed sheets from where those are seen, the same
};

struct SheetSides {
    static constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
    std::vector<std::uint32_t> sheet;  // per surfel: index of its sheet, or none of one that is too small
    std::vector<bool> against;         // per surfel: faces the other way than most of its sheet
    std::vector<bool> two_sided;       // shares its place with one that faces elsewhere: both are right
    std::vector<bool> unsure;          // where normals change sides, as nothing tells which are right
    NeighborGraph graph;               // of surfels that may continue each other
    std::vector<OrientedSheet> sheets;

    // Does a surfel face the side of its sheet from which it is not seen? Pairs of two_sided never do.
    bool turned(std::size_t surfel) const;
};

// Sheets by their links (neighbors/orientation.h), and which side of each is seen, by rays from both sides of some of
// its surfels (Takayama, Jacobson, Kavan and Sorkine-Hornung 2014): those from outside leave the scene, or meet other
// sheets, those from inside meet the sheet itself.
SheetSides sheet_sides(const Surfels& surfels, const SheetOptions& options, const Progress& progress = {});

// Those of some surfels that are connected and alike among themselves, in patches.
std::vector<std::vector<std::uint32_t>> patches_of(const Surfels& surfels, const NeighborGraph& graph,
                                                   const std::vector<bool>& some);

// How well neighbours in a sheet continue each other, at least (agreement).
inline constexpr double continuation = 0.5;

inline constexpr double most_tangled = 0.002;  // see OrientedSheet

// When a sheet, or a piece of one, closes around something.
namespace closing {
inline constexpr double one_sided = 0.6;  // part of the light that reaches it from one side alone, at least
inline constexpr double most_flat = 0.5;  // as of half a sphere: what is flatter closes around nothing
inline constexpr double dark = 0.02;      // of the rays: of what is itself inside of another, fewer leave the scene
}  // namespace closing

}  // namespace surflux
