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

using Tree = flann::KDTreeSingleIndex<flann::L2_3D<float>>;

// Keeps the k nearest in a sorted array: k is small.
class NearestSet final : public flann::ResultSet<float> {
public:
    NearestSet(std::size_t k, std::vector<Neighbor>& out) : k_(k), out_(out) { out_.clear(); }
    bool full() const override { return out_.size() == k_; }
    float worstDist() const override {
        return full() ? static_cast<float>(out_.back().distance) : std::numeric_limits<float>::max();
    }
    void addPoint(float squared, std::size_t index) override {
        const Neighbor found{static_cast<std::uint32_t>(index), squared};
        const auto before = [](const Neighbor& a, const Neighbor& b) {
            return a.distance < b.distance || (a.distance == b.distance && a.index < b.index);
        };
        if (full()) {
            if (!before(found, out_.back())) return;
            out_.pop_back();
        }
        out_.insert(std::upper_bound(out_.begin(), out_.end(), found, before), found);
    }

private:
    std::size_t k_;
    std::vector<Neighbor>& out_;
};

class WithinSet final : public flann::ResultSet<float> {
public:
    WithinSet(double radius, std::vector<Neighbor>& out)
        // worstDist is compared strictly: the next float up lets a point at exactly `radius` in.
        : squared_(std::nextafter(static_cast<float>(radius * radius), std::numeric_limits<float>::infinity())),
          out_(out) {}
    bool full() const override { return true; }
    float worstDist() const override { return squared_; }
    void addPoint(float squared, std::size_t index) override {
        if (squared < squared_) out_.push_back({static_cast<std::uint32_t>(index), std::sqrt(double{squared})});
    }

private:
    float squared_;
    std::vector<Neighbor>& out_;
};

}  // namespace

struct PointIndex::Impl {
    std::vector<float> coordinates;  // recentred
    Vec3 origin;
    std::unique_ptr<Tree> tree;

    void query(const Vec3& p, float (&q)[3]) const {
        for (int axis = 0; axis < 3; ++axis) q[axis] = static_cast<float>(p[axis] - origin[axis]);
    }
};

PointIndex::PointIndex(const std::vector<Vec3>& points) : impl_(std::make_unique<Impl>()) {
    require(!points.empty(), "points: there are none to search");
    Vec3 low = points[0], high = points[0];
    for (const Vec3& p : points)
        for (int axis = 0; axis < 3; ++axis) {
            low[axis] = std::min(low[axis], p[axis]);
            high[axis] = std::max(high[axis], p[axis]);
        }
    impl_->origin = 0.5 * (low + high);
    impl_->coordinates.reserve(3 * points.size());
    for (const Vec3& p : points) {
        float q[3];
        impl_->query(p, q);
        impl_->coordinates.insert(impl_->coordinates.end(), q, q + 3);
    }
    const flann::Matrix<float> matrix(impl_->coordinates.data(), points.size(), 3);
    impl_->tree = std::make_unique<Tree>(matrix, flann::KDTreeSingleIndexParams(12));
    impl_->tree->buildIndex();
}

PointIndex::~PointIndex() = default;
PointIndex::PointIndex(PointIndex&&) noexcept = default;
PointIndex& PointIndex::operator=(PointIndex&&) noexcept = default;

void PointIndex::nearest(const Vec3& query, std::size_t k, std::vector<Neighbor>& out) const {
    float q[3];
    impl_->query(query, q);
    NearestSet set(std::min(k, size()), out);
    impl_->tree->findNeighbors(set, q, flann::SearchParams(flann::FLANN_CHECKS_UNLIMITED));
    for (Neighbor& n : out) n.distance = std::sqrt(n.distance);
}

void PointIndex::within(const Vec3& query, double radius, std::vector<Neighbor>& out) const {
    float q[3];
    impl_->query(query, q);
    WithinSet set(radius, out);
    impl_->tree->findNeighbors(set, q, flann::SearchParams(flann::FLANN_CHECKS_UNLIMITED));
}

std::size_t PointIndex::size() const { return impl_->coordinates.size() / 3; }

std::string flann_version() { return FLANN_VERSION_; }

}  // namespace surflux
