#pragma once

#include <cstddef>
#include <vector>

#include "surflux/core/team.h"

namespace surflux {

// shared_blocks() over the elements of vectors of one length, which body(begin, end) writes.
template <class MakeDigest, class Body, class First, class... Others>
void shared_vectors(const Team& team, const char* pass, const MakeDigest& digest, std::size_t grain, const Body& body,
                    const Progress& progress, std::vector<First>& first, std::vector<Others>&... others) {
    const auto pack = [&](std::size_t begin, std::size_t end, Packed& bytes) {
        bytes.add(first.data() + begin, end - begin);
        (bytes.add(others.data() + begin, end - begin), ...);
    };
    const auto unpack = [&](std::size_t begin, std::size_t end, Unpacking& bytes) {
        bytes.take(first.data() + begin, end - begin);
        (bytes.take(others.data() + begin, end - begin), ...);
    };
    shared_blocks(team, pass, digest, first.size(), grain, body, pack, unpack, progress);
}

}  // namespace surflux
