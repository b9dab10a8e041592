#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "surflux/core/vec.h"
#include "surflux/scene/lights.h"

namespace surflux {

// A scene's Environments as trees of cells, blocks of pixels or parts of one, that know in closed form
// what they bring to any plane where nothing is in the way. The lights have to outlive it.
class SkyCells {
public:
    enum class Sources { images, all };  // all: Environments of one colour, too
    explicit SkyCells(const std::vector<Light>& lights, Sources sources = Sources::images);
    SkyCells(std::vector<Light>&&, Sources = Sources::images) = delete;

    // Trees: of each image what is left of it by itself, and every narrow bright spot, such as the sun, by itself. A
    // spot has a tree where it brings more than 1/16 of what is left, itself included.
    std::size_t trees() const { return trees_.size(); }
    bool empty() const { return trees_.empty(); }
    // Is it so small that shadow rays to it mostly agree?
    bool is_narrow(std::size_t tree) const { return trees_[tree].is_narrow; }

    // Of a tree, a node whose cells rise over a plane: an inner one, followed by its first child and what is in that,
    // or a cell with what it brings to the plane where nothing is in the way.
    struct Part {
        std::uint32_t node;
        std::uint32_t second = 0;  // part of the second child; 0 of a cell
        float weight = 0.0f;       // luminance of what it brings, in the unit of its tree
        float cosine = 0.0f;       // of a cell: mean over it, by its luminance
        float of_first = 0.0f;     // of an inner node: share of its first child in its weight
        std::uint32_t axis = 0;    // of an inner node: 0 if it is divided across heights, 1 across azimuths
    };
    // Cells are small where the plane's own horizon runs. None if nothing rises over it. What they bring altogether.
    Rgb find_parts(std::size_t tree, const Vec3& normal, std::vector<Part>& out) const;
    // Of what the sky brings to the plane.
    struct Sample {
        Vec3 direction;
        double mean_cosine;  // of its cell
        Rgb color;           // of its pixel, of luminance 1
    };
    struct UnitPoint {
        double u, v;  // in [0, 1)
    };
    // At points of the unit square, which is mapped onto the sky in proportion to what cells bring to the plane, and
    // within a cell by luminance: split by split across heights or azimuths, so that points that are even stay so
    // (hierarchical sample warping: Clarberg and others 2005). Many at once take a fraction of the time of one by one.
    void sample(std::size_t tree, const std::vector<Part>& parts, const std::vector<UnitPoint>& at,
                std::vector<Sample>& out) const;

private:
    struct Node {
        float middle[3];
        float sine;       // of the angle between its middle and its farthest corner; 2 where that is 90 degrees or more
        float moment[9];  // integral of radiance times direction: 3 numbers each of red, green and blue
        float power[3], luminance;              // integral of radiance
        std::uint32_t next;                     // the first node that does not lie in it; the first child comes next
        bool is_cell, is_leaf, across_heights;  // how it is divided
    };
    // [top, bottom) x [left, right).
    struct Pixels {
        std::uint32_t top, bottom, left, right;
        bool is_one() const { return bottom - top == 1 && right - left == 1; }
    };
    // Of part of one pixel, its bounds by height and by azimuth, which grows with columns
    // (EnvironmentMap::image_frame).
    struct Block : Pixels {
        double high, low, from, to;
        bool is_pixel() const { return is_one(); }
    };
    struct Image {
        Vec3 u, v, n;  // its axes
        std::size_t width;
        std::vector<double> heights;  // of the borders of rows
        Block kept;                   // the block that up_to covers
        std::vector<double> up_to;    // luminance times solid angle, summed over the rows above and the columns left
        const Rgb* pixels;            // of the Environment
        double power(const Pixels& b) const {
            const std::size_t row = kept.right - kept.left + 1;
            const double* above = up_to.data() + (b.top - kept.top) * row - kept.left;
            const double* below = above + (b.bottom - b.top) * row;
            return below[b.right] - above[b.right] - below[b.left] + above[b.left];
        }
    };
    struct Tree {
        std::uint32_t image;
        bool is_narrow = false;
        double unit = 1.0;        // radiance that nodes count in
        Rgb even;                 // radiance of a sky of one colour, of which any plane has pi times that; else 0
        std::vector<Node> nodes;  // those without power left out; children behind their parent
        std::vector<Block> blocks;
    };
    struct Builder;
    struct Cut;
    class Warp;

    std::vector<Image> images_;
    std::vector<Tree> trees_;
};

}  // namespace surflux
