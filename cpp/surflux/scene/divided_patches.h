#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/core/vec.h"

namespace surflux {

// Flat convex polygons, counter-clockwise seen from their fronts: the corners of polygon p are [begin[p], begin[p + 1])
// of `corners`.
struct FlatPolygons {
    std::vector<Vec3> corners;
    std::vector<std::size_t> begin{0};

    std::size_t size() const { return begin.size() - 1; }
    const Vec3* of(std::size_t p) const { return corners.data() + begin[p]; }
    std::size_t count(std::size_t p) const { return begin[p + 1] - begin[p]; }
};

struct DivisionOptions {
    // Of a patch's area: what is smaller is not cut off. A patch's value is off by no more than this share of the light
    // on the other side of a wall.
    double least_share = 1e-3;
    // Of one patch, the largest ones first: a statue of a hundred thousand faces on one large patch, or a soup of faces
    // through it, must not make as many patches of it.
    std::size_t most_pieces = 64;
    // Of all patches, those more than there were: a twentieth of what there were, or this where that is less. The
    // largest patches come first, which carry the most light to the other side; of a thicket the leaves stay whole.
    std::size_t most_added = 20000;
};

// D0 discontinuity meshing (Heckbert 1992): parts a patch where walls stand on it. A patch has one value: with both
// sides of a wall in it, light would leak from one to the other. A wall is a polygon that stands on the front of the
// patch or goes through it, 12 degrees or more steep; faces in one plane are one wall. A piece is parted along a wall's
// plane where walls run over half of its width or more, all together: round one that is shorter light finds its way,
// but for those that close a part off with others, as the corner of a house does.
class PatchDivider {
public:
    PatchDivider(const Vec3* corners, std::size_t count, const DivisionOptions& options = {});

    // How high over the patch walls may end that stand on it: nearly all that is on one side of a slit so low is out of
    // the light that comes through it.
    double slit() const { return slit_; }
    const Vec3& normal() const { return frame_.n; }

    void add_wall(const Vec3* corners, std::size_t count);
    bool has_walls() const { return !lines_.empty(); }
    // Convex, each turned as the patch; together they cover it. The patch's own corners keep all their bits.
    std::vector<std::vector<Vec3>> pieces();

private:
    using Polygon = std::vector<Vec3>;
    struct Interval {
        double low, high;
    };
    struct Run : Interval {
        bool front, back;  // has it a front where the line's normal points, and behind that?
    };
    // The trace of a wall's plane in that of the patch, dot(normal, p) = offset, and where along it walls stand.
    struct Line {
        Vec3 normal, along;
        double offset;
        std::vector<Run> covered;
        double length;  // of what is covered

        void join_runs();
        double within(const Interval& part) const;
        double overlap(const Line& other) const;
    };
    struct Piece {
        Polygon corners;
        std::vector<std::uint32_t> lines;  // that may part it
        double area;
        bool is_done;
    };

    void merge_lines();
    double area_of(const Polygon& polygon) const;
    Interval chord(const Polygon& polygon, const Line& line) const;
    bool parts(const Polygon& polygon, double area, const Line& line) const;
    const Line* best_line(Piece& piece) const;
    std::vector<std::uint32_t> parting(const Piece& piece) const;

    DivisionOptions options_;
    const Vec3* given_;
    Polygon corners_;  // from the middle of the patch, as all places here
    Vec3 middle_;
    Frame frame_;
    double area_ = 0.0, diameter_ = 0.0, slit_ = 0.0;
    std::vector<Line> lines_;
};

struct DividedPatches {
    FlatPolygons pieces;
    std::vector<std::uint32_t> patch;  // that each is of, ascending: those that no wall parts have none
};

// The patches that faces of `walls` part.
DividedPatches divide_patches(const FlatPolygons& patches, const FlatPolygons& walls, const Progress& progress = {},
                              const DivisionOptions& options = {});

}  // namespace surflux
