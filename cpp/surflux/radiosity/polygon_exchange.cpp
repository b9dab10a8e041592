#include "surflux/radiosity/polygon_exchange.h"

#include <array>
#include <cmath>
#include <cstddef>

#include "surflux/core/gauss_legendre.h"
#include "surflux/core/sampling.h"

namespace surflux {

namespace {

// x ln |(x, h)|.
double log_term(double x, double squared) { return squared > 0.0 ? 0.5 * x * std::log(squared) : 0.0; }

// Integral of ln |p - q| over the points q of the edge from b along the unit vector u.
double log_distance(const Vec3& p, const Vec3& b, const Vec3& u, double length_b) {
    const Vec3 d = p - b;
    const double along = dot(d, u), rest = length_b - along;
    const double h2 = length_squared(d - along * u), h = std::sqrt(h2);
    // The angle at p between both ends of the edge, for atan(along / h) + atan(rest / h).
    return log_term(along, along * along + h2) + log_term(rest, rest * rest + h2) - length_b +
           h * std::atan2(h * length_b, h2 - along * rest);
}

struct Rule {
    std::vector<double> at, weight;
};

// Gauss and Legendre's rule on [0, 1] after t = s^2 (3 - 2 s), which is flat at both ends.
Rule graded(int count) {
    Rule rule;
    gauss_legendre(count, rule.at, rule.weight);
    for (std::size_t k = 0; k < rule.at.size(); ++k) {
        const double s = rule.at[k];
        rule.at[k] = s * s * (3.0 - 2.0 * s);
        rule.weight[k] *= 6.0 * s * (1.0 - s);
    }
    return rule;
}

// The same after t = s^4 (35 - 84 s + 70 s^2 - 20 s^3), flatter still.
Rule steep(int count) {
    Rule rule;
    gauss_legendre(count, rule.at, rule.weight);
    for (std::size_t k = 0; k < rule.at.size(); ++k) {
        const double s = rule.at[k], t = 1.0 - s;
        rule.at[k] = s * s * s * s * (35.0 + s * (-84.0 + s * (70.0 - 20.0 * s)));
        rule.weight[k] *= 140.0 * s * s * s * t * t * t;
    }
    return rule;
}

Rule plain(int count) {
    Rule rule;
    gauss_legendre(count, rule.at, rule.weight);
    return rule;
}

constexpr int most_points = 32;

const Rule& rule_of(Grading grading, int count) {
    using Rules = std::array<Rule, most_points + 1>;
    static const std::array<Rules, 3> rules = [] {
        std::array<Rules, 3> all;
        for (int n = 1; n <= most_points; ++n) {
            const auto k = static_cast<std::size_t>(n);
            all[0][k] = plain(n);
            all[1][k] = graded(n);
            all[2][k] = steep(n);
        }
        return all;
    }();
    return rules[static_cast<std::size_t>(grading)][static_cast<std::size_t>(count)];
}

}  // namespace

void clip_to_front(const Polygon& polygon, const Vec3& point, const Vec3& normal, Polygon& out) {
    out.clear();
    for (std::size_t k = 0; k < polygon.size(); ++k) {
        const Vec3 &a = polygon[k], &b = polygon[(k + 1) % polygon.size()];
        const double height_a = dot(a - point, normal), height_b = dot(b - point, normal);
        if (height_a >= 0.0) out.push_back(a);
        if ((height_a > 0.0 && height_b < 0.0) || (height_a < 0.0 && height_b > 0.0))
            out.push_back(a + (height_a / (height_a - height_b)) * (b - a));
    }
}

namespace {

// Where on an edge from `a` the logarithm of the distance to another edge, from `b`, is not smooth or nearly so: beside
// the ends of that, and where both are closest. Ascending shares of `edge_a`, from 0 to 1.
class Cuts {
public:
    Cuts(const Vec3& a, const Vec3& edge_a, const Vec3& b, const Vec3& edge_b) {
        const double aa = length_squared(edge_a), ab = dot(edge_a, edge_b), bb = length_squared(edge_b);
        const Vec3 d = b - a;
        const double along_a = dot(d, edge_a), along_b = dot(d, edge_b);
        const auto add = [&](double s, double t) {
            if (!(s > least && s < 1.0 - least)) return;
            if (!(length_squared(d + t * edge_b - s * edge_a) < near * near * aa)) return;
            std::size_t k = count_++;
            for (; k > 0 && at_[k - 1] > s; --k) at_[k] = at_[k - 1];
            at_[k] = s;
        };
        add(along_a / aa, 0.0);
        add((along_a + ab) / aa, 1.0);
        const double determinant = aa * bb - ab * ab;
        if (determinant > parallel * aa * bb) {
            const double t = (ab * along_a - aa * along_b) / determinant;
            if (t > 0.0 && t < 1.0) add((along_a + t * ab) / aa, t);
        }
        at_[count_++] = 1.0;
    }
    const double* begin() const { return at_.data(); }
    const double* end() const { return at_.data() + count_; }

private:
    static constexpr double least = 1e-9, near = 0.3, parallel = 1e-12;
    std::array<double, 4> at_{};
    std::size_t count_ = 0;
};

}  // namespace

double polygon_exchange(const Polygon& a, const Polygon& b, int count, Grading grading) {
    const Rule& rule = rule_of(grading, count);
    double sum = 0.0;
    for (std::size_t j = 0; j < b.size(); ++j) {
        const Vec3 edge_b = b[(j + 1) % b.size()] - b[j];
        const double length_b = length(edge_b);
        if (!(length_b > 0.0)) continue;
        const Vec3 u = edge_b / length_b;
        for (std::size_t i = 0; i < a.size(); ++i) {
            const Vec3 edge_a = a[(i + 1) % a.size()] - a[i];
            const double turn = dot(edge_a, u);
            if (std::abs(turn) < 1e-14 * length(edge_a)) continue;
            const auto over = [&](double from, double to) {
                double inner = 0.0;
                for (std::size_t k = 0; k < rule.at.size(); ++k)
                    inner += rule.weight[k] *
                             log_distance(a[i] + (from + (to - from) * rule.at[k]) * edge_a, b[j], u, length_b);
                return (to - from) * inner;
            };
            double inner = 0.0;
            if (grading == Grading::plain) {
                inner = over(0.0, 1.0);
            } else {
                double from = 0.0;
                for (const double to : Cuts(a[i], edge_a, b[j], edge_b)) {
                    inner += over(from, to);
                    from = to;
                }
            }
            sum += turn * inner;
        }
    }
    return sum / (2.0 * pi);
}

}  // namespace surflux
