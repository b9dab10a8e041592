#include "surflux/render/pixel_places.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "surflux/core/parallel.h"
#include "surflux/render/surface_pass.h"

namespace surflux {

namespace {

constexpr std::size_t square = 4;                 // pixels a side whose rays are traced one after another
constexpr std::size_t pixels_at_once = 1u << 20;  // of a band that OpenGL draws

class Placing {
public:
    Placing(const CompiledScene& scene, const PixelRays& rays, bool culling)
        : scene_(scene), surfels_(scene.scene().surfels), culling_(culling), triangles_(triangle_ranges(surfels_)) {
        const std::size_t n = rays.width * rays.height;
        out_.rays = rays;
        out_.surfel.resize(n, PixelPlaces::none);
        out_.triangle.resize(n, PixelPlaces::none);
        out_.depth.resize(n, std::numeric_limits<float>::infinity());
        out_.offset.resize(3 * n);
        out_.normal.resize(3 * n);
    }

    bool has_disks() const {
        for (std::uint32_t i = 0; i < surfels_.size(); ++i)
            if (!is_patch(i)) return true;
        return false;
    }

    void by_rays() {
        const std::size_t bands = (out_.rays.height + square - 1) / square;
        const Tracer& tracer = scene_.tracer();
        parallel_for(bands, 1, [&](std::size_t band) {
            const std::size_t bottom = std::min((band + 1) * square, out_.rays.height);
            std::vector<std::size_t> pixels;
            for (std::size_t left = 0; left < out_.rays.width; left += square)
                for (std::size_t y = band * square; y < bottom; ++y)
                    for (std::size_t x = left; x < std::min(left + square, out_.rays.width); ++x)
                        pixels.push_back(y * out_.rays.width + x);
            look(tracer, pixels);
        });
    }

    void by_drawing(gl::Api api) {
        const PixelRays& rays = out_.rays;
        const auto width = static_cast<int>(rays.width), height = static_cast<int>(rays.height);
        const PixelGrid grid{width, height, 0.5 * rays.step * width, 0.5 * rays.step * height, rays.frame.parallel};
        const std::vector<std::int32_t> objects(scene_.scene().object.begin(), scene_.scene().object.end());
        DrawingOptions options;
        options.kernels = false;
        options.culling = culling_;
        const DrawnGeometry geometry = drawn_geometry(surfels_, objects, {}, rays.frame, grid, options);
        const std::size_t rows = std::max<std::size_t>(1, pixels_at_once / rays.width);
        gl::run_pass(
            [&](const gl::Context& context) {
                const gl::Functions& gl = context.gl;
                check_drawable(gl, width, static_cast<GLsizei>(std::min(rows, rays.height)));
                for (std::size_t first = 0; first < rays.height; first += rows)
                    draw(gl, grid, geometry, first, std::min(rows, rays.height - first));
            },
            api);
    }

    PixelPlaces take() { return std::move(out_); }

private:
    bool is_patch(std::uint32_t surfel) const { return triangles_[surfel] != triangles_[surfel + 1]; }

    // What faces away is passed, and looked behind from just beyond it.
    void look(const Tracer& tracer, const std::vector<std::size_t>& pixels) {
        std::vector<Ray> rays;
        std::vector<double> passed(pixels.size(), 0.0);
        std::vector<std::size_t> of(pixels.size());
        std::vector<Hit> hits;
        for (std::size_t k = 0; k < pixels.size(); ++k) {
            const Vec3 direction = normalized(direction_of(pixels[k]));
            rays.push_back({{origin_of(pixels[k]), direction, Hit::none}, direction});
            of[k] = k;
        }
        while (!rays.empty()) {
            tracer.closest_coherent(rays, hits);
            std::size_t left = 0;
            for (std::size_t r = 0; r < rays.size(); ++r) {
                const std::size_t k = of[r], pixel = pixels[k];
                if (!hits[r]) continue;
                const std::uint32_t surfel = hits[r].surfel;
                const Vec3 direction = rays[r].direction;
                passed[k] += hits[r].distance;
                if (!culling_ || dot(surfels_.normals[surfel], direction) < 0.0) {
                    put_on_patch(pixel, surfel, passed[k] * dot(direction, out_.rays.frame.forward));
                    continue;
                }
                passed[k] += tracer.contact(surfel);
                rays[left] = {{origin_of(pixel) + passed[k] * direction, direction, Hit::none}, direction};
                of[left++] = k;
            }
            rays.resize(left);
            of.resize(left);
        }
    }

    void draw(const gl::Functions& gl, const PixelGrid& grid, const DrawnGeometry& geometry, std::size_t first,
              std::size_t count) {
        const auto rows = static_cast<GLsizei>(count);
        const DrawnView view(grid, static_cast<int>(first), rows, geometry.far_depth);
        const SurfacePass pass(gl, view, geometry.disks, geometry.triangles);
        const std::size_t n = count * out_.rays.width, begin = first * out_.rays.width;
        std::vector<float> surface(4 * n);
        std::vector<std::int32_t> names(2 * n);
        pass.target.read(0, grid.width, rows, GL_RGBA, GL_FLOAT, surface.data());
        pass.target.read(1, grid.width, rows, GL_RG_INTEGER, GL_INT, names.data());
        const CameraFrame& frame = out_.rays.frame;
        parallel_for(n, 1024, [&](std::size_t k) {
            if (names[2 * k] < 0) return;
            const auto surfel = static_cast<std::uint32_t>(names[2 * k]);
            const auto depth = static_cast<double>(surface[4 * k]);
            if (is_patch(surfel)) return put_on_patch(begin + k, surfel, depth);
            const double side = (names[2 * k + 1] & 1) == 1 ? -1.0 : 1.0;  // seen from behind
            const auto axis = [&](int a) { return side * static_cast<double>(surface[4 * k + 1 + a]); };
            put(begin + k, surfel, depth,
                normalized(axis(0) * frame.right + axis(1) * frame.down + axis(2) * frame.forward));
        });
    }

    // Where the ray meets the plane of the triangle that it meets the patch in, given about how deep that is.
    void put_on_patch(std::size_t pixel, std::uint32_t surfel, double depth) {
        const Vec3 origin = origin_of(pixel), direction = direction_of(pixel);
        std::uint32_t best = triangles_[surfel];
        double inside = -std::numeric_limits<double>::infinity();
        for (std::uint32_t t = best; t < triangles_[surfel + 1]; ++t) {
            const Vec3 w = corner_weights(surfels_.triangles[t], origin + depth * direction);
            const double least = std::min({w.x, w.y, w.z});
            if (least > inside) inside = least, best = t;
        }
        const Triangle& triangle = surfels_.triangles[best];
        const Vec3 normal = cross_of(triangle);
        const double along = dot(normal, direction);
        // Seen edge on, the plane is met anywhere.
        if (std::abs(along) > 1e-6 * length(normal)) depth = dot(normal, triangle.a - origin) / along;
        out_.triangle[pixel] = best;
        put(pixel, surfel, depth, surfels_.normals[surfel]);
    }

    void put(std::size_t pixel, std::uint32_t surfel, double depth, const Vec3& normal) {
        out_.surfel[pixel] = surfel;
        out_.depth[pixel] = static_cast<float>(depth);
        store(&out_.offset[3 * pixel], origin_of(pixel) - out_.rays.frame.eye + depth * direction_of(pixel));
        store(&out_.normal[3 * pixel], normal);
    }

    Vec3 origin_of(std::size_t pixel) const { return out_.rays.origin(x_of(pixel), y_of(pixel)); }
    Vec3 direction_of(std::size_t pixel) const { return out_.rays.direction(x_of(pixel), y_of(pixel)); }
    double x_of(std::size_t pixel) const { return static_cast<double>(pixel % out_.rays.width); }
    double y_of(std::size_t pixel) const { return static_cast<double>(pixel / out_.rays.width); }

    const CompiledScene& scene_;
    const Surfels& surfels_;
    const bool culling_;
    const std::vector<std::uint32_t> triangles_;
    PixelPlaces out_;
};

}  // namespace

PixelRays::PixelRays(const Camera& camera, std::size_t w, std::size_t h)
    : frame(frame_of(camera)), width(w), height(h), step(2.0 * frame.tan_half / static_cast<double>(h)) {}

Vec3 corner_weights(const Triangle& triangle, const Vec3& point) {
    const Vec3 normal = cross_of(triangle);
    const double squared = length_squared(normal);
    if (!(squared > 0.0)) return {1, 0, 0};
    const double b = dot(cross(point - triangle.a, triangle.c - triangle.a), normal) / squared;
    const double c = dot(cross(triangle.b - triangle.a, point - triangle.a), normal) / squared;
    return {1.0 - b - c, b, c};
}

PixelPlaces pixel_places(const CompiledScene& scene, const Camera& camera, std::size_t width, std::size_t height,
                         bool culling, gl::Api api) {
    require(width >= 1 && height >= 1 && width <= 65536 && height <= 65536,
            "size: wanted 1 to 65536 pixels a side, got ", width, " x ", height);
    Placing placing(scene, PixelRays(camera, width, height), culling);
    if (placing.has_disks())
        placing.by_drawing(api);
    else
        placing.by_rays();
    return placing.take();
}

}  // namespace surflux
