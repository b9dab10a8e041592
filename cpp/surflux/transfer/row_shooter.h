#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/core/team.h"
#include "surflux/lights/sample_points.h"
#include "surflux/trace/tracer.h"
#include "surflux/transfer/sender_groups.h"
#include "surflux/transfer/shot_rows.h"

namespace surflux {

// Shoots the rows of a transport operator: what the cosine-distributed rays of a receiver meet, by group of senders.
class RowShooter {
public:
    RowShooter(const SurfelPoints& points, const Tracer& tracer, const SenderGroups& senders, std::uint64_t seed,
               Team team = {})
        : points_(points), tracer_(tracer), senders_(senders), seed_(seed), team_(std::move(team)) {}

    // Appends a row for each place, with as many rays as `counts` says.
    void add(const std::vector<Place>& places, const std::vector<int>& counts, ShotRows& out,
             const Progress& progress) const;

private:
    struct Shot;
    void shoot(const Place& place, int count, Shot& shot) const;

    const SurfelPoints& points_;
    const Tracer& tracer_;
    const SenderGroups& senders_;
    std::uint64_t seed_;
    Team team_;
};

}  // namespace surflux
