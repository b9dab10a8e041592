#include "surflux/render/environment_image.h"

#include <list>

#include "surflux/core/parallel.h"
#include "surflux/lights/environment.h"
#include "surflux/render/pixel_places.h"
#include "surflux/render/splats.h"

namespace surflux {

std::vector<float> environment_image(const std::vector<Light>& lights, const Camera& camera, std::size_t width,
                                     std::size_t height, int samples, const std::vector<float>& coverage) {
    require(samples >= 1 && samples <= 16, "samples: wanted 1 to 16, got ", samples);
    require(coverage.size() == width * height, "coverage: wanted one number for each of ", width * height,
            " pixels, got ", coverage.size());
    Rgb constant;
    std::list<EnvironmentMap> images;
    for (const Light& light : lights) {
        const auto* environment = std::get_if<Environment>(&light);
        if (!environment) continue;
        if (environment->pixels.empty())
            constant += environment->radiance;
        else
            images.emplace_back(*environment);
    }
    const auto fine = static_cast<std::size_t>(samples);
    const PixelRays rays(camera, width * fine, height * fine);
    const double per_subpixel = 1.0 / static_cast<double>(fine * fine);
    std::vector<float> out(3 * width * height);
    parallel_for(width * height, 1024, [&](std::size_t pixel) {
        const double left = 1.0 - static_cast<double>(coverage[pixel]);
        if (!(left > 0.0)) return;
        Rgb sum;
        if (!images.empty()) {
            for (std::size_t k = 0; k < fine * fine; ++k) {
                const std::size_t x = pixel % width * fine + k % fine, y = pixel / width * fine + k / fine;
                const Vec3 direction = normalized(rays.direction(static_cast<double>(x), static_cast<double>(y)));
                for (const EnvironmentMap& image : images) sum += image.radiance(direction);
            }
        }
        store(&out[3 * pixel], left * (constant + per_subpixel * sum));
    });
    return out;
}

}  // namespace surflux
