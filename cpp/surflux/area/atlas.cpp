#include "surflux/area/atlas.h"

#include <algorithm>
#include <condition_variable>
#include <future>
#include <memory>
#include <mutex>

#include "surflux/area/atlas_passes.h"
#include "surflux/core/parallel.h"
#include "surflux/gl/context.h"

namespace surflux {

namespace {

// Batches on their way from the thread that gathers them to the one that draws them, one at a time.
class Handover {
public:
    // Waits until the one before is drawn. False where nothing is drawn any more.
    bool put(TileBatch& batch) {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return closed_ || !waiting_; });
        if (closed_) return false;
        batch_ = std::move(batch);
        waiting_ = true;
        changed_.notify_all();
        return true;
    }
    // The batch to draw, or null where there is no other.
    const TileBatch* next() {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return closed_ || waiting_; });
        return waiting_ ? &batch_ : nullptr;
    }
    void drawn() {
        const std::lock_guard lock(mutex_);
        waiting_ = false;
        changed_.notify_all();
    }
    void close() {
        const std::lock_guard lock(mutex_);
        closed_ = true;
        changed_.notify_all();
    }

private:
    std::mutex mutex_;
    std::condition_variable changed_;
    TileBatch batch_;
    bool waiting_ = false, closed_ = false;
};

struct Closer {
    Handover& handover;
    ~Closer() { handover.close(); }
};

// The neighbourhoods of the disks from number `begin` on, as many as make a batch.
TileBatch gather(const NeighborhoodFinder& finder, std::size_t begin, const TileLayout& layout,
                 const AreaOptions& options, const PolarGrid& grid) {
    constexpr std::size_t grain = 16, fewest = 64, most = 512;
    const bool curved = options.method == AreaMethod::curved;
    TileBatch batch;
    for (std::size_t quads = 0; quads < most_quads;) {
        const std::size_t place = batch.count();
        const std::size_t left = std::min(layout.count(), finder.size() - begin) - place;
        if (left == 0) break;
        // Where disks have very many neighbours, what waits in memory must stay small.
        const std::size_t room = quads == 0 ? fewest : std::clamp(most_quads / (quads / place + 1), fewest, most);
        const std::size_t count = std::min(left, room);
        std::vector<TileBatch> parts((count + grain - 1) / grain);
        parallel_blocks(count, grain, [&](std::size_t low, std::size_t high) {
            Neighborhood around;
            TileBatch& part = parts[low / grain];
            for (std::size_t k = place + low; k < place + high; ++k) {
                finder.find(begin + k, curved, around);
                if (curved)
                    add_curved_tile(around, grid, layout, k, part);
                else
                    add_flat_tile(around, options.resolution, layout, k, part);
            }
        });
        for (const TileBatch& part : parts) batch.append(part);
        quads = std::max(batch.flat.size(), batch.curved.size());
    }
    return batch;
}

}  // namespace

bool atlas_may_pay(std::size_t disks, const AreaOptions& options, int threads) {
    // Points that a thread weighs in a second, with AVX-512.
    const double rate = options.method == AreaMethod::paper ? 3e8 : 1.1e9;
    const double seconds_each = options.resolution * options.resolution / rate;
    // Neighbourhoods are found on the CPU either way, 1 to 3 microseconds each, and making quads of them adds to that.
    // A first context and its shaders are ready after a tenth of a second or more.
    return seconds_each > 2e-6 && seconds_each * static_cast<double>(disks) > 0.5 * threads;
}

std::vector<double> atlas_areas(const NeighborhoodFinder& finder, const AreaOptions& options,
                                const Progress& progress) {
    if (finder.size() == 0) return {};
    const TileLayout layout(options.method, options.resolution);
    const PolarGrid grid(options.resolution);
    std::vector<double> areas;
    areas.reserve(finder.size());

    Handover handover;
    const auto draw_all = [&](const gl::Context& context) {
        const std::unique_ptr<Atlas> atlas = make_atlas(context.gl, layout, options, grid);
        while (const TileBatch* batch = handover.next()) {
            atlas->draw(*batch, areas);
            handover.drawn();
        }
    };
    std::future<void> drawing = std::async(std::launch::async, [&] {
        const Closer closer{handover};
        gl::run_pass(draw_all);
    });
    {
        const Closer closer{handover};
        for (std::size_t begin = 0; begin < finder.size();) {
            TileBatch batch = gather(finder, begin, layout, options, grid);
            const std::size_t count = batch.count();
            if (!handover.put(batch)) break;
            report(progress, begin, finder.size());
            begin += count;
        }
    }
    drawing.get();
    report(progress, finder.size(), finder.size());
    return areas;
}

}  // namespace surflux
