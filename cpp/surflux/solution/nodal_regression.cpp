#include "surflux/solution/nodal_regression.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "surflux/core/parallel.h"

namespace surflux {

namespace {

constexpr std::array<std::size_t, 4> sizes = {12, 20, 40, 90};  // nodes of a fit, itself among them
constexpr double least_variance = 0.01;  // of another node, of that of one: no weight is infinite
constexpr double ridge = 1e-6;

using Terms = Eigen::Matrix<double, 6, 1>;

// Mean over the channels that there is light in, of each as if all light were of its colour: luminance alone would not
// see that a colour becomes another.
double squared_change(const Rgb& from, const Rgb& to) {
    const double all = color_norm(from), least = 0.05 * std::max({from.x, from.y, from.z});
    double sum = 0.0;
    int channels = 0;
    for (int c = 0; c < 3; ++c) {
        const bool is_lit = from[c] > least;
        const double change = (to[c] - from[c]) * (is_lit ? all / from[c] : 1.0);
        sum += change * change;
        channels += is_lit;
    }
    return sum / std::max(1, channels);
}

class Regression {
public:
    Regression(const NodalField& nodes, const std::vector<Rgb>& values, const std::vector<double>& standard_error,
               const Sight& sight, const RegressionTuning& tuning, const Progress& progress)
        : nodes_(nodes),
          values_(values),
          sight_(sight),
          tuning_(tuning),
          variance_(values.size()),
          fits_(values.size()) {
        in_blocks(progress, [&](std::uint32_t i, Near& near) {
            around(i, whole_number(tuning.pooled_nodes), near);
            drop_strangers(i, near);
            double sum = 0.0;
            for (const Interpolation::Weight& n : near) sum += standard_error[n.site] * standard_error[n.site];
            variance_[i] = near.empty() ? 0.0 : sum / static_cast<double>(near.size());
        });
        in_blocks(progress, [&](std::uint32_t i, Near& near) { fit(i, near); });
    }

    std::vector<Rgb> mixed(const Progress& progress) const {
        std::vector<Rgb> out = values_;
        in_blocks(progress, [&](std::uint32_t i, Near& near) {
            if (!(variance_[i] > 0.0)) return;
            around(i, whole_number(tuning_.averaged_nodes), near);
            drop_strangers(i, near);
            std::array<double, sizes.size() + 1> risk = {};
            for (const Interpolation::Weight& n : near)
                for (std::size_t k = 0; k < risk.size(); ++k) risk[k] += fits_[n.site].risk[k];
            const double least =
                *std::min_element(risk.begin(), risk.begin() + static_cast<std::ptrdiff_t>(fits_[i].count) + 1);
            // Exponential weights of risks in units of the variance (Leung and Barron 2006).
            double total = 0.0;
            Rgb sum;
            for (std::size_t k = 0; k <= fits_[i].count; ++k) {
                const double weight = std::exp(0.25 * (least - risk[k]));
                total += weight;
                sum += weight * (k == 0 ? values_[i] : fits_[i].values[k - 1]);
            }
            for (int c = 0; c < 3; ++c) out[i][c] = std::max(0.0, sum[c] / total);
        });
        return out;
    }

private:
    using Near = std::vector<Interpolation::Weight>;

    struct Fits {
        std::array<Rgb, sizes.size()> values;
        std::array<double, sizes.size() + 1> risk;  // of none and of each, over the variance
        std::size_t count = 0;                      // of those that differ: of few nodes there is one
    };

    template <class Body>
    void in_blocks(const Progress& progress, const Body& body) const {
        parallel_blocks(
            values_.size(), 64,
            [&](std::size_t begin, std::size_t end) {
                Near near;
                for (std::size_t i = begin; i < end; ++i) body(static_cast<std::uint32_t>(i), near);
            },
            progress);
    }

    void around(std::uint32_t i, std::size_t count, Near& near) const {
        nodes_.interpolation().nearest(nodes_.positions()[i], nodes_.normals()[i], nodes_.objects()[i], count, near);
    }

    // Those that a fit at a node takes: of one side of an edge, and of the air that it is in.
    void drop_strangers(std::uint32_t i, Near& near) const {
        const auto stranger = [&](const Interpolation::Weight& n) {
            if (n.site == i) return false;
            if (dot(nodes_.normals()[n.site], nodes_.normals()[i]) < tuning_.like_normals) return true;
            return differ_much(values_[n.site], values_[i]) &&
                   !sight_.joined(nodes_.sites().place(sight_, i), nodes_.sites().place(sight_, n.site));
        };
        near.erase(std::remove_if(near.begin(), near.end(), stranger), near.end());
    }

    void fit(std::uint32_t i, Near& near) {
        Fits& out = fits_[i];
        out.values.fill(values_[i]);
        out.risk.fill(1.0);
        if (!(variance_[i] > 0.0)) return;
        around(i, sizes.back(), near);
        drop_strangers(i, near);
        if (near.size() < whole_number(tuning_.least_nodes)) return;
        for (std::size_t k = 0; k < sizes.size(); ++k) {
            const std::size_t count = std::min(sizes[k], near.size());
            if (k > 0 && count == std::min(sizes[k - 1], near.size())) {
                out.values[k] = out.values[k - 1], out.risk[k + 1] = out.risk[k];
                continue;
            }
            out.count = k + 1;
            double own = 1.0;
            if (evaluate(i, near, count, out.values[k], own))
                out.risk[k + 1] = squared_change(values_[i], out.values[k]) / variance_[i] - 1.0 + 2.0 * own;
        }
    }

    // The fit at the node itself, and how much of its own value that has.
    bool evaluate(std::uint32_t i, const Near& near, std::size_t count, Rgb& value, double& own) const {
        const Vec3 &at = nodes_.positions()[i], &normal = nodes_.normals()[i];
        const Frame frame = frame_around(normal);
        double reach = 0.0;
        for (std::size_t n = 0; n < count; ++n)
            reach = std::max(reach, length_squared(nodes_.positions()[near[n].site] - at));
        reach = 1.1 * std::sqrt(reach);
        if (!(reach > 0.0)) return false;
        std::array<Terms, sizes.back()> row;
        std::array<double, sizes.back()> weight;
        Eigen::Matrix<double, 6, 6> m = Eigen::Matrix<double, 6, 6>::Zero();
        for (std::size_t n = 0; n < count; ++n) {
            const Vec3 d = (nodes_.positions()[near[n].site] - at) / reach;
            const double x = dot(d, frame.u), y = dot(d, frame.v), t = 1.0 - length_squared(d);
            row[n] << 1.0, x, y, x * x, x * y, y * y;
            weight[n] = t * t * variance_[i] / std::max(variance_[near[n].site], least_variance * variance_[i]);
            m.selfadjointView<Eigen::Lower>().rankUpdate(row[n], weight[n]);
        }
        m.diagonal() *= 1.0 + ridge;
        const Eigen::LLT<Eigen::Matrix<double, 6, 6>> factors(m);
        if (factors.info() != Eigen::Success) return false;  // nodes that tell no quadratic, as on a line
        const Terms x = factors.solve(Terms::Unit(0));
        own = 1.0;
        // Shares make 1: what is the same everywhere stays.
        for (std::size_t n = 0; n < count; ++n) {
            const double share = weight[n] * row[n].dot(x);
            if (near[n].site == i) continue;
            value += share * (values_[near[n].site] - values_[i]);
            own -= share;
        }
        return true;
    }

    const NodalField& nodes_;
    const std::vector<Rgb>& values_;
    const Sight& sight_;
    const RegressionTuning& tuning_;
    std::vector<double> variance_;
    std::vector<Fits> fits_;
};

}  // namespace

std::vector<Rgb> without_noise(const NodalField& nodes, const std::vector<Rgb>& values,
                               const std::vector<double>& standard_error, const Sight& sight, const Progress& progress,
                               const RegressionTuning& tuning) {
    return Regression(nodes, values, standard_error, sight, tuning, progress).mixed(progress);
}

}  // namespace surflux
