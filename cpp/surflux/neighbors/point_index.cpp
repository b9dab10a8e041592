#include "surflux/neighbors/point_index.h"

#include <algorithm>
#include <cmath>
#include <limits>

// FLANN's headers are not written for our warnings.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wunused-parameter"
#include <flann/flann.hpp>
#pragma GCC diagnostic pop

#include "surflux/core/error.h"
#include "surflux/core/parallel.h"
#include "surflux/neighbors/middle.h"

namespace surflux {

namespace {

using Tree = flann::KDTreeSingleIndex<flann::L2_3D<double>>;

constexpr double almost = 1.0 - 1e-14;  // of a squared distance, as rounding may have it

// worstDist is compared strictly: the next number up lets a point at exactly `radius` in.
double strict_bound(double radius) { return std::nextafter(radius * radius, std::numeric_limits<double>::infinity()); }

// Keeps the k nearest in a sorted array: k is small.
class NearestSet final : public flann::ResultSet<double> {
public:
    NearestSet(std::size_t k, double radius, std::vector<Neighbor>& out)
        : k_(k), worst_(strict_bound(radius)), out_(out) {
        out_.resize(k);
    }
    bool full() const override { return count_ == k_; }
    double worstDist() const override { return worst_; }
    void addPoint(double squared, std::size_t index) override {
        const Neighbor found{numbers[index], squared};
        const auto before = [](const Neighbor& a, const Neighbor& b) {
            return a.distance < b.distance || (a.distance == b.distance && a.index < b.index);
        };
        if (full() && !before(found, out_.back())) return;
        // Moved up from the back: most that come are far, and a search by halves would guess wrong at each step.
        std::size_t place = full() ? k_ - 1 : count_++;
        for (; place > 0 && before(found, out_[place - 1]); --place) out_[place] = out_[place - 1];
        out_[place] = found;
        // FLANN asks for less than the worst: of what is as far, the least numbers count, wherever it finds them.
        if (full()) worst_ = out_.back().distance / almost + std::numeric_limits<double>::denorm_min();
    }
    // Actual distances, of as many as there are.
    void finish() {
        out_.resize(count_);
        for (Neighbor& n : out_) n.distance = std::sqrt(n.distance);
    }

    const std::uint32_t* numbers = nullptr;  // of the points of the tree that is searched

private:
    std::size_t k_, count_ = 0;
    double worst_;
    std::vector<Neighbor>& out_;
};

class WithinSet final : public flann::ResultSet<double> {
public:
    WithinSet(double radius, std::vector<Neighbor>& out) : bound_(strict_bound(radius)), out_(out) {}
    bool full() const override { return true; }
    double worstDist() const override { return bound_; }
    void addPoint(double squared, std::size_t index) override {
        if (squared < bound_) out_.push_back({numbers[index], std::sqrt(squared)});
    }

    const std::uint32_t* numbers = nullptr;

private:
    double bound_;
    std::vector<Neighbor>& out_;
};

}  // namespace

struct PointIndex::Impl {
    struct Point {
        double at[3];  // recentred
        std::uint32_t number;
    };
    // Of neighbouring points: two of its kind, one after the other, or a tree of FLANN's.
    struct Node {
        double low[3], high[3];
        std::uint32_t begin, end;  // in `numbers`
        std::uint32_t first_child = 0;
        std::unique_ptr<Tree> tree;

        double squared_distance(const double (&q)[3]) const {
            double sum = 0.0;
            for (int axis = 0; axis < 3; ++axis) {
                const double off = std::max({low[axis] - q[axis], q[axis] - high[axis], 0.0});
                sum += off * off;
            }
            return sum;
        }
    };
    static constexpr std::uint32_t most_points = 1 << 15;  // of one of FLANN's trees
    static constexpr std::uint32_t sampled = 1 << 10;      // of a node's points, for their median

    Vec3 origin;
    std::vector<std::uint32_t> numbers;
    std::vector<Node> nodes;

    void query(const Vec3& p, double (&q)[3]) const {
        for (int axis = 0; axis < 3; ++axis) q[axis] = p[axis] - origin[axis];
    }

    void find_box(Node& node, const std::vector<Point>& points) const {
        for (int axis = 0; axis < 3; ++axis) {
            node.low[axis] = std::numeric_limits<double>::infinity();
            node.high[axis] = -node.low[axis];
            for (std::uint32_t k = node.begin; k < node.end; ++k) {
                node.low[axis] = std::min(node.low[axis], points[k].at[axis]);
                node.high[axis] = std::max(node.high[axis], points[k].at[axis]);
            }
        }
    }

    // Puts points of a node's lower part along the longest side of its box first, and returns where the upper begins:
    // at the median of some, which one pass over all of them is enough for.
    static std::uint32_t bisect(const Node& node, std::vector<Point>& points) {
        int widest = 0;
        for (int axis = 1; axis < 3; ++axis)
            if (node.high[axis] - node.low[axis] > node.high[widest] - node.low[widest]) widest = axis;
        const auto before = [widest](const Point& a, const Point& b) {
            return a.at[widest] < b.at[widest] || (a.at[widest] == b.at[widest] && a.number < b.number);
        };
        const std::uint32_t step = (node.end - node.begin) / sampled;
        std::vector<Point> some;
        for (std::uint32_t k = node.begin; k < node.end; k += step) some.push_back(points[k]);
        const auto median = some.begin() + static_cast<std::ptrdiff_t>(some.size() / 2);
        std::nth_element(some.begin(), median, some.end(), before);
        const auto begin = points.begin();
        const auto middle = std::partition(begin + node.begin, begin + node.end,
                                           [&](const Point& point) { return before(point, *median); });
        return static_cast<std::uint32_t>(middle - begin);
    }

    // Halves, about, until one of FLANN's trees can take them.
    void divide(std::vector<Point>& points, const Progress& progress) {
        nodes.emplace_back();
        nodes[0].begin = 0, nodes[0].end = static_cast<std::uint32_t>(points.size());
        for (std::size_t first = 0, last = 1; first < last; first = last, last = nodes.size()) {
            std::vector<std::uint32_t> middle(last - first, 0);
            const auto divide_one = [&](std::size_t k) {
                Node& node = nodes[first + k];
                find_box(node, points);
                if (node.end - node.begin > most_points) middle[k] = bisect(node, points);
            };
            parallel_for(last - first, 1, divide_one, standing_at(0, points.size(), progress));
            for (std::size_t k = first; k < last; ++k) {
                if (middle[k - first] == 0) continue;
                const std::uint32_t begin = nodes[k].begin, end = nodes[k].end;
                nodes[k].first_child = static_cast<std::uint32_t>(nodes.size());
                nodes.emplace_back(), nodes.emplace_back();
                nodes[nodes.size() - 2].begin = begin, nodes[nodes.size() - 2].end = middle[k - first];
                nodes.back().begin = middle[k - first], nodes.back().end = end;
            }
        }
    }

    template <class Set>
    void search(std::size_t at, const double (&q)[3], Set& set) const {
        const Node& node = nodes[at];
        if (node.first_child == 0) {
            set.numbers = numbers.data() + node.begin;
            node.tree->findNeighbors(set, q, flann::SearchParams(flann::FLANN_CHECKS_UNLIMITED));
            return;
        }
        const double a = nodes[node.first_child].squared_distance(q),
                     b = nodes[node.first_child + 1].squared_distance(q);
        const std::size_t near = node.first_child + (b < a), far = node.first_child + !(b < a);
        // As far as the worst is no reason to leave one out: of equals the least number counts.
        if (std::min(a, b) * almost <= set.worstDist()) search(near, q, set);
        if (std::max(a, b) * almost <= set.worstDist()) search(far, q, set);
    }
};

PointIndex::PointIndex(const std::vector<Vec3>& points, const Progress& progress) : impl_(std::make_unique<Impl>()) {
    require(!points.empty(), "points: there are none to search");
    impl_->origin = middle_of(points, 10000);  // no outlier costs the others their last digits
    std::vector<Impl::Point> recentred(points.size());
    const auto recentre = [&](std::size_t k) {
        impl_->query(points[k], recentred[k].at);
        recentred[k].number = static_cast<std::uint32_t>(k);
    };
    parallel_for(points.size(), 4096, recentre, standing_at(0, points.size(), progress));
    impl_->divide(recentred, progress);
    impl_->numbers.resize(points.size());
    parallel_for(points.size(), 4096, [&](std::size_t k) { impl_->numbers[k] = recentred[k].number; });
    parallel_blocks(
        impl_->nodes.size(), 1,
        [&](std::size_t k, std::size_t) {
            Impl::Node& node = impl_->nodes[k];
            if (node.first_child != 0) return;
            // Points are copied into the tree, in its order.
            node.tree = std::make_unique<Tree>(
                flann::Matrix<double>(recentred[node.begin].at, node.end - node.begin, 3, sizeof(Impl::Point)),
                flann::KDTreeSingleIndexParams(12));
            node.tree->buildIndex();
        },
        progress);
}

PointIndex::~PointIndex() = default;
PointIndex::PointIndex(PointIndex&&) noexcept = default;
PointIndex& PointIndex::operator=(PointIndex&&) noexcept = default;

void PointIndex::nearest(const Vec3& query, std::size_t k, std::vector<Neighbor>& out, double radius) const {
    double q[3];
    impl_->query(query, q);
    NearestSet set(std::min(k, size()), radius, out);
    impl_->search(0, q, set);
    set.finish();
}

void PointIndex::within(const Vec3& query, double radius, std::vector<Neighbor>& out) const {
    double q[3];
    impl_->query(query, q);
    WithinSet set(radius, out);
    impl_->search(0, q, set);
}

std::size_t PointIndex::size() const { return impl_->numbers.size(); }

std::string flann_version() { return FLANN_VERSION_; }

}  // namespace surflux
