#include "surflux/transfer/harmonic_projection.h"

#include <cmath>

#include "surflux/core/error.h"
#include "surflux/core/gauss_legendre.h"
#include "surflux/core/parallel.h"
#include "surflux/core/sampling.h"
#include "surflux/lights/environment.h"
#include "surflux/transfer/harmonic_rotation.h"
#include "surflux/transfer/spherical_harmonics.h"

namespace surflux {

namespace {

// Integrals of cos(m phi) and sin(m phi) over the pixels of a row: [m width + column]. In EnvironmentMap::frame phi is
// 0 in the middle of the image, and columns go against it.
struct Columns {
    Columns(std::size_t width, int order) {
        for (int m = 0; m < order; ++m)
            for (std::size_t col = 0; col < width; ++col) {
                const double half = pi / static_cast<double>(width),
                             middle = pi - half * (2.0 * static_cast<double>(col) + 1.0);
                const double size = m == 0 ? 2.0 * half : 2.0 / m * std::sin(m * half);
                cosines.push_back(size * std::cos(m * middle));
                sines.push_back(size * std::sin(m * middle));
            }
    }
    std::vector<double> cosines, sines;
};

// Integrals of the latitude parts over the heights of rows, by their solid angle: a smooth function of the angle,
// which few nodes integrate to rounding where rows are narrow, and some more where they are not.
class Rows {
public:
    Rows(std::size_t height, int order) : basis_(order), height_(static_cast<double>(height)) {
        gauss_legendre(8 + 2 * order / static_cast<int>(height), nodes_, weights_);
    }
    void integrate(std::size_t row, std::vector<double>& out) const {
        out.assign(basis_.size(), 0.0);
        std::vector<double> at(basis_.size(), 0.0);
        for (std::size_t k = 0; k < nodes_.size(); ++k) {
            const double theta = pi * (static_cast<double>(row) + nodes_[k]) / height_;
            basis_.latitudes(std::cos(theta), std::sin(theta), at.data());
            const double weight = weights_[k] * pi / height_ * std::sin(theta);
            for (std::size_t i = 0; i < out.size(); ++i) out[i] += weight * at[i];
        }
    }

private:
    SphericalHarmonics basis_;
    double height_;
    std::vector<double> nodes_, weights_;
};

struct Sums {
    std::vector<Rgb> all;
    Sums& operator+=(const Sums& other) {
        if (all.empty()) all.resize(other.all.size());
        for (std::size_t i = 0; i < other.all.size(); ++i) all[i] += other.all[i];
        return *this;
    }
};

constexpr std::size_t rows_at_once = 16;

}  // namespace

std::vector<Rgb> project_environment(const Environment& environment, int order) {
    const SphericalHarmonics basis(order);
    if (environment.pixels.empty()) {
        std::vector<Rgb> constant(basis.size());
        constant[0] = std::sqrt(4.0 * pi) * environment.radiance;
        return constant;
    }
    const std::size_t w = environment.width, h = environment.height;
    const Columns columns(w, order);
    const Rows rows(h, order);
    const Sums sums = parallel_sum<Sums>(h, rows_at_once, [&](std::size_t row, Sums& sum) {
        sum.all.resize(basis.size());
        std::vector<double> latitude;
        rows.integrate(row, latitude);
        const Rgb* pixels = environment.pixels.data() + row * w;
        for (int m = 0; m < order; ++m) {
            Rgb cosine, sine;
            for (std::size_t col = 0; col < w; ++col) {
                cosine += columns.cosines[static_cast<std::size_t>(m) * w + col] * pixels[col];
                sine += columns.sines[static_cast<std::size_t>(m) * w + col] * pixels[col];
            }
            for (int l = m; l < order; ++l) {
                const double size = latitude[SphericalHarmonics::index(l, m)];
                sum.all[SphericalHarmonics::index(l, m)] += size * cosine;
                if (m > 0) sum.all[SphericalHarmonics::index(l, -m)] += size * sine;
            }
        }
    });
    const Frame frame = EnvironmentMap(environment).frame();
    const Vec3 axes[] = {
        {frame.u.x, frame.v.x, frame.n.x}, {frame.u.y, frame.v.y, frame.n.y}, {frame.u.z, frame.v.z, frame.n.z}};
    std::vector<Rgb> turned(basis.size());
    HarmonicRotation(axes, order).apply(&sums.all[0].x, &turned[0].x, 3);
    return turned;
}

Environment environment_of_harmonics(const std::vector<Rgb>& coefficients, std::size_t width, std::size_t height) {
    const int order = SphericalHarmonics::order_of(coefficients.size(), "coefficients");
    require(width >= 1 && height >= 1, "size: wanted at least one pixel, got ", width, " x ", height);
    Environment out;
    out.width = width;
    out.height = height;
    out.pixels.resize(width * height);
    const Columns columns(width, order);
    const Rows rows(height, order);
    parallel_for(height, rows_at_once, [&](std::size_t row) {
        std::vector<double> latitude;
        rows.integrate(row, latitude);
        const double top = std::cos(pi * static_cast<double>(row) / static_cast<double>(height));
        const double bottom = std::cos(pi * static_cast<double>(row + 1) / static_cast<double>(height));
        const double solid_angle = (top - bottom) * 2.0 * pi / static_cast<double>(width);
        Rgb* pixels = out.pixels.data() + row * width;
        for (int m = 0; m < order; ++m) {
            Rgb cosine, sine;
            for (int l = m; l < order; ++l) {
                const double size = latitude[SphericalHarmonics::index(l, m)] / solid_angle;
                cosine += size * coefficients[SphericalHarmonics::index(l, m)];
                if (m > 0) sine += size * coefficients[SphericalHarmonics::index(l, -m)];
            }
            for (std::size_t col = 0; col < width; ++col)
                pixels[col] += columns.cosines[static_cast<std::size_t>(m) * width + col] * cosine +
                               columns.sines[static_cast<std::size_t>(m) * width + col] * sine;
        }
    });
    return out;
}

}  // namespace surflux
