#include "surflux/neighbors/disk_index.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace surflux {

DiskIndex::DiskIndex(const std::vector<Vec3>& centers, const std::vector<double>& radii, const Progress& progress)
    : radii_(radii) {
    std::map<int, std::vector<std::uint32_t>> by_octave;
    for (std::size_t i = 0; i < radii.size(); ++i)
        by_octave[std::ilogb(radii[i])].push_back(static_cast<std::uint32_t>(i));
    for (auto& [exponent, members] : by_octave) {
        std::vector<Vec3> points;
        points.reserve(members.size());
        double largest = 0.0;
        for (std::uint32_t i : members) {
            points.push_back(centers[i]);
            largest = std::max(largest, radii[i]);
        }
        octaves_.push_back({largest, std::move(members), PointIndex(points, progress)});
    }
}

void DiskIndex::reaching(const Vec3& query, double radius, std::vector<Neighbor>& out, double scale) const {
    std::size_t kept = out.size();
    for (const Octave& octave : octaves_) {
        octave.tree.within(query, scale * (radius + octave.largest), out);
        for (std::size_t found = kept; found < out.size(); ++found) {
            const Neighbor n{octave.members[out[found].index], out[found].distance};
            if (n.distance < scale * (radius + radii_[n.index])) out[kept++] = n;
        }
        out.resize(kept);
    }
}

void DiskIndex::centered_within(const Vec3& query, double radius, std::vector<Neighbor>& out) const {
    for (const Octave& octave : octaves_) {
        const std::size_t before = out.size();
        octave.tree.within(query, radius, out);
        for (std::size_t found = before; found < out.size(); ++found)
            out[found].index = octave.members[out[found].index];
    }
}

}  // namespace surflux
