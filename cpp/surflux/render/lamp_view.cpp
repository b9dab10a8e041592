#include "surflux/render/lamp_view.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/sampling.h"
#include "surflux/render/splats.h"
#include "surflux/solution/stopwatch.h"

namespace surflux {

namespace {

constexpr auto per_pi = static_cast<float>(1.0 / pi);
constexpr std::size_t pixels_of_block = 2048;

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

void LampView::paint(const std::vector<char>& painted, const std::vector<float>& reflectance,
                     const std::vector<float>& emission) {
    require(
        painted.size() == places_.size() && reflectance.size() == albedo_.size() && emission.size() == albedo_.size(),
        "painted: wanted all subpixels");
    if (emission_.empty() && std::any_of(emission.begin(), emission.end(), [](float v) { return v > 0.0f; }))
        emission_.assign(emission.size(), 0.0f);
    for (std::size_t k = 0; k < albedo_.size(); ++k) {
        if (!painted[k / 3]) continue;
        albedo_[k] = reflectance[k];
        if (!emission_.empty()) emission_[k] = emission[k];
    }
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
    field_.at_nodes(indirect, work.indirect);
    find_lamps(lights, places_, work.lamps);
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

void LampView::compose(const std::vector<Light>& lights, const std::vector<float>& albedo, const Work& work,
                       const LampFrameOptions& options, LampFrame& out) const {
    const std::size_t pixels = width() * height(), subpixels = samples_ * samples_;
    const float share = 1.0f / static_cast<float>(subpixels);
    out.radiance.resize(3 * pixels);
    out.coverage.resize(pixels);
    if (options.parts) out.direct.resize(3 * pixels), out.indirect.resize(3 * pixels);
    parallel_for(pixels, pixels_of_block, [&](std::size_t pixel) {
        float direct[3] = {0, 0, 0}, indirect[3] = {0, 0, 0};
        std::size_t covered = subpixels;
        for (std::size_t k = 0; k < subpixels; ++k) {
            const std::size_t p = subpixel(pixel, k);
            const std::int32_t lamp = work.lamps.at(p);
            if (lamp != SeenLamps::none) {
                float shining[3];
                store(shining, std::get<AreaLight>(lights[static_cast<std::size_t>(lamp)]).exitance);
                for (std::size_t c = 0; c < 3; ++c) direct[c] += per_pi * shining[c];
            } else if (!places_.is_seen(p)) {
                --covered;
            } else {
                const FlatField::Value others = field_.at_pixel(p, work.indirect);
                for (std::size_t c = 0; c < 3; ++c) {
                    const float reflected = per_pi * albedo[3 * p + c];
                    direct[c] += reflected * work.direct[3 * p + c];
                    indirect[c] += reflected * others[c];
                    if (!emission_.empty()) direct[c] += per_pi * emission_[3 * p + c];
                }
            }
        }
        for (std::size_t c = 0; c < 3; ++c) {
            const std::size_t at = 3 * pixel + c;
            out.radiance[at] = share * (direct[c] + indirect[c]);
            if (options.parts) out.direct[at] = share * direct[c], out.indirect[at] = share * indirect[c];
        }
        out.coverage[pixel] = static_cast<float>(static_cast<double>(covered) / static_cast<double>(subpixels));
    });
}

LampSurfaces LampView::surfaces(const std::vector<Light>& lights, const std::vector<Rgb>& reflectance) const {
    const std::size_t pixels = width() * height(), subpixels = samples_ * samples_;
    std::vector<float> own;
    if (!reflectance.empty()) put_seen(reflectance, own);
    const std::vector<float>& albedo = reflectance.empty() ? albedo_ : own;
    SeenLamps lamps;
    find_lamps(lights, places_, lamps);
    std::vector<std::int32_t> number;  // of each light among area lights
    std::int32_t count = 0;
    for (const Light& light : lights) number.push_back(std::holds_alternative<AreaLight>(light) ? count++ : count);
    LampSurfaces out;
    out.albedo.resize(3 * pixels);
    out.normal.resize(3 * pixels);
    out.depth.resize(pixels);
    out.index.resize(pixels, -1);
    parallel_for(pixels, pixels_of_block, [&](std::size_t pixel) {
        for (std::size_t k = 0; k < subpixels; ++k) {
            const std::size_t p = subpixel(pixel, k);
            if (lamps.at(p) != SeenLamps::none) continue;
            for (std::size_t c = 0; c < 3; ++c)
                out.albedo[3 * pixel + c] += albedo[3 * p + c] / static_cast<float>(subpixels);
        }
        const std::size_t p = subpixel(pixel, samples_ / 2 * (samples_ + 1));
        const std::int32_t lamp = lamps.at(p);
        const auto width = places_.rays.width;
        const Vec3 direction = places_.rays.direction(static_cast<double>(p % width), static_cast<double>(p / width));
        if (lamp != SeenLamps::none) {
            const auto& light = std::get<AreaLight>(lights[static_cast<std::size_t>(lamp)]);
            store(&out.normal[3 * pixel], normalized(cross(light.edge_u, light.edge_v)));
            out.index[pixel] = -2 - number[static_cast<std::size_t>(lamp)];
            out.depth[pixel] = lamps.depth[p];
            return;
        }
        out.depth[pixel] = places_.depth[p];
        if (!places_.is_seen(p)) return;
        const Vec3 normal = places_.normal_at(p);
        store(&out.normal[3 * pixel], dot(normal, direction) > 0.0 ? -normal : normal);
        out.index[pixel] = static_cast<std::int32_t>(places_.surfel[p]);
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
