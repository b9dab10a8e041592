#include "surflux/lights/sky_cells.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "surflux/core/sampling.h"
#include "surflux/lights/environment.h"

namespace surflux {

namespace {

// Sines of half the width of cells: of those in the open, of those that a horizon crosses, and of narrow spots.
constexpr double open_width = 0.25, least_width = 0.06, narrow_width = 0.03;
constexpr double open_share = 1.0 / 2048, least_share = 1e-5;  // of the power of the tree: cells that may be wider
constexpr double bright_share = 1.0 / 16;                      // of spots, of what is left with them
constexpr double brightness_of_spot = 4.0;                     // beside the mean radiance of what is left

double weight(const Rgb& c) { return luminance({std::abs(c.x), std::abs(c.y), std::abs(c.z)}); }

// Integral of sqrt(1 - z^2).
double integral_of_radius(double z) { return 0.5 * (z * std::sqrt(std::max(0.0, 1.0 - z * z)) + std::asin(z)); }

// Integral of the direction over a piece of sphere between two heights and two azimuths.
Vec3 integral_of_direction(double high, double low, double from, double to) {
    const double radius = integral_of_radius(high) - integral_of_radius(low);
    return {radius * (std::sin(to) - std::sin(from)), radius * (std::cos(from) - std::cos(to)),
            0.5 * (high * high - low * low) * (to - from)};
}

Vec3 direction_at(double z, double azimuth) {
    const double r = std::sqrt(std::max(0.0, 1.0 - z * z));
    return {r * std::cos(azimuth), r * std::sin(azimuth), z};
}

}  // namespace

struct SkyCells::Builder {
    struct Pixels {
        std::size_t width, height;
        std::vector<Rgb> radiance;
    };
    explicit Builder(const Pixels& of) : width(of.width), height(of.height), pixels(of.radiance) {
        for (std::size_t row = 0; row <= height; ++row)
            heights.push_back(std::cos(pi * static_cast<double>(row) / static_cast<double>(height)));
        for (std::size_t column = 0; column <= width; ++column)
            azimuths.push_back(2.0 * pi * static_cast<double>(column) / static_cast<double>(width));
        for (std::size_t row = 0; row < height; ++row) {
            radii.push_back(integral_of_radius(heights[row]) - integral_of_radius(heights[row + 1]));
            levels.push_back(0.5 * (heights[row] * heights[row] - heights[row + 1] * heights[row + 1]));
        }
        for (std::size_t column = 0; column < width; ++column) {
            cosines.push_back(std::sin(azimuths[column + 1]) - std::sin(azimuths[column]));
            sines.push_back(std::cos(azimuths[column]) - std::cos(azimuths[column + 1]));
        }
    }

    double step() const { return azimuths[1]; }
    double solid_angle(std::size_t row) const { return (heights[row] - heights[row + 1]) * step(); }
    Block block(std::uint32_t top, std::uint32_t bottom, std::uint32_t left, std::uint32_t right) const {
        return {{top, bottom, left, right}, heights[top], heights[bottom], azimuths[left], azimuths[right]};
    }
    Block whole() const { return block(0, static_cast<std::uint32_t>(height), 0, static_cast<std::uint32_t>(width)); }

    // In two, across the wider side.
    std::array<Block, 2> halves(const Block& b, bool* across_heights = nullptr) const {
        const std::array<Block, 2> out = halves_of(b);
        if (across_heights) *across_heights = out[1].high < b.high;
        return out;
    }
    std::array<Block, 2> halves_of(const Block& b) const {
        const double tall = std::acos(b.low) - std::acos(b.high);
        const double wide =
            std::sqrt(std::max(0.0, 1.0 - 0.25 * (b.high + b.low) * (b.high + b.low))) * (b.to - b.from);
        Block first = b, second = b;
        if (b.is_pixel()) {
            if (tall >= wide)
                first.low = second.high = 0.5 * (b.high + b.low);
            else
                first.to = second.from = 0.5 * (b.from + b.to);
            return {first, second};
        }
        if (b.bottom - b.top > 1 && (tall >= wide || b.right - b.left == 1)) {
            const std::uint32_t middle = (b.top + b.bottom) / 2;
            return {block(b.top, middle, b.left, b.right), block(middle, b.bottom, b.left, b.right)};
        }
        const std::uint32_t middle = (b.left + b.right) / 2;
        return {block(b.top, b.bottom, b.left, middle), block(b.top, b.bottom, middle, b.right)};
    }

    // Its middle, and the sine of the angle to its farthest corner.
    static double reach(const Block& b, Vec3& middle) {
        middle = direction_at(0.5 * (b.high + b.low), 0.5 * (b.from + b.to));
        if (b.to - b.from > 0.5 * pi + 1e-9) return 2.0;
        double least = 1.0;
        for (int i = 0; i <= 4; ++i)
            for (int k = 0; k <= 4; ++k) {
                if (i % 4 != 0 && k % 4 != 0) continue;
                const double z = b.low + 0.25 * i * (b.high - b.low), azimuth = b.from + 0.25 * k * (b.to - b.from);
                least = std::min(least, dot(middle, direction_at(z, azimuth)));
            }
        return least <= 0.0 ? 2.0 : std::sqrt(std::max(0.0, 1.0 - least * least));
    }

    struct Sums {
        Vec3 moment[3];
        Rgb power;
        double weight = 0.0;
        void add(const Rgb& radiance, const Vec3& direction, double solid_angle) {
            for (int c = 0; c < 3; ++c) moment[c] += radiance[c] * direction;
            power += solid_angle * radiance;
            weight += solid_angle * surflux::weight(radiance);
        }
        void operator+=(const Sums& other) {
            for (int c = 0; c < 3; ++c) moment[c] += other.moment[c];
            power += other.power;
            weight += other.weight;
        }
    };
    Sums sum(const Block& b) const {
        Sums out;
        if (b.is_pixel()) {
            out.add(pixels[b.top * width + b.left] / unit, integral_of_direction(b.high, b.low, b.from, b.to),
                    (b.high - b.low) * (b.to - b.from));
            return out;
        }
        for (std::size_t row = b.top; row < b.bottom; ++row)
            for (std::size_t column = b.left; column < b.right; ++column)
                out.add(pixels[row * width + column] / unit,
                        {radii[row] * cosines[column], radii[row] * sines[column], levels[row] * step()},
                        solid_angle(row));
        return out;
    }

    // Appends the block's nodes to the tree, and none where it is black.
    Sums add(const Block& b, const Image& image, double all, Tree& tree) const {
        const double power =
            b.is_pixel() ? weight(pixels[b.top * width + b.left]) * (b.high - b.low) * (b.to - b.from) : image.power(b);
        if (!(power > 1e-15 * all)) return {};
        Vec3 middle;
        const double sine = reach(b, middle);
        const std::size_t at = tree.nodes.size();
        tree.nodes.emplace_back();
        tree.blocks.push_back(b);
        const bool is_leaf = sine <= least_width || (sine <= open_width && power <= least_share * all);
        Sums sums;
        bool across_heights = false;
        if (is_leaf) {
            sums = sum(b);
        } else {
            for (const Block& half : halves(b, &across_heights)) sums += add(half, image, all, tree);
        }
        Node& node = tree.nodes[at];
        const Vec3 axes[3] = {image.u, image.v, image.n};
        const auto to_world = [&](const Vec3& local, float* out) {
            const Vec3 world = local.x * axes[0] + local.y * axes[1] + local.z * axes[2];
            for (int k = 0; k < 3; ++k) out[k] = static_cast<float>(world[k]);
        };
        to_world(middle, node.middle);
        for (int c = 0; c < 3; ++c) {
            to_world(sums.moment[c], node.moment + 3 * c);
            node.power[c] = static_cast<float>(sums.power[c]);
        }
        node.luminance = static_cast<float>(weight(sums.power));
        node.sine = static_cast<float>(sine);
        node.is_leaf = is_leaf;
        node.across_heights = across_heights;
        node.is_cell = is_leaf || sine <= open_width || (sine <= 1.0 && power <= open_share * all);
        node.next = static_cast<std::uint32_t>(tree.nodes.size());
        return sums;
    }

    Image image_of(const Block& b, const Frame& frame) const {
        const std::size_t columns = b.right - b.left, rows = b.bottom - b.top;
        Image out{frame.u, frame.v, frame.n, width, heights, b, {}, nullptr};
        out.up_to.assign((columns + 1) * (rows + 1), 0.0);
        for (std::size_t row = 0; row < rows; ++row) {
            double of_row = 0.0;
            for (std::size_t column = 0; column < columns; ++column) {
                of_row += weight(pixels[(b.top + row) * width + b.left + column]) * solid_angle(b.top + row);
                out.up_to[(row + 1) * (columns + 1) + column + 1] =
                    out.up_to[row * (columns + 1) + column + 1] + of_row;
            }
        }
        return out;
    }

    // Blocks no wider than a spot, or single pixels, that bring more than their share.
    void find_spots(const Block& b, const Image& image, double all, std::vector<Block>& out) const {
        const double power = image.power(b);
        if (!(power > bright_share * all)) return;
        Vec3 middle;
        if (b.is_pixel() || reach(b, middle) <= narrow_width) {
            const double wide = (b.high - b.low) * (b.to - b.from);
            if (power / wide > brightness_of_spot * all / (4.0 * pi)) out.push_back(b);
            return;
        }
        for (const Block& half : halves(b)) find_spots(half, image, all, out);
    }

    // The brightest of a block's pixels, in any channel: nodes are in units of it, so that floats take any radiance.
    double brightest(const Block& b) const {
        double out = 0.0;
        for (std::size_t row = b.top; row < b.bottom; ++row)
            for (std::size_t column = b.left; column < b.right; ++column)
                for (int c = 0; c < 3; ++c) out = std::max(out, std::abs(pixels[row * width + column][c]));
        return out;
    }

    std::size_t width, height;
    double unit = 1.0;
    std::vector<Rgb> pixels;
    std::vector<double> heights, azimuths;              // of borders
    std::vector<double> radii, levels, cosines, sines;  // of rows and columns, for integrals of the direction
};

SkyCells::SkyCells(const std::vector<Light>& lights, Sources sources) {
    for (const Light& light : lights) {
        const auto* environment = std::get_if<Environment>(&light);
        if (!environment || (environment->pixels.empty() && sources == Sources::images)) continue;
        const Builder::Pixels pixels =
            environment->pixels.empty() ? Builder::Pixels{1, 1, {environment->radiance}}
                                        : Builder::Pixels{environment->width, environment->height, environment->pixels};
        const Rgb* radiance = environment->pixels.empty() ? &environment->radiance : environment->pixels.data();
        Builder builder(pixels);
        const Frame frame = EnvironmentMap(*environment).image_frame();
        const auto add_tree = [&](const Block& block) {
            Image image = builder.image_of(block, frame);
            image.pixels = radiance;
            Tree tree;
            tree.image = static_cast<std::uint32_t>(images_.size());
            builder.unit = tree.unit = builder.brightest(block);
            if (!(tree.unit > 1e-300)) return;  // whose reciprocal is finite
            builder.add(block, image, image.power(block), tree);
            if (tree.nodes.empty()) return;
            tree.is_narrow = tree.nodes[0].sine <= static_cast<float>(narrow_width);
            trees_.push_back(std::move(tree));
            images_.push_back(std::move(image));
        };
        for (bool any = true; any;) {
            const Image image = builder.image_of(builder.whole(), frame);
            std::vector<Block> spots;
            builder.find_spots(builder.whole(), image, image.power(builder.whole()), spots);
            any = !spots.empty();
            for (const Block& spot : spots) {
                add_tree(spot);
                for (std::size_t row = spot.top; row < spot.bottom; ++row)
                    for (std::size_t column = spot.left; column < spot.right; ++column)
                        builder.pixels[row * builder.width + column] = {};
            }
        }
        const std::size_t known = trees_.size();
        add_tree(builder.whole());
        if (environment->pixels.empty() && trees_.size() > known) trees_.back().even = environment->radiance;
    }
}

// The parts of a tree for one normal.
struct SkyCells::Cut {
    const Node* nodes;
    float n[3];
    std::vector<Part>& out;
    Rgb all;

    float times(const float* v) const { return n[0] * v[0] + n[1] * v[1] + n[2] * v[2]; }

    // Those of a node; what they bring.
    float add(std::uint32_t k) {
        const Node& node = nodes[k];
        const float facing = times(node.middle);
        if (facing <= -node.sine) return 0.0f;
        // Well over the horizon, so that its cosines are alike.
        const bool is_open = facing >= (node.is_leaf ? 1.0f : 1.2f) * node.sine;
        if (node.is_leaf || (is_open && node.is_cell)) return add_cell(node, k, facing, is_open);
        const std::size_t at = out.size();
        const std::uint32_t second = nodes[k + 1].next;
        out.emplace_back();
        out[at].node = k;
        const float first = add(k + 1);
        if (first == 0.0f) {  // the other child stands for the node
            out.pop_back();
            return second == node.next ? 0.0f : add(second);
        }
        const auto behind = static_cast<std::uint32_t>(out.size());
        const float other = second == node.next ? 0.0f : add(second);
        if (other == 0.0f) {  // the first child stands for it
            out.erase(out.begin() + static_cast<std::ptrdiff_t>(at));
            for (std::size_t i = at; i < out.size(); ++i)
                if (out[i].second != 0) --out[i].second;
            return first;
        }
        out[at].second = behind;
        out[at].weight = first + other;
        out[at].of_first = first / (first + other);
        out[at].axis = node.across_heights ? 0 : 1;
        return first + other;
    }

    float add_cell(const Node& node, std::uint32_t k, float facing, bool is_open) {
        Part part;
        part.node = k;
        const float over =
            facing + node.sine;  // where the horizon crosses it: the mean if directions are spread evenly
        const float mean = over * over / (4.0f * node.sine);
        float irradiance[3];
        for (int c = 0; c < 3; ++c) {
            irradiance[c] = is_open ? times(node.moment + 3 * c) : mean * node.power[c];
            all[c] += static_cast<double>(irradiance[c]);
        }
        part.weight =
            0.2126f * std::abs(irradiance[0]) + 0.7152f * std::abs(irradiance[1]) + 0.0722f * std::abs(irradiance[2]);
        if (!(part.weight > 0.0f)) return 0.0f;
        part.cosine = part.weight / node.luminance;
        out.push_back(part);
        return part.weight;
    }
};

Rgb SkyCells::find_parts(std::size_t tree, const Vec3& normal, std::vector<Part>& out) const {
    out.clear();
    Cut cut{trees_[tree].nodes.data(),
            {static_cast<float>(normal.x), static_cast<float>(normal.y), static_cast<float>(normal.z)},
            out,
            {}};
    cut.add(0);
    return trees_[tree].even == Rgb{} ? trees_[tree].unit * cut.all : pi * trees_[tree].even;
}

}  // namespace surflux
