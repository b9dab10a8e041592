#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "surflux/core/error.h"
#include "surflux/core/packing.h"
#include "surflux/core/parallel.h"
#include "surflux/core/progress.h"

namespace surflux {

// Processes that run the same program on the same data (SPMD), each of which computes some blocks of the expensive
// loops: shared_blocks(). All else they compute alike, since results depend on no number of threads. By default a
// process is alone.
struct Team {
    std::size_t rank = 0, size = 1;
    // What all processes give, in order of rank. It blocks until all have given theirs, which `mine` makes: not called
    // where the results are known, as after a restart. There may be another number of them then than `size`. Throws
    // where a process has failed. `pass`: a name for messages. Empty: nothing leaves this process.
    using Mine = std::function<std::string()>;
    std::function<std::vector<std::string>(const std::string& pass, const Mine& mine)> exchange;

    // Whether what is made is exchanged or recorded.
    bool shares() const { return static_cast<bool>(exchange); }
};

// The blocks of at most `grain` of [0, count) that fall to this process: they go around, so that all have about as much
// to do. Calls visit(begin, end) for each, ascending.
template <class Visit>
void for_own_blocks(const Team& team, std::size_t count, std::size_t grain, const Visit& visit) {
    for (std::size_t begin = team.rank * grain; begin < count; begin += team.size * grain)
        visit(begin, std::min(count, begin + grain));
}

// Makes what falls to this process by make(), and exchanges it: pack(begin, end, Packed&) of each own block, ascending,
// and unpack(begin, end, Unpacking&) of all blocks, by the process that made them. `digest`: of what the pass goes by,
// which must be the same for all. Of a team that shares.
template <class Make, class Pack, class Unpack>
void exchange_blocks(const Team& team, const char* pass, std::uint64_t digest, std::size_t count, std::size_t grain,
                     const Make& make, const Pack& pack, const Unpack& unpack) {
    if (count == 0) return;
    const std::vector<std::string> all = team.exchange(pass, [&] {
        make();
        Packed bytes;
        bytes.add(digest);
        bytes.add(static_cast<std::uint64_t>(count));
        for_own_blocks(team, count, grain, [&](std::size_t begin, std::size_t end) { pack(begin, end, bytes); });
        return bytes.take();
    });
    for (std::size_t rank = 0; rank < all.size(); ++rank) {
        Unpacking bytes(all[rank]);
        const auto its_digest = bytes.take<std::uint64_t>(), its_count = bytes.take<std::uint64_t>();
        if (its_digest != digest || its_count != count)
            throw DeviceError(message(pass, ": process ", rank,
                                      " has come to other results; all must have the same scene, options, surflux and "
                                      "kind of processor"));
        const auto unpack_one = [&](std::size_t begin, std::size_t end) { unpack(begin, end, bytes); };
        for_own_blocks({rank, all.size(), {}}, count, grain, unpack_one);
        bytes.require_end();
    }
}

// parallel_blocks() of which each block is computed by one process, by body(begin, end), and known to all afterwards.
// `digest`: asked for by a team that shares alone.
template <class MakeDigest, class Body, class Pack, class Unpack>
void shared_blocks(const Team& team, const char* pass, const MakeDigest& digest, std::size_t count, std::size_t grain,
                   const Body& body, const Pack& pack, const Unpack& unpack, const Progress& progress) {
    if (!team.shares()) return parallel_blocks(count, grain, body, progress);
    const auto make = [&] {
        std::vector<std::pair<std::size_t, std::size_t>> own;
        for_own_blocks(team, count, grain, [&](std::size_t begin, std::size_t end) { own.push_back({begin, end}); });
        parallel_for(own.size(), 1, [&](std::size_t k) { body(own[k].first, own[k].second); }, progress);
    };
    exchange_blocks(team, pass, digest(), count, grain, make, pack, unpack);
}

// What is found for each place, whatever others there are: each process finds it for some, by find(those), and all know
// it afterwards. pack(first, count, Packed&): of what was found for those, `count` from `first` on; unpack(begin, end,
// Unpacking&): of the places. `seed`: that they go by. Of a team that shares.
template <class Place, class Find, class Pack, class Unpack>
void exchange_places(const Team& team, const char* pass, std::uint64_t seed, const std::vector<Place>& places,
                     const Find& find, const Pack& pack, const Unpack& unpack) {
    constexpr std::size_t grain = 16;
    const auto make = [&] {
        std::vector<Place> mine;
        for_own_blocks(team, places.size(), grain, [&](std::size_t begin, std::size_t end) {
            mine.insert(mine.end(), places.begin() + static_cast<std::ptrdiff_t>(begin),
                        places.begin() + static_cast<std::ptrdiff_t>(end));
        });
        find(mine);
    };
    std::size_t packed = 0;
    const auto pack_next = [&](std::size_t begin, std::size_t end, Packed& to) {
        pack(packed, end - begin, to);
        packed += end - begin;
    };
    exchange_blocks(team, pass, digest_of_places(seed, places).value(), places.size(), grain, make, pack_next, unpack);
}

// values(places), one of each, by a team.
template <class T, class Place, class Values>
std::vector<T> shared_values(const Team& team, const char* pass, std::uint64_t seed, const std::vector<Place>& places,
                             const Values& values) {
    if (!team.shares()) return values(places);
    std::vector<T> own, all(places.size());
    exchange_places(
        team, pass, seed, places, [&](const std::vector<Place>& mine) { own = values(mine); },
        [&](std::size_t first, std::size_t count, Packed& to) { to.add(own.data() + first, count); },
        [&](std::size_t begin, std::size_t end, Unpacking& from) { from.take(all.data() + begin, end - begin); });
    return all;
}

}  // namespace surflux
