#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>

#include "shapes.h"
#include "surflux/solution/self_check.h"

namespace surflux {
namespace {

Solution solution_of(const Scene& scene, const std::vector<Rgb>& irradiance) {
    Solution out;
    out.surfels = scene.surfels;
    out.irradiance = out.radiosity = irradiance;
    out.direct.resize(irradiance.size());
    out.parents.resize(irradiance.size());
    std::iota(out.parents.begin(), out.parents.end(), 0u);
    return out;
}

double error_of(const Scene& scene, double irradiance) {
    const std::vector<Rgb> all(scene.surfels.size(), Rgb{1, 1, 1} * irradiance);
    SelfCheckOptions options;
    options.surfels = 200;
    return gathering_error(scene, Tracer(scene), solution_of(scene, all), options).estimate.error;
}

// A room whose walls emit E and reflect rho: H = E / (1 - rho) everywhere. One bounce of what is off by a share s
// brings back rho s: a check that looks two bounces deep would see (1 - rho^2) s.
TEST(SelfCheck, SeesAllBounces) {
    for (const double rho : {0.5, 0.9, 0.99}) {
        const Scene scene = shapes::scene_of({shapes::cube_inside(4, rho, 1.0)});
        const double exact = 1.0 / (1.0 - rho);
        EXPECT_LT(error_of(scene, exact), 1e-9) << rho;
        // Not to all digits: the halves have different places, of whose rays other shares arrive near by.
        for (const double off : {0.8, 1.1}) EXPECT_NEAR(error_of(scene, off * exact) / std::abs(1.0 - off), 1.0, 1e-3);
    }
}

// A lamp in the middle of a black ball of radius 2: H = I / 4, all of it direct.
TEST(SelfCheck, SeesDirectLight) {
    const Scene scene =
        shapes::scene_of({shapes::sphere(2000, 2.0, -1.0, 0.0, 0.0)}, {PointLight{{0, 0, 0}, {4, 4, 4}}});
    EXPECT_LT(error_of(scene, 1.0), 1e-9);
    EXPECT_NEAR(error_of(scene, 1.1), 0.1, 1e-6);
    EXPECT_NEAR(error_of(scene, 0.9), 0.1, 1e-6);
}

// Nothing is sure of what is not a number.
TEST(SelfCheck, ClaimsNothingOfNaN) {
    const Scene scene = shapes::scene_of({shapes::cube_inside(4, 0.5, 1.0)});
    EXPECT_EQ(error_of(scene, std::numeric_limits<double>::quiet_NaN()), 1.0);
}

}  // namespace
}  // namespace surflux
