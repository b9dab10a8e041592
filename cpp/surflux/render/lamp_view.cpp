#include "surflux/render/lamp_view.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/sampling.h"
#include "surflux/render/splats.h"
#include "surflux/solution/stopwatch.h"

namespace surflux {

namespace {

constexpr auto per_pi = static_cast<float>(1.0 / pi);
constexpr double in_front = 0.99999;  // a lamp in the plane of a ceiling is seen
constexpr std::size_t pixels_of_block = 2048;

// A rectangle that may be seen, from its front alone.
struct SeenRectangle {
    Vec3 corner, u, v, normal;
    double squared;

    explicit SeenRectangle(const AreaLight& light)
        : corner(light.corner),
          u(light.edge_u),
          v(light.edge_v),
          normal(cross(u, v)),
          squared(length_squared(normal)) {}

    // The depth at which a ray of length 1 along the view axis meets it, or 0.
    double depth_along(const Vec3& origin, const Vec3& direction) const {
        const double along = dot(normal, direction);
        if (!(along < 0.0)) return 0.0;
        const double depth = dot(normal, corner - origin) / along;
        if (!(depth > 0.0)) return 0.0;
        const Vec3 at = origin + depth * direction - corner;
        const double s = dot(cross(at, v), normal) / squared, t = dot(cross(u, at), normal) / squared;
        return s >= 0.0 && s <= 1.0 && t >= 0.0 && t <= 1.0 ? depth : 0.0;
    }

    // Rows that it may be seen in: all of them where it reaches the plane of the eye.
    void bound_rows(const PixelRays& rays, std::size_t& top, std::size_t& bottom) const {
        top = 0, bottom = rays.height;
        double low = 1e30, high = -1e30;
        for (const Vec3& p : {corner, corner + u, corner + v, corner + u + v}) {
            const Vec3 at = rays.frame.to_camera(p);
            if (!(at.z > 0.0)) return;
            const double row = at.y / rays.size_at(at.z) + 0.5 * static_cast<double>(rays.height);
            low = std::min(low, row), high = std::max(high, row);
        }
        const auto clamped = [&](double row) {
            return static_cast<std::size_t>(std::clamp(row, 0.0, static_cast<double>(rays.height)));
        };
        top = clamped(std::floor(low - 1.0)), bottom = clamped(std::ceil(high + 1.0));
    }
};

bool is_dark(const Colors& values) {
    return std::all_of(values.palette().begin(), values.palette().end(), [](const Rgb& v) { return v == Rgb{}; });
}

}  // namespace

LampView::LampView(const LocalTransfer& transfer, const PatchCorners& corners, const Camera& camera, std::size_t width,
                   std::size_t height, const LampViewOptions& options, gl::Api api)
    : transfer_(transfer), samples_(static_cast<std::size_t>(options.samples)) {
    require(options.samples >= 1, "samples: wanted at least 1, got ", options.samples);
    require(options.shadow_cell >= 1, "shadow_cell: wanted at least 1");
    const CompiledScene& compiled = transfer.scene();
    const Surfels& surfels = compiled.scene().surfels;
    Stopwatch watch(timings_);
    places_ = pixel_places(compiled, camera, width * samples_, height * samples_, options.culling, api);
    watch.lap("places");
    field_ = flat_field(compiled.scene(), corners, places_, camera, options.culling, api);
    put_seen(surfels.reflectance, albedo_);
    if (!is_dark(surfels.emission)) put_seen(surfels.emission, emission_);
    watch.lap("field");
    cells_ = std::make_unique<SmoothCells>(places_, options.shadow_cell);
    watch.lap("cells");
}

LampFrame LampView::frame(const std::vector<Light>& lights, const std::vector<Rgb>& reflectance,
                          const LampFrameOptions& options) const {
    const Scratch<Work>::Lent lent(work_);
    Work& work = *lent;
    LampFrame out;
    Stopwatch watch(out.timings);
    const std::vector<Rgb> indirect = transfer_.indirect(lights, reflectance, options.relight);
    watch.lap("relight");
    const PixelLight light(transfer_.scene().tracer(), places_, *cells_);
    out.shadow_rays = light.irradiance(lights, options.light, work.light, work.direct);
    watch.lap("direct");
    field_.draw(indirect, work.indirect);
    find_lamps(lights, work.lamps);
    if (!reflectance.empty()) put_seen(reflectance, work.albedo);
    compose(lights, reflectance.empty() ? albedo_ : work.albedo, work, options, out);
    watch.lap("picture");
    return out;
}

// Of patches each pixel shows its own, of disks a mean.
template <class Values>
void LampView::put_seen(const Values& of_surfels, std::vector<float>& out) const {
    out.assign(3 * places_.size(), 0.0f);
    parallel_for(places_.size(), pixels_of_block, [&](std::size_t p) {
        if (!places_.is_seen(p)) return;
        if (places_.triangle[p] != PixelPlaces::none) return store(&out[3 * p], of_surfels[places_.surfel[p]]);
        Rgb sum;
        field_.pixels.for_row(p, [&](std::uint32_t node, float w) {
            field_.nodes.for_row(node, [&](std::uint32_t i, float) { sum += static_cast<double>(w) * of_surfels[i]; });
        });
        store(&out[3 * p], sum);
    });
}

void LampView::find_lamps(const std::vector<Light>& lights, SeenLamps& out) const {
    const PixelRays& rays = places_.rays;
    out.lamp.clear();
    for (std::size_t k = 0; k < lights.size(); ++k) {
        const auto* light = std::get_if<AreaLight>(&lights[k]);
        if (!light) continue;
        const SeenRectangle rectangle(*light);
        std::size_t top = 0, bottom = 0;
        rectangle.bound_rows(rays, top, bottom);
        if (top >= bottom) continue;
        if (out.lamp.empty()) out.lamp.assign(places_.size(), -1), out.depth = places_.depth;
        parallel_for(bottom - top, 4, [&](std::size_t row) {
            for (std::size_t x = 0; x < rays.width; ++x) {
                const auto column = static_cast<double>(x), line = static_cast<double>(top + row);
                const std::size_t p = (top + row) * rays.width + x;
                const double depth = rectangle.depth_along(rays.origin(column, line), rays.direction(column, line));
                if (depth > 0.0 && in_front * depth < static_cast<double>(out.depth[p])) {
                    out.depth[p] = static_cast<float>(depth);
                    out.lamp[p] = static_cast<std::int32_t>(k);
                }
            }
        });
    }
}

void LampView::compose(const std::vector<Light>& lights, const std::vector<float>& albedo, const Work& work,
                       const LampFrameOptions& options, LampFrame& out) const {
    const std::size_t width = this->width(), pixels = width * height(), n = samples_;
    const float share = 1.0f / static_cast<float>(n * n);
    out.radiance.resize(3 * pixels);
    if (options.parts) out.direct.resize(3 * pixels), out.indirect.resize(3 * pixels);
    float behind[3];
    store(behind, options.background);
    parallel_for(pixels, pixels_of_block, [&](std::size_t pixel) {
        float direct[3] = {0, 0, 0}, indirect[3] = {0, 0, 0};
        for (std::size_t k = 0; k < n * n; ++k) {
            const std::size_t p = (pixel / width * n + k / n) * width * n + pixel % width * n + k % n;
            const std::int32_t lamp = work.lamps.lamp.empty() ? -1 : work.lamps.lamp[p];
            if (lamp >= 0) {
                float shining[3];
                store(shining, std::get<AreaLight>(lights[static_cast<std::size_t>(lamp)]).exitance);
                for (std::size_t c = 0; c < 3; ++c) direct[c] += per_pi * shining[c];
            } else if (!places_.is_seen(p)) {
                for (std::size_t c = 0; c < 3; ++c) direct[c] += behind[c];
            } else {
                for (std::size_t c = 0; c < 3; ++c) {
                    const float reflected = per_pi * albedo[3 * p + c];
                    direct[c] += reflected * work.direct[3 * p + c];
                    indirect[c] += reflected * work.indirect[3 * p + c];
                    if (!emission_.empty()) direct[c] += per_pi * emission_[3 * p + c];
                }
            }
        }
        for (std::size_t c = 0; c < 3; ++c) {
            const std::size_t at = 3 * pixel + c;
            out.radiance[at] = share * (direct[c] + indirect[c]);
            if (options.parts) out.direct[at] = share * direct[c], out.indirect[at] = share * indirect[c];
        }
    });
}

std::vector<float> LampView::albedo(const std::vector<Rgb>& reflectance) const {
    if (reflectance.empty()) return averaged(albedo_);
    std::vector<float> own;
    put_seen(reflectance, own);
    return averaged(own);
}

std::vector<float> LampView::averaged(const std::vector<float>& values) const {
    const std::size_t width = this->width(), n = samples_;
    std::vector<float> out(3 * width * height(), 0.0f);
    parallel_for(width * height(), pixels_of_block, [&](std::size_t pixel) {
        for (std::size_t k = 0; k < n * n; ++k) {
            const std::size_t p = (pixel / width * n + k / n) * width * n + pixel % width * n + k % n;
            for (std::size_t c = 0; c < 3; ++c) out[3 * pixel + c] += values[3 * p + c] / static_cast<float>(n * n);
        }
    });
    return out;
}

std::size_t LampView::bytes() const {
    const auto of = [](const auto& v) { return v.size() * sizeof v[0]; };
    return of(places_.surfel) + of(places_.triangle) + of(places_.depth) + of(places_.offset) + of(places_.normal) +
           of(field_.nodes.begin) + of(field_.nodes.entries) + of(field_.pixels.begin) + of(field_.pixels.entries) +
           of(albedo_) + of(emission_) + cells_->bytes();
}

}  // namespace surflux
