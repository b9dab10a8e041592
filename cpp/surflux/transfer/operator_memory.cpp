#include "surflux/transfer/operator_memory.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numeric>
#include <string>
#include <utility>

#include <unistd.h>

#include "surflux/core/available_memory.h"
#include "surflux/core/error.h"
#include "surflux/transfer/sender_groups.h"

namespace surflux {

namespace {

// Measured: its area, place and group; and weights in the basis, at surfels, and there again while they are copied.
constexpr double of_surfel = 80.0, of_weight = 68.0;

}  // namespace

OperatorMemory::OperatorMemory(std::size_t surfels, std::size_t weights, std::size_t test_lights, std::size_t nodes,
                               const ShotRows& so_far, const std::vector<int>& rays)
    : surfels_(static_cast<double>(surfels)),
      weights_(static_cast<double>(weights)),
      test_lights_(static_cast<double>(test_lights)),
      nodes_(static_cast<double>(nodes)),
      links_per_ray_(so_far.rays > 0 ? static_cast<double>(so_far.links.size()) / static_cast<double>(so_far.rays)
                                     : 1.0),
      receivers_(static_cast<double>(so_far.rows.size() + rays.size())),
      links_(static_cast<double>(so_far.links.size()) +
             links_per_ray_ * std::accumulate(rays.begin(), rays.end(), 0.0)) {}

double OperatorMemory::bytes() const {
    const double of_lights = sizeof(float) * test_lights_;  // what a place receives of each
    // Links are copied where their array grows; receivers have values and coefficients.
    return surfels_ * (of_surfel + of_lights) + weights_ * of_weight +
           receivers_ * (sizeof(ShotRows::Row) + 2.0 * (sizeof(Vec3) + of_lights)) +
           2.0 * sizeof(ShotRows::Link) * links_ + nodes_ * (sizeof(SenderGroups::Node) + of_lights);
}

bool OperatorMemory::fits(double max_memory) const {
    constexpr double most = std::numeric_limits<std::uint32_t>::max();
    return bytes() <= max_memory && links_ < most && weights_ < most;
}

void OperatorMemory::require_room(double max_memory) const {
    require(fits(max_memory), "max_memory: the first level, of ", receivers_, " places, takes ",
            std::ceil(bytes() / 1e6), " MB, and there are ", std::floor(max_memory / 1e6),
            " MB for it; a larger radius or fewer rays take less");
}

std::size_t OperatorMemory::room_for(double max_memory, int rays) const {
    OperatorMemory more = *this;
    more.receivers_ += 1.0;
    more.links_ += links_per_ray_ * rays;
    const double room = std::max(0.0, max_memory - bytes()) / (more.bytes() - bytes());
    const double most = std::numeric_limits<std::uint32_t>::max() - links_;
    return static_cast<std::size_t>(std::min(room, most / std::max(1.0, links_per_ray_ * rays)));
}

double available_to_all(const Team& team) {
    const double own = available_memory();
    if (!team.shares()) return own;
    char host[256] = {};
    gethostname(host, sizeof host - 1);
    const auto mine = [&] {
        Packed bytes;
        bytes.add(std::hash<std::string>()(host));
        bytes.add(own);
        return bytes.take();
    };
    std::map<std::size_t, double> processes;
    std::vector<std::pair<std::size_t, double>> all;
    for (const std::string& bytes : team.exchange("memory", mine)) {
        Unpacking from(bytes);
        const auto where = from.take<std::size_t>();
        all.push_back({where, from.take<double>()});
        processes[where] += 1.0;
    }
    double least = own;
    for (const auto& [where, bytes] : all) least = std::min(least, bytes / processes[where]);
    return least;
}

}  // namespace surflux
