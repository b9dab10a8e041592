#include "surflux/solution/nodal_regression.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "surflux/core/parallel.h"

namespace surflux {

namespace {

constexpr std::array<std::size_t, 4> sizes = {12, 20, 40, 90};  // nodes of a fit, itself among them
constexpr std::size_t least_nodes = 9;                          // six terms need some more than six
constexpr std::size_t pooled = 9;                               // nodes whose errors tell the variance of one
constexpr std::size_t averaged = 12;                            // nodes whose risks tell that of one
constexpr double like = 0.95;                                   // cosine between normals
constexpr double least_variance = 0.01;  // of another node, of that of one: no weight is infinite
constexpr double ridge = 1e-6;
constexpr std::size_t terms = 6;

using Terms = std::array<double, terms>;

// Solves m x = (1, 0, 0, ...) by Cholesky's method. False where nodes do not tell a quadratic, as those on a line.
bool solve_for_first(std::array<Terms, terms>& m, Terms& x) {
    for (std::size_t r = 0; r < terms; ++r) m[r][r] *= 1.0 + ridge;
    for (std::size_t r = 0; r < terms; ++r)
        for (std::size_t c = 0; c <= r; ++c) {
            double sum = m[r][c];
            for (std::size_t k = 0; k < c; ++k) sum -= m[r][k] * m[c][k];
            if (r != c) {
                m[r][c] = sum / m[c][c];
            } else {
                if (!(sum > 0.0)) return false;
                m[r][r] = std::sqrt(sum);
            }
        }
    for (std::size_t r = 0; r < terms; ++r) {
        x[r] = r == 0 ? 1.0 : 0.0;
        for (std::size_t k = 0; k < r; ++k) x[r] -= m[r][k] * x[k];
        x[r] /= m[r][r];
    }
    for (std::size_t r = terms; r-- > 0;) {
        for (std::size_t k = r + 1; k < terms; ++k) x[r] -= m[k][r] * x[k];
        x[r] /= m[r][r];
    }
    return true;
}

class Regression {
public:
    Regression(const NodalField& nodes, const std::vector<Rgb>& values, const std::vector<double>& standard_error,
               const Sight& sight, const Progress& progress)
        : nodes_(nodes), values_(values), sight_(sight), variance_(values.size()), fits_(values.size()) {
        in_blocks(progress, [&](std::uint32_t i, Near& near) {
            around(i, pooled, near);
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
            around(i, averaged, near);
            std::array<double, sizes.size() + 1> risk = {};
            for (const Interpolation::Weight& n : near)
                for (std::size_t k = 0; k < risk.size(); ++k) risk[k] += fits_[n.site].risk[k];
            const double least = *std::min_element(risk.begin(), risk.end());
            // Exponential weights of risks in units of the variance (Leung and Barron 2006).
            double total = 0.0;
            Rgb sum;
            for (std::size_t k = 0; k < risk.size(); ++k) {
                const double weight = std::exp(0.25 * (least - risk[k]));
                total += weight;
                sum += weight * (k == 0 ? values_[i] : fits_[i].of_size(k - 1));
            }
            for (int c = 0; c < 3; ++c) out[i][c] = std::max(0.0, sum[c] / total);
        });
        return out;
    }

private:
    using Near = std::vector<Interpolation::Weight>;

    // In single precision: there are many.
    struct Fits {
        std::array<float, 3 * sizes.size()> values;
        std::array<float, sizes.size() + 1> risk;  // of none and of each, over the variance

        Rgb of_size(std::size_t k) const { return {values[3 * k], values[3 * k + 1], values[3 * k + 2]}; }
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
            if (dot(nodes_.normals()[n.site], nodes_.normals()[i]) < like) return true;
            return differ_much(luminance(values_[n.site]), luminance(values_[i])) &&
                   !sight_.joined(nodes_.sites().place(sight_, i), nodes_.sites().place(sight_, n.site));
        };
        near.erase(std::remove_if(near.begin(), near.end(), stranger), near.end());
    }

    void fit(std::uint32_t i, Near& near) {
        Fits& out = fits_[i];
        for (std::size_t k = 0; k < sizes.size(); ++k)
            for (std::size_t c = 0; c < 3; ++c)
                out.values[3 * k + c] = static_cast<float>(values_[i][static_cast<int>(c)]);
        out.risk.fill(1.0f);
        if (!(variance_[i] > 0.0)) return;
        around(i, sizes.back(), near);
        drop_strangers(i, near);
        for (std::size_t k = 0; k < sizes.size() && near.size() >= least_nodes; ++k) {
            const std::size_t count = std::min(sizes[k], near.size());
            Rgb value;
            double own = 1.0;
            if (!evaluate(i, near, count, value, own)) continue;
            const double off = luminance(value) - luminance(values_[i]);
            for (std::size_t c = 0; c < 3; ++c) out.values[3 * k + c] = static_cast<float>(value[static_cast<int>(c)]);
            out.risk[k + 1] = static_cast<float>(off * off / variance_[i] - 1.0 + 2.0 * own);
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
        std::array<Terms, terms> m = {};
        for (std::size_t n = 0; n < count; ++n) {
            const Vec3 d = (nodes_.positions()[near[n].site] - at) / reach;
            const double x = dot(d, frame.u), y = dot(d, frame.v), t = 1.0 - length_squared(d);
            row[n] = {1.0, x, y, x * x, x * y, y * y};
            weight[n] = t * t * variance_[i] / std::max(variance_[near[n].site], least_variance * variance_[i]);
            for (std::size_t r = 0; r < terms; ++r)
                for (std::size_t c = 0; c <= r; ++c) m[r][c] += weight[n] * row[n][r] * row[n][c];
        }
        Terms x;
        if (!solve_for_first(m, x)) return false;
        value = values_[i];
        own = 1.0;
        // Shares make 1: what is the same everywhere stays.
        for (std::size_t n = 0; n < count; ++n) {
            double share = 0.0;
            for (std::size_t r = 0; r < terms; ++r) share += row[n][r] * x[r];
            share *= weight[n];
            if (near[n].site == i) continue;
            value += share * (values_[near[n].site] - values_[i]);
            own -= share;
        }
        return true;
    }

    const NodalField& nodes_;
    const std::vector<Rgb>& values_;
    const Sight& sight_;
    std::vector<double> variance_;
    std::vector<Fits> fits_;
};

}  // namespace

std::vector<Rgb> without_noise(const NodalField& nodes, const std::vector<Rgb>& values,
                               const std::vector<double>& standard_error, const Sight& sight,
                               const Progress& progress) {
    return Regression(nodes, values, standard_error, sight, progress).mixed(progress);
}

}  // namespace surflux
