#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "surflux/core/disjoint_sets.h"
#include "surflux/core/sampling.h"
#include "surflux/solution/reciprocal_scaling.h"

namespace surflux {
namespace {

// Rooms that see nothing of each other: in each, any place sees all others, in proportion to their areas, and so many
// rays tell of it. Rows and senders are the same places.
struct Rooms {
    std::size_t places, rooms;
    double escape;  // share of each hemisphere
    std::vector<double> g;
    std::size_t size() const { return places * rooms; }

    Rooms(std::size_t places_of_each, std::size_t room_count, int rays, std::uint64_t seed, double escaping = 0.0)
        : places(places_of_each), rooms(room_count), escape(escaping), g(size() * size(), 0.0) {
        for (std::size_t k = 0; k < size(); ++k) {
            Random random(seed, k);
            const std::size_t first = k / places * places;
            for (int r = 0; r < rays; ++r) {
                if (random.uniform() < escape) continue;
                g[k * size() + first + random.below(places)] += 1.0 / rays;
            }
        }
    }
    RayExchange exchange(int rays) const {
        RayExchange out;
        out.gather = [this](const std::vector<double>& sent, std::vector<double>& to) {
            to.assign(size(), 0.0);
            for (std::size_t k = 0; k < size(); ++k)
                for (std::size_t j = 0; j < size(); ++j) to[k] += g[k * size() + j] * sent[j];
        };
        out.scatter = [this](const std::vector<double>& weight, std::vector<double>& to) {
            to.assign(size(), 0.0);
            for (std::size_t k = 0; k < size(); ++k)
                for (std::size_t j = 0; j < size(); ++j) to[j] += g[k * size() + j] * weight[k];
        };
        for (std::size_t k = 0; k < size(); ++k) {
            double met = 0.0;
            for (std::size_t j = 0; j < size(); ++j) met += g[k * size() + j];
            out.area.push_back(1.0);
            out.met.push_back(met);
            out.rays.push_back(static_cast<std::uint32_t>(rays));
            out.bias.push_back(0.0);
            const auto variance = static_cast<float>(variance_of_share(met, rays));
            out.sender.push_back(
                {1.0f, 1.0f, 1.0f, static_cast<float>(met), 0.0f, variance, static_cast<std::uint32_t>(k / places)});
        }
        out.place = [this](std::size_t k) {
            const double x = static_cast<double>(k % places) / static_cast<double>(places);
            return RayExchange::Place{{x, static_cast<double>(k / places), 0.0}, {0.0, 0.0, 1.0}};
        };
        return out;
    }
};

TEST(ReciprocalScaling, KeepsRowsAndMendsColumns) {
    const int rays = 64;
    const Rooms rooms(400, 1, rays, 3);
    const RayExchange exchange = rooms.exchange(rays);
    const ReciprocalScaling found = scale_by_reciprocity(exchange);
    EXPECT_GT(found.before, 0.02);  // sqrt(1 / 256) of each group
    EXPECT_LT(found.after, 1e-6);
    EXPECT_GT(found.groups, 40u);  // 400 * 64 rays, 256 to 512 in each
    std::vector<double> filled;
    exchange.gather(found.senders, filled);
    for (std::size_t k = 0; k < rooms.size(); ++k) EXPECT_NEAR(found.rows[k] * filled[k], exchange.met[k], 1e-12);
}

TEST(ReciprocalScaling, FactorsOfOneRoomKnowNothingOfAnother) {
    const int rays = 64;
    const Rooms both(300, 2, rays, 5);
    Rooms one = both;
    one.rooms = 1;
    one.g.clear();
    for (std::size_t k = 0; k < 300; ++k)
        for (std::size_t j = 0; j < 300; ++j) one.g.push_back(both.g[k * both.size() + j]);
    RayExchange brighter = both.exchange(rays);
    for (std::size_t j = 300; j < 600; ++j) brighter.sender[j].carried = brighter.sender[j].radiosity = 1e6f;
    const ReciprocalScaling alone = scale_by_reciprocity(one.exchange(rays)), beside = scale_by_reciprocity(brighter);
    for (std::size_t j = 0; j < 300; ++j) EXPECT_NEAR(alone.senders[j], beside.senders[j], 1e-12) << j;
}

TEST(ReciprocalScaling, EnergyIsThatOfTheSendersInAClosedRoom) {
    // The mean of what arrives is the mean of what is sent, group by group: here for light that falls off along x.
    const int rays = 64;
    const Rooms room(400, 1, rays, 11);
    RayExchange exchange = room.exchange(rays);
    double sent = 0.0, received = 0.0;
    std::vector<double> light(room.size()), arrived;
    for (std::size_t j = 0; j < light.size(); ++j) {
        light[j] = std::exp(-3.0 * exchange.place(j).position.x);
        exchange.sender[j].carried = exchange.sender[j].radiosity = static_cast<float>(light[j]);
        sent += light[j];
    }
    const ReciprocalScaling found = scale_by_reciprocity(exchange);
    for (std::size_t j = 0; j < light.size(); ++j) light[j] *= found.senders[j];
    exchange.gather(light, arrived);
    for (std::size_t k = 0; k < arrived.size(); ++k) received += found.rows[k] * arrived[k];
    EXPECT_NEAR(received / sent, 1.0, 3e-4);
}

TEST(ReciprocalScaling, WhereSendersRaysSayLittleTheReceiversAreBelieved) {
    // 199 of 200 rays escape: of some 13 that are left of each group's 2560, senders and receivers know as much, and
    // the spread of interpolation decides.
    const int rays = 64;
    const Rooms open(400, 1, rays, 13, 0.995);
    RayExchange exchange = open.exchange(rays);
    for (RayExchange::Sender& sender : exchange.sender) sender.bias = 0.01f;
    const ReciprocalScaling found = scale_by_reciprocity(exchange);
    for (const double scale : found.senders) EXPECT_NEAR(scale, 1.0, 0.01);
    for (const double lost : found.lost) EXPECT_NEAR(lost, 1.0, 0.01);
}

TEST(ReciprocalScaling, RowsMeetWhatSendersKnowThatTheySend) {
    // Nine of ten rays escape. Senders know without variance that a tenth more meets fronts than rows found.
    const int rays = 64;
    const Rooms open(400, 1, rays, 17, 0.9);
    RayExchange exchange = open.exchange(rays);
    const float met = 0.11f;
    for (RayExchange::Sender& sender : exchange.sender) sender.met = met, sender.variance = 0.0f;
    const ReciprocalScaling found = scale_by_reciprocity(exchange);
    EXPECT_GT(found.before, 0.05);
    EXPECT_LT(found.after, 1e-6);
    std::vector<double> arrived;
    exchange.gather(found.senders, arrived);
    double received = 0.0;
    for (std::size_t k = 0; k < open.size(); ++k) {
        received += found.rows[k] * arrived[k];
        // With what it loses each row still makes 1.
        EXPECT_NEAR(found.rows[k] * (arrived[k] + 1.0 - exchange.met[k]), 1.0, 1e-12);
    }
    EXPECT_NEAR(received / static_cast<double>(open.size()), static_cast<double>(met), 1e-6);
}

// A room in which one place, that no row has met, sends a thousand times as much as all others.
struct RoomWithUnseen {
    static constexpr std::size_t unseen = 7;
    Rooms rooms;
    RayExchange exchange;

    RoomWithUnseen() : rooms(400, 1, 64, 3) {
        for (std::size_t k = 0; k < rooms.size(); ++k) rooms.g[k * rooms.size() + unseen] = 0.0;
        exchange = rooms.exchange(64);
        Random random(11);
        for (std::size_t j = 0; j < rooms.size(); ++j)
            exchange.sender[j].radiosity = exchange.sender[j].carried =
                j == unseen ? 1.0f : 1e-3f * static_cast<float>(1.0 + random.uniform());
    }
};

TEST(ReciprocalScaling, WhatNoRowMeetsHasTheFactorsOfItsNeighbours) {
    // A roof tile in the sun among shaded ones, and no ray ended on it: final gathering may meet it.
    RoomWithUnseen room;
    room.exchange.sender[RoomWithUnseen::unseen].met = 0.0f;
    const ReciprocalScaling found = scale_by_reciprocity(room.exchange);
    for (std::size_t j = 0; j < room.rooms.size(); ++j) EXPECT_NEAR(found.senders[j], 1.0, 0.35) << j;
}

TEST(ReciprocalScaling, WhatNoFactorMendsStaysOffAndAreasDoNot) {
    // By its own rays what it sends meets fronts.
    const RoomWithUnseen room;
    const ReciprocalScaling found = scale_by_reciprocity(room.exchange);
    EXPECT_GT(found.after, 0.3);
    std::vector<double> least(found.groups, 1e300), most(found.groups, 0.0);
    for (std::size_t j = 0; j < room.rooms.size(); ++j) {
        least[found.group[j]] = std::min(least[found.group[j]], found.senders[j]);
        most[found.group[j]] = std::max(most[found.group[j]], found.senders[j]);
    }
    const double widest = found.largest_factor * found.largest_factor;
    for (std::size_t k = 0; k < found.groups; ++k) {
        EXPECT_LE(most[k], 1.0001 * widest * least[k]);
        EXPECT_LT(most[k], 3.0);
    }
}

TEST(ReciprocalScaling, ConstantsOfItsTuningCount) {
    const RoomWithUnseen room;
    const ReciprocalScaling usual = scale_by_reciprocity(room.exchange);
    ReciprocityTuning tuning;
    tuning.largest_factor = 1.25;
    const ReciprocalScaling narrow = scale_by_reciprocity(room.exchange, {}, tuning);
    const auto largest = [](const ReciprocalScaling& of) {
        return *std::max_element(of.senders.begin(), of.senders.end());
    };
    EXPECT_LT(largest(narrow), largest(usual));
    EXPECT_GT(narrow.after, usual.after);
    tuning = {};
    tuning.rays_of_group = 1e9;
    EXPECT_GT(usual.groups, 1u);
    EXPECT_EQ(scale_by_reciprocity(room.exchange, {}, tuning).groups, 1u);
}

TEST(ReciprocalScaling, AreasBelowZeroMakeNoFactorThatIsNone) {
    // Of functions that finer ones take nearly all from.
    RayExchange exchange = Rooms(1, 3, 64, 1).exchange(64);
    exchange.gather = [&](const std::vector<double>& sent, std::vector<double>& to) { to = sent; };
    exchange.scatter = [&](const std::vector<double>& weight, std::vector<double>& to) { to = weight; };
    exchange.area = {0.4, -0.6, 1.2};
    for (std::size_t k = 0; k < 3; ++k) exchange.sender[k].carried = k == 1 ? 0.0f : 1.0f;
    exchange.sender[1].part = 0;
    exchange.sender[2].part = 1;
    for (const double factor : scale_by_reciprocity(exchange).senders) EXPECT_TRUE(std::isfinite(factor));
}

TEST(DisjointSets, AreNumberedByTheirLeastMembers) {
    DisjointSets sets(7);
    sets.join(5, 1);
    sets.join(6, 5);
    sets.join(4, 2);
    EXPECT_EQ(sets.numbered(5), (std::vector<std::uint32_t>{0, 1, 2, 3, 2}));
    EXPECT_EQ(sets.find(6), 1u);
}

}  // namespace
}  // namespace surflux
