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

namespace surflux {

namespace {

using Tree = flann::KDTreeSingleIndex<flann::L2_3D<double>>;

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
        const Neighbor found{static_cast<std::uint32_t>(index), squared};
        const auto before = [](const Neighbor& a, const Neighbor& b) {
            return a.distance < b.distance || (a.distance == b.distance && a.index < b.index);
        };
        if (full() && !before(found, out_.back())) return;
        // Moved up from the back: most that come are far, and a search by halves would guess wrong at each step.
        std::size_t place = full() ? k_ - 1 : count_++;
        for (; place > 0 && before(found, out_[place - 1]); --place) out_[place] = out_[place - 1];
        out_[place] = found;
        if (full()) worst_ = out_.back().distance;
    }
    // Actual distances, of as many as there are.
    void finish() {
        out_.resize(count_);
        for (Neighbor& n : out_) n.distance = std::sqrt(n.distance);
    }

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
        if (squared < bound_) out_.push_back({static_cast<std::uint32_t>(index), std::sqrt(squared)});
    }

private:
    double bound_;
    std::vector<Neighbor>& out_;
};

}  // namespace

struct PointIndex::Impl {
    std::vector<double> coordinates;  // recentred
    Vec3 origin;
    std::unique_ptr<Tree> tree;

    void query(const Vec3& p, double (&q)[3]) const {
        for (int axis = 0; axis < 3; ++axis) q[axis] = p[axis] - origin[axis];
    }
};

PointIndex::PointIndex(const std::vector<Vec3>& points) : impl_(std::make_unique<Impl>()) {
    require(!points.empty(), "points: there are none to search");
    // The median, not the centre of the bounding box: one outlier must not cost the other points their last digits.
    std::vector<double> values(points.size());
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(points.size() / 2);
    for (int axis = 0; axis < 3; ++axis) {
        std::transform(points.begin(), points.end(), values.begin(), [axis](const Vec3& p) { return p[axis]; });
        std::nth_element(values.begin(), middle, values.end());
        impl_->origin[axis] = *middle;
    }
    impl_->coordinates.reserve(3 * points.size());
    for (const Vec3& p : points) {
        double q[3];
        impl_->query(p, q);
        impl_->coordinates.insert(impl_->coordinates.end(), q, q + 3);
    }
    const flann::Matrix<double> matrix(impl_->coordinates.data(), points.size(), 3);
    impl_->tree = std::make_unique<Tree>(matrix, flann::KDTreeSingleIndexParams(12));
    impl_->tree->buildIndex();
}

PointIndex::~PointIndex() = default;
PointIndex::PointIndex(PointIndex&&) noexcept = default;
PointIndex& PointIndex::operator=(PointIndex&&) noexcept = default;

void PointIndex::nearest(const Vec3& query, std::size_t k, std::vector<Neighbor>& out, double radius) const {
    double q[3];
    impl_->query(query, q);
    NearestSet set(std::min(k, size()), radius, out);
    impl_->tree->findNeighbors(set, q, flann::SearchParams(flann::FLANN_CHECKS_UNLIMITED));
    set.finish();
}

void PointIndex::within(const Vec3& query, double radius, std::vector<Neighbor>& out) const {
    double q[3];
    impl_->query(query, q);
    WithinSet set(radius, out);
    impl_->tree->findNeighbors(set, q, flann::SearchParams(flann::FLANN_CHECKS_UNLIMITED));
}

std::size_t PointIndex::size() const { return impl_->coordinates.size() / 3; }

std::string flann_version() { return FLANN_VERSION_; }

}  // namespace surflux
