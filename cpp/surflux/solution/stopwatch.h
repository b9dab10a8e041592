#pragma once

#include <chrono>
#include <string>

#include "surflux/solution/solution.h"

namespace surflux {

inline double total_seconds(const Figures& timings) {
    double sum = 0.0;
    for (const auto& stage : timings) sum += stage.second;
    return sum;
}

// Seconds by stage: what passed since the last lap goes to the stage that is named, beside what it has already.
class Stopwatch {
public:
    explicit Stopwatch(Figures& timings) : timings_(timings) {}
    void lap(const std::string& stage) {
        const auto now = Clock::now();
        const double seconds = std::chrono::duration<double>(now - last_).count();
        last_ = now;
        for (auto& [name, value] : timings_)
            if (name == stage) return void(value += seconds);
        timings_.emplace_back(stage, seconds);
    }

private:
    using Clock = std::chrono::steady_clock;
    Figures& timings_;
    Clock::time_point last_ = Clock::now();
};

}  // namespace surflux
