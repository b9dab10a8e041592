#include "surflux/meshless/support_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

namespace surflux {

namespace {

constexpr std::uint32_t leaf_bit = 0x80000000u;
constexpr std::uint32_t none = 0xffffffffu;
constexpr std::size_t stack_size = 96;  // 7 of each of at most 11 storeys wait, and 8 of the last
constexpr double infinity = std::numeric_limits<double>::infinity();

// Four columns at once, in the notation of GCC and Clang: loops over eight are unrolled before they are vectorized.
using Four = float __attribute__((vector_size(16)));
using FourMasks = std::int32_t __attribute__((vector_size(16)));

inline Four four(float value) { return Four{value, value, value, value}; }
inline Four load(const float* from) {
    Four out;
    std::memcpy(&out, from, sizeof(out));
    return out;
}
inline Four positive(Four value) { return value > 0.0f ? value : four(0.0f); }

}  // namespace

struct SupportTree::Builder {
    SupportTree& tree;
    const std::vector<Vec3>&positions, &normals;
    const std::vector<double>& radii;
    std::vector<std::uint32_t> order;

    // Returns the child's reference and its box.
    std::pair<std::uint32_t, Box> build(std::size_t begin, std::size_t end) {
        if (end - begin <= width) return leaf(begin, end);
        // Three halvings; all leaves but one are full.
        std::array<std::size_t, width + 1> border{begin};
        std::size_t parts = 1;
        border[1] = end;
        for (int halving = 0; halving < 3; ++halving) {
            std::array<std::size_t, width + 1> finer{begin};
            std::size_t made = 0;
            for (std::size_t k = 0; k < parts; ++k) {
                const std::size_t middle = halve(border[k], border[k + 1]);
                if (middle > border[k] && middle < border[k + 1]) finer[++made] = middle;
                finer[++made] = border[k + 1];
            }
            border = finer;
            parts = made;
        }
        const auto index = static_cast<std::uint32_t>(tree.nodes_.size());
        constexpr float far = std::numeric_limits<float>::infinity();
        Node node;
        for (std::size_t k = 0; k < width; ++k) {
            node.child[k] = none;
            for (int axis = 0; axis < 3; ++axis) node.low[axis][k] = far, node.high[axis][k] = -far;
        }
        tree.nodes_.push_back(node);
        Box all{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
        for (std::size_t k = 0; k < parts; ++k) {
            const auto [child, box] = build(border[k], border[k + 1]);
            node.child[k] = child;
            for (int axis = 0; axis < 3; ++axis) {
                all.low[axis] = std::min(all.low[axis], box.low[axis]);
                all.high[axis] = std::max(all.high[axis], box.high[axis]);
                node.low[axis][k] = std::nextafter(static_cast<float>(box.low[axis] - tree.slack_), -far);
                node.high[axis][k] = std::nextafter(static_cast<float>(box.high[axis] + tree.slack_), far);
            }
        }
        tree.nodes_[index] = node;
        return {index, all};
    }

    // Sorts so that both halves lie apart along the longer side, and returns the border: whole leaves to the left.
    std::size_t halve(std::size_t begin, std::size_t end) {
        const std::size_t leaves = (end - begin + width - 1) / width;
        if (leaves < 2) return begin;
        const std::size_t middle = begin + (leaves + 1) / 2 * width;
        Box box{positions[order[begin]], positions[order[begin]]};
        for (std::size_t k = begin; k < end; ++k)
            for (int axis = 0; axis < 3; ++axis) {
                box.low[axis] = std::min(box.low[axis], positions[order[k]][axis]);
                box.high[axis] = std::max(box.high[axis], positions[order[k]][axis]);
            }
        const Vec3 side = box.high - box.low;
        const int axis = side.x >= side.y && side.x >= side.z ? 0 : side.y >= side.z ? 1 : 2;
        const auto at = [&](std::size_t k) { return order.begin() + static_cast<std::ptrdiff_t>(k); };
        std::nth_element(at(begin), at(middle), at(end), [&](std::uint32_t a, std::uint32_t b) {
            const double xa = positions[a][axis], xb = positions[b][axis];
            return xa < xb || (xa == xb && a < b);
        });
        return middle;
    }

    std::pair<std::uint32_t, Box> leaf(std::size_t begin, std::size_t end) {
        Leaf out{};
        out.count = static_cast<std::uint32_t>(end - begin);
        Box places{positions[order[begin]], positions[order[begin]]}, box{places};
        for (std::size_t k = begin; k < end; ++k) {
            const std::uint32_t j = order[k];
            for (int axis = 0; axis < 3; ++axis) {
                const double x = positions[j][axis];
                places.low[axis] = std::min(places.low[axis], x);
                places.high[axis] = std::max(places.high[axis], x);
                box.low[axis] = std::min(box.low[axis], x - radii[j]);
                box.high[axis] = std::max(box.high[axis], x + radii[j]);
            }
        }
        out.origin = places.low + 0.5 * (places.high - places.low);
        for (std::size_t k = 0; k < end - begin; ++k) {
            const std::uint32_t j = order[begin + k];
            out.function[k] = j;
            for (int axis = 0; axis < 3; ++axis) {
                out.x[axis][k] = static_cast<float>((positions[j][axis] - out.origin[axis]) / tree.unit_);
                out.n[axis][k] = static_cast<float>(normals[j][axis]);
            }
            if (!(radii[j] > 0.0)) continue;
            constexpr double largest = std::numeric_limits<float>::max();
            const double inverse = tree.unit_ / radii[j];
            out.inverse_square[k] = static_cast<float>(std::min(inverse * inverse, largest));
            out.height[k] = 1.0f;
        }
        tree.leaves_.push_back(out);
        return {static_cast<std::uint32_t>(tree.leaves_.size() - 1) | leaf_bit,
                {(box.low - tree.center_) / tree.unit_, (box.high - tree.center_) / tree.unit_}};
    }
};

SupportTree::SupportTree(const std::vector<Vec3>& positions, const std::vector<Vec3>& normals,
                         const std::vector<double>& radii, Span<std::uint32_t> members) {
    Box box{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
    for (const std::uint32_t j : members)
        for (int axis = 0; axis < 3; ++axis) {
            box.low[axis] = std::min(box.low[axis], positions[j][axis] - radii[j]);
            box.high[axis] = std::max(box.high[axis], positions[j][axis] + radii[j]);
        }
    const Vec3 half = 0.5 * (box.high - box.low);
    center_ = box.low + half;
    const double reach = std::max({half.x, half.y, half.z});
    if (reach > 0.0 && reach < infinity) unit_ = std::ldexp(1.0, std::ilogb(reach));
    slack_ = reach / unit_ * 0x1p-23;
    leaves_.reserve((members.size() + width - 1) / width);
    Builder builder{*this, positions, normals, radii, {members.begin(), members.end()}};
    root_ = builder.build(0, members.size()).first;
}

double SupportTree::weights(const Vec3& point, const Vec3& normal, std::vector<BasisWeight>& out) const {
    const Vec3 local = (point - center_) / unit_;
    const Four px = four(static_cast<float>(local.x)), nx = four(static_cast<float>(normal.x));
    const Four py = four(static_cast<float>(local.y)), ny = four(static_cast<float>(normal.y));
    const Four pz = four(static_cast<float>(local.z)), nz = four(static_cast<float>(normal.z));
    std::uint32_t stack[stack_size];
    stack[0] = root_;
    std::size_t waiting = 1, found = 0;
    double sum = 0.0;
    while (waiting > 0) {
        const std::uint32_t next = stack[--waiting];
        if (!(next & leaf_bit)) {
            const Node& node = nodes_[next];
            for (std::size_t k = 0; k < width; k += 4) {
                const FourMasks inside = (load(node.low[0] + k) <= px) & (px <= load(node.high[0] + k)) &
                                         (load(node.low[1] + k) <= py) & (py <= load(node.high[1] + k)) &
                                         (load(node.low[2] + k) <= pz) & (pz <= load(node.high[2] + k));
                for (std::size_t lane = 0; lane < 4; ++lane) {
                    stack[waiting] = node.child[k + lane];
                    waiting -= static_cast<std::size_t>(inside[lane]);  // a mask is -1 or 0
                }
            }
            continue;
        }
        const Leaf& leaf = leaves_[next & ~leaf_bit];
        const Vec3 d = (point - leaf.origin) / unit_;
        const float q[3] = {static_cast<float>(d.x), static_cast<float>(d.y), static_cast<float>(d.z)};
        if (out.size() < found + width) out.resize(found + 2 * width);
        for (std::size_t k = 0; k < width; k += 4) {
            const Four x = four(q[0]) - load(leaf.x[0] + k), y = four(q[1]) - load(leaf.x[1] + k);
            const Four z = four(q[2]) - load(leaf.x[2] + k);
            const Four cosine =
                positive(nx * load(leaf.n[0] + k) + ny * load(leaf.n[1] + k) + nz * load(leaf.n[2] + k));
            const Four facing = (cosine * cosine) * (cosine * cosine);
            const Four square = (x * x + y * y + z * z) * load(leaf.inverse_square + k);
            Four t;
            for (int lane = 0; lane < 4; ++lane) t[lane] = std::sqrt(square[lane]);
            // 2 t^3 - 3 t^2 + 1, without the loss of digits near t = 1.
            t = t < 1.0f ? t : four(1.0f);
            const Four rest = 1.0f - t;
            const Four weight = load(leaf.height + k) * (rest * rest) * (1.0f + 2.0f * t) * facing;
            for (std::size_t lane = 0; lane < 4; ++lane) {
                out[found] = {leaf.function[k + lane], weight[lane]};
                sum += out[found].weight;
                found += weight[lane] > 0.0f;
            }
        }
    }
    out.resize(found);
    return sum;
}

std::uint32_t SupportTree::nearest(const Vec3& point, const Vec3& normal) const {
    struct Waiting {
        double squared;
        std::uint32_t child;
    };
    const Vec3 local = (point - center_) / unit_;
    double least[2] = {infinity, infinity};  // of those that face a compatible way; of all
    std::uint32_t best[2] = {none, none};
    for (const int any : {0, 1}) {
        Waiting stack[stack_size];
        stack[0] = {0.0, root_};
        std::size_t waiting = 1;
        while (waiting > 0) {
            const Waiting next = stack[--waiting];
            if (next.squared > least[any]) continue;
            if (next.child & leaf_bit) {
                const Leaf& leaf = leaves_[next.child & ~leaf_bit];
                const Vec3 d = (point - leaf.origin) / unit_;
                for (std::size_t k = 0; k < leaf.count; ++k) {
                    const Vec3 n{leaf.n[0][k], leaf.n[1][k], leaf.n[2][k]};
                    if (!any && !(dot(n, normal) > 0.0)) continue;
                    const double squared = length_squared(d - Vec3{leaf.x[0][k], leaf.x[1][k], leaf.x[2][k]});
                    if (squared > least[any] || (squared == least[any] && leaf.function[k] > best[any])) continue;
                    least[any] = squared;
                    best[any] = leaf.function[k];
                }
                continue;
            }
            const Node& node = nodes_[next.child];
            const std::size_t first = waiting;
            for (std::size_t k = 0; k < width; ++k) {
                double squared = 0.0;
                for (int axis = 0; axis < 3; ++axis) {
                    const double outside =
                        std::max({node.low[axis][k] - local[axis], local[axis] - node.high[axis][k], 0.0});
                    squared += outside * outside;
                }
                if (squared <= least[any] && squared < infinity) stack[waiting++] = {squared, node.child[k]};
            }
            std::sort(stack + first, stack + waiting,
                      [](const Waiting& a, const Waiting& b) { return a.squared > b.squared; });
        }
        if (best[any] != none) return best[any];
    }
    return none;
}

}  // namespace surflux
