#include "surflux/radiosity/form_factor_operator.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/available_memory.h"
#include "surflux/core/error.h"
#include "surflux/core/parallel.h"
#include "surflux/radiosity/symmetric_scaling.h"
#include "surflux/radiosity/tuning.h"

namespace surflux {

namespace {

constexpr double closure_tolerance = 1e-10, closed = 1e-6;

std::vector<double> densities(const RowBlock& rows, const std::vector<double>& areas) {
    std::vector<double> out(areas.size());
    for (std::size_t i = 0; i < areas.size(); ++i) out[i] = rows.rays[i] / areas[i];
    return out;
}

// A product is made of this many ranges of rows, each with sums of its own, whatever the number of threads. Rows and
// senders are gone through in blocks, so that what rays look up of senders stays in cache.
constexpr std::size_t ranges = 4, rows_at_once = 4096, senders_at_once = 131072;

// out_i = the sum of weight(1 / (n_i / A_i + n_j / A_j)) x_j over all rays between i and j, both ways, of `width`
// channels out of `channels`, from `channel` on.
template <std::size_t width, class Weight>
void multiply(const RowBlock& rows, const std::vector<double>& density, const std::vector<double>& x,
              std::size_t channel, std::size_t channels, std::vector<double>& out, const Weight& weight) {
    struct Lane {
        double density, x[width], sum[width];
    };
    const std::size_t n = rows.size();
    std::vector<std::vector<Lane>> lanes(ranges);
    parallel_for(ranges, 1, [&](std::size_t range) {
        std::vector<Lane>& lane = lanes[range];
        lane.resize(n);
        for (std::size_t i = 0; i < n; ++i) {
            lane[i].density = density[i];
            std::copy_n(x.data() + i * channels + channel, width, lane[i].x);
        }
        const std::size_t end = (range + 1) * n / ranges;
        for (std::size_t first = range * n / ranges; first < end; first += rows_at_once) {
            const std::size_t last = std::min(end, first + rows_at_once);
            std::vector<std::size_t> next(rows.begin.begin() + static_cast<std::ptrdiff_t>(first),
                                          rows.begin.begin() + static_cast<std::ptrdiff_t>(last));
            for (std::size_t below = senders_at_once; below < n + senders_at_once; below += senders_at_once)
                for (std::size_t i = first; i < last; ++i) {
                    const Lane own = lane[i];
                    double sum[width] = {};
                    std::size_t k = next[i - first];
                    for (; k < rows.begin[i + 1] && rows.met[k] < below; ++k) {
                        Lane& other = lane[rows.met[k]];
                        const double w = weight(1.0 / (own.density + other.density));
                        for (std::size_t c = 0; c < width; ++c) {
                            sum[c] += w * other.x[c];
                            other.sum[c] += w * own.x[c];
                        }
                    }
                    next[i - first] = k;
                    for (std::size_t c = 0; c < width; ++c) lane[i].sum[c] += sum[c];
                }
        }
    });
    parallel_for(n, 4096, [&](std::size_t i) {
        for (std::size_t c = 0; c < width; ++c) {
            double& to = out[i * channels + channel + c] = 0.0;
            for (const std::vector<Lane>& lane : lanes) to += lane[i].sum[c];
        }
    });
}

template <class Weight>
void exchange_product(const RowBlock& rows, const std::vector<double>& density, const std::vector<double>& x,
                      std::size_t channels, std::vector<double>& out, const Weight& weight) {
    out.resize(x.size());
    std::size_t channel = 0;
    for (; channel + 3 <= channels; channel += 3) multiply<3>(rows, density, x, channel, channels, out, weight);
    for (; channel < channels; ++channel) multiply<1>(rows, density, x, channel, channels, out, weight);
}

double itself(double value) { return value; }
double squared(double value) { return value * value; }

}  // namespace

FormFactorOperator::FormFactorOperator(State state) : state_(std::move(state)) {
    const std::size_t n = state_.areas.size();
    const RowBlock& rows = state_.rows;
    require(rows.rays.size() == n && rows.into_backs.size() == n && rows.begin.size() == n + 1 &&
                rows.begin.front() == 0 && rows.begin.back() == rows.met.size() && state_.scale.size() == n &&
                state_.escape.size() == n && state_.absorbed.size() == n,
            "form factors: arrays of different lengths");
    require(std::is_sorted(rows.begin.begin(), rows.begin.end()), "form factors: rows that overlap");
    for (std::size_t i = 0; i < n; ++i) {
        const auto at = [&](std::size_t k) { return rows.met.begin() + static_cast<std::ptrdiff_t>(k); };
        const std::size_t met = rows.begin[i + 1] - rows.begin[i];
        require(rows.rays[i] > 0 && met + rows.into_backs[i] <= rows.rays[i],
                "form factors: more ends than rays in row ", i);
        require(std::is_sorted(at(rows.begin[i]), at(rows.begin[i + 1])), "form factors: row ", i, " is not ascending");
        require(state_.areas[i] > 0.0 && std::isfinite(state_.areas[i]), "form factors: area ", i, " is not above 0");
        for (const std::vector<double>* shares : {&state_.scale, &state_.escape, &state_.absorbed})
            require((*shares)[i] >= 0.0 && (*shares)[i] <= PairsTuning{}.largest_scale, "form factors: row ", i,
                    " has no such share");
    }
    for (const std::uint32_t j : rows.met) require(j < n, "form factors: a surfel past the last");
    density_ = densities(rows, state_.areas);
    std::vector<double> row;
    apply(std::vector<double>(n, 1.0), 1, row);
    for (std::size_t i = 0; i < n; ++i)
        require(std::abs(row[i] + state_.escape[i] + state_.absorbed[i] - 1.0) <= closed, "form factors: row ", i,
                " does not make 1");
}

void FormFactorOperator::apply(const std::vector<double>& x, std::size_t channels, std::vector<double>& out) const {
    std::vector<double> scaled(x);
    for (std::size_t k = 0; k < x.size(); ++k) scaled[k] *= state_.scale[k / channels];
    exchange_product(state_.rows, density_, scaled, channels, out, itself);
    for (std::size_t k = 0; k < x.size(); ++k) out[k] *= state_.scale[k / channels] / state_.areas[k / channels];
}

void FormFactorOperator::apply_transposed(const std::vector<double>& x, std::size_t channels,
                                          std::vector<double>& out) const {
    std::vector<double> by_area(x);
    for (std::size_t k = 0; k < x.size(); ++k) by_area[k] /= state_.areas[k / channels];
    apply(by_area, channels, out);
    for (std::size_t k = 0; k < x.size(); ++k) out[k] *= state_.areas[k / channels];
}

std::vector<double> FormFactorOperator::variance(const std::vector<double>& x) const {
    // Rows make what they meet, so that what differs from a row's mean has variance, sum_j w_ij^2 (x_j - mean_i)^2, and
    // the mean has that of the share that meets anything.
    const std::size_t n = size();
    std::vector<double> value, moments(3 * n), sums;
    apply(x, 1, value);
    for (std::size_t j = 0; j < n; ++j) {
        const double weight = state_.scale[j] * state_.scale[j];
        moments[3 * j] = weight;
        moments[3 * j + 1] = weight * x[j];
        moments[3 * j + 2] = weight * x[j] * x[j];
    }
    exchange_product(state_.rows, density_, moments, 3, sums, squared);
    for (std::size_t i = 0; i < n; ++i) {
        const double met = 1.0 - state_.escape[i] - state_.absorbed[i], row = state_.scale[i] / state_.areas[i];
        const double mean = met > 0.0 ? value[i] / met : 0.0;
        const double spread = sums[3 * i + 2] - 2.0 * mean * sums[3 * i + 1] + mean * mean * sums[3 * i];
        value[i] = row * row * std::max(0.0, spread) + mean * mean * met * (1.0 - met) / state_.rows.rays[i];
    }
    return value;
}

FormFactorOperator form_factor_operator(const CompiledScene& compiled, const FormFactorOperatorOptions& options,
                                        const StageProgress& progress) {
    const Surfels& s = compiled.scene().surfels;
    require_areas(compiled.scene());
    const double wanted = 4.0 * static_cast<double>(s.size()) * options.rays;
    require(wanted <= 0.75 * available_memory(), "rays: ", s.size(), " surfels with ", options.rays, " rays each need ",
            wanted / 1e9, " GB, and there are ", 0.75 * available_memory() / 1e9, " GB for it");
    FormFactorOperator::State state;
    state.areas = s.areas;
    const Tracer& tracer = compiled.tracer(progress("trace"));
    state.rows = gather_rows(compiled.scene(), tracer, places_of(s), std::vector<int>(s.size(), options.rays),
                             options.seed, progress("rays"), options.team);
    const std::vector<double> density = densities(state.rows, state.areas);
    ScalingProblem problem;
    problem.totals = s.areas;
    // As in closure.h: disks' own losses are known better than what their rows come to.
    const PairsTuning tuning;
    problem.yields.assign(s.size(), tuning.yield_of_disks);
    for (const Triangle& t : s.triangles) problem.yields[t.surfel] = 1.0;
    for (std::size_t i = 0; i < s.size(); ++i) {
        const double rays = state.rows.rays[i];
        state.escape.push_back(static_cast<double>(state.rows.escaped(i)) / rays);
        state.absorbed.push_back(state.rows.into_backs[i] / rays);
        problem.lost.push_back(s.areas[i] * (state.escape[i] + state.absorbed[i]));
    }
    problem.product = [&](const std::vector<double>& x, std::vector<double>& out) {
        exchange_product(state.rows, density, x, 1, out, itself);
    };
    Scaling found = scale_symmetrically(problem, tuning.largest_scale, closure_tolerance, progress("closure"));
    for (std::size_t i = 0; i < s.size(); ++i) {
        const double lost = found.lost_scale[i] * (state.escape[i] + state.absorbed[i]), row = found.rows[i] - lost;
        state.escape[i] = std::min(found.lost_scale[i] * state.escape[i], 1.0 - std::min(1.0, row));
        state.absorbed[i] = std::max(0.0, 1.0 - row - state.escape[i]);
    }
    state.scale = std::move(found.scale);
    return FormFactorOperator(std::move(state));
}

}  // namespace surflux
