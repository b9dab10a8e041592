#include <gtest/gtest.h>

#include <malloc.h>

#include <atomic>

#include "shapes.h"
#include "surflux/core/parallel.h"
#include "surflux/meshless/meshless_solve.h"

namespace surflux {
namespace {

TEST(Scratch, IsLentToOneBlockAtATimeAndEndsWithThePass) {
    static std::atomic<int> alive, most;
    struct Counted {
        Counted() {
            const int now = ++alive;
            for (int before = most; before < now && !most.compare_exchange_weak(before, now);) {
            }
        }
        ~Counted() { --alive; }
        std::atomic<int> users{0};
        int uses = 0;
    };
    alive = most = 0;
    const ThreadLimit limit(4);
    const auto pass = [](std::size_t fails_at) {
        Scratch<Counted> scratch;
        std::atomic<int> shared{0};
        parallel_for(1000, 1, [&](std::size_t k) {
            const Scratch<Counted>::Lent lent(scratch);
            if (++(*lent).users != 1) ++shared;
            ++(*lent).uses;
            --(*lent).users;
            if (k == fails_at) throw Cancelled();
        });
        EXPECT_EQ(shared, 0);
    };
    pass(1000);
    EXPECT_EQ(alive, 0);
    EXPECT_LE(most, 4);
    EXPECT_THROW(pass(500), Cancelled);
    EXPECT_EQ(alive, 0);
}

// Bytes that the program has asked for and not given back; of its own allocations, whatever the allocator keeps.
std::size_t live_bytes() {
    const struct mallinfo2 all = mallinfo2();
    return all.uordblks + all.hblkhd;
}

TEST(PassMemory, OfAMeshlessSolveIsGivenBack) {
    const auto functions = [](int n, double radius) {
        Scene scene;
        append(scene, shapes::cube_inside(n, 0.5, 1.0));
        MeshlessOptions options;
        options.levels = 1;
        options.radius = radius;
        options.rays = 16;
        const MeshlessSolution found = solve_meshless(scene, options, {});
        return found.field->basis.size();
    };
    functions(8, 0.1);  // what libraries and threads keep once and for all
    const std::size_t before = live_bytes();
    const std::size_t count = functions(16, 0.008);
    const std::size_t after = live_bytes();
    // Threads had a table of all functions each, of three doubles and more.
    ASSERT_GT(count, 10000u);
    EXPECT_LT(after, before + count * 3 * sizeof(double)) << count << " functions";
}

}  // namespace
}  // namespace surflux
