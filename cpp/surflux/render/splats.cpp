#include "surflux/render/splats.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "surflux/core/parallel.h"
#include "surflux/render/bends.h"
#include "surflux/render/creases.h"
#include "surflux/render/principal_axes.h"
#include "surflux/render/reach.h"

namespace surflux {

namespace {

// How far a kernel reaches along its normal, over how far in its plane: a neighbour on a curved surface lies off the
// plane by up to a tenth of it where the surfels sample the surface well, another sheet mostly farther.
constexpr double thickness = 0.45;
// Of patches, whose neighbours are known: over how far from the plane those lie, and of how far kernels reach.
constexpr double over_joined = 2.0, least_thickness = 0.005;

// The low-pass filter of the picture, in subpixels: where its kernel ends. Its standard deviation is .31 of that, half
// a subpixel: what one subpixel sees is not seen by none of them, and not by three.
constexpr double filter_reach = 1.6;

// Least cosine between view and normal for which the filter is stretched in full.
constexpr double grazing = 0.02;

// Disks that are smaller than this, in subpixels, are drawn flat: nobody could tell.
constexpr double bent_from = 2.0;

constexpr double crack = 0.008;  // subpixels: two of the places that corners are drawn at

// Of the width of a kernel on the picture, the least share that is not the picture's filter for which walls are found.
constexpr double filling = 0.2;

constexpr double least_seen = 0.999;  // of a patch that nothing covers, the share of its triangles that is its area
constexpr double hair_behind = 5e-5;  // of the distance

// How disks are drawn that fill pixels enough to tell.
struct Shapes {
    std::vector<Bend> bends;
    std::vector<Creases> creases;
};

constexpr double beyond_crease = 0.05;

void store_box(std::int32_t* to, const PixelBox& box) {
    to[0] = box.left, to[1] = box.top, to[2] = box.right, to[3] = box.bottom;
}

// Those of all that `make` makes, in their order.
template <class Primitive, class Make>
std::vector<Primitive> made(std::size_t count, const Make& make) {
    constexpr std::size_t grain = 8192;
    std::vector<std::vector<Primitive>> parts((count + grain - 1) / grain);
    parallel_blocks(count, grain, [&](std::size_t begin, std::size_t end) {
        std::vector<Primitive>& part = parts[begin / grain];
        Primitive one{};
        for (std::size_t i = begin; i < end; ++i)
            if (make(i, one)) part.push_back(one);
    });
    std::size_t total = 0;
    for (const auto& part : parts) total += part.size();
    std::vector<Primitive> all;
    all.reserve(total);
    for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
    return all;
}

// A surfel in the camera's frame, turned towards the eye where backs are drawn.
struct Seen {
    Vec3 center, normal;
    bool back;
};

struct Drawing {
    const Surfels& surfels;
    const std::vector<std::int32_t>& objects;
    const CameraFrame& frame;
    const PixelGrid& grid;
    const DrawingOptions& options;

    // Along the ray from the eye, or the rays, to a point of the camera's frame.
    Vec3 way_to(const Vec3& point) const { return grid.parallel ? Vec3{0, 0, 1} : point; }
    Seen seen(std::size_t i) const {
        Seen out{frame.to_camera(surfels.positions[i]), frame.turn(surfels.normals[i]), false};
        out.back = !options.culling && dot(way_to(out.center), out.normal) > 0.0;
        if (out.back) out.normal = -out.normal;
        return out;
    }
    // Fronts and backs of one object do not blend.
    std::int32_t group(std::size_t i, bool back) const { return 2 * objects[i] + (back ? 1 : 0); }
    // Of a subpixel at a depth.
    double subpixel(double depth) const { return 2.0 * grid.tan_y / grid.height * (grid.parallel ? 1.0 : depth); }
    PixelBox pixels(const Ellipsoid& around) const {
        return seen_pixels(around, grid.tan_x, grid.tan_y, grid.width, grid.height, grid.parallel);
    }

    bool make(std::size_t i, double radius, const Bend& bend, const Creases& creases, DrawnDisk& disk) const {
        const Seen s = seen(i);
        if (!(radius > 0.0) || s.center.z + radius <= 0.0) return false;
        const double curve = std::max(std::abs(bend.along), std::abs(bend.across));
        const double sagitta = 0.5 * curve * radius * radius;
        // What faces away on all of it shows no front; of a disk that bends, the rim may.
        const Vec3 way = way_to(s.center);
        if (options.culling && dot(s.normal, way) >= std::min(1.0, 2.0 * curve * radius) * length(way)) return false;
        const Frame axes = frame_around(s.normal);
        const double wide = curve > 0.0 ? 1.3 : 1.0;
        const Ellipsoid around{s.center, {wide * radius * axes.u, wide * radius * axes.v, 1.6 * sagitta * s.normal}};
        const PixelBox box = pixels(around);
        if (box.empty()) return false;
        store(disk.center, s.center);
        store(disk.normal, s.normal);
        store(disk.direction, curve > 0.0 ? frame.turn(bend.direction) : axes.u);
        const double side = s.back ? -1.0 : 1.0;
        disk.radius = static_cast<float>(radius);
        disk.along = static_cast<float>(side * bend.along);
        disk.across = static_cast<float>(side * bend.across);
        // Flat disks that overlap on a bent surface stand off it by up to as much; bent ones lie on it.
        disk.sag = static_cast<float>((curve > 0.0 ? 0.15 : 0.4) * radius);
        for (std::size_t k = 0; k < creases.size(); ++k) {
            store(disk.creases[k], frame.turn(creases[k].normal));
            // A little beyond: edges of scans are found so well, and slits between the disks of both sides show.
            disk.creases[k][3] = static_cast<float>(creases[k].limit + beyond_crease * radius);
        }
        disk.index = static_cast<std::int32_t>(i);
        disk.group = group(i, s.back);
        store_box(disk.box, box);
        return true;
    }

    // The kernel on the surface, widened by the filter of the picture as it falls on the tangent plane (object-space
    // EWA, Ren, Pfister and Zwicker 2002, eq. 8): in its plane the variances add up.
    // joined: how far off its plane lies what it is joined to.
    bool make(std::size_t i, const Reach& reach, double joined, DrawnKernel& kernel) const {
        const Seen s = seen(i);
        const double along = options.footprint * reach.along, across = options.footprint * reach.across;
        const double pixel = filter_reach * subpixel(std::max(s.center.z, 0.0));
        if (!(along > 0.0) || s.center.z + std::hypot(along, pixel / grazing) <= 0.0) return false;
        const Vec3 way = way_to(s.center);
        const double distance = length(way);
        if (!(distance > 0.0)) return false;  // it has no direction to be seen in
        const double along_view = dot(s.normal, way) / distance;
        // Turned away so far that no front-facing surface agrees with its normal (see kernel_fragment).
        if (options.culling && (grid.parallel || distance > 10.0 * along) && along_view > 0.9) return false;
        const double cosine = std::max(std::abs(along_view), grazing);
        const Vec3 tilt = way / distance - along_view * s.normal;
        const Vec3 x = length(tilt) > 1e-6 ? normalized(tilt) : frame_around(s.normal).u, y = cross(s.normal, x);
        const Vec3 own = frame.turn(reach.direction);
        const double c = dot(own, x), d = dot(own, y), more = along * along - across * across;
        const PrincipalAxes seen_as = principal_axes(across * across + more * c * c + pixel * pixel / (cosine * cosine),
                                                     more * c * d, across * across + more * d * d + pixel * pixel);
        const Vec3 direction = seen_as.x * x + seen_as.y * y;
        const double mean = std::sqrt(along * across);
        const double thick = std::min(thickness * mean, over_joined * joined + least_thickness * mean);
        const double squares[3] = {seen_as.along, seen_as.across,
                                   thick * thick + thickness * thickness * pixel * pixel};
        const Ellipsoid around{s.center,
                               {std::sqrt(squares[0]) * direction, std::sqrt(squares[1]) * cross(s.normal, direction),
                                std::sqrt(squares[2]) * s.normal}};
        const PixelBox box = pixels(around);
        if (box.empty()) return false;
        store(kernel.center, s.center);
        store(kernel.normal, s.normal);
        store(kernel.direction, direction);
        // As the mass of the kernel stays what it was, the peak of a wider one is lower.
        kernel.amplitude = static_cast<float>(along * across / std::sqrt(squares[0] * squares[1]));
        // 1 where the surfel fills many pixels, towards 0 where a pixel sees many.
        kernel.agreement = static_cast<float>(along * across / (along * across + pixel * pixel));
        for (int axis = 0; axis < 3; ++axis) kernel.shrink[axis] = static_cast<float>(1.0 / squares[axis]);
        kernel.index = static_cast<std::int32_t>(i);
        kernel.group = group(i, s.back);
        store_box(kernel.box, box);
        return true;
    }

    Shapes shapes(const std::vector<Reach>& reach) const {
        std::vector<std::uint32_t> asked, around, sharp;
        for (std::size_t i = 0; i < surfels.size(); ++i) {
            const Vec3 center = frame.to_camera(surfels.positions[i]);
            const double radius = reach[i].disk, smallest = bent_from * subpixel(center.z);
            // Neighbours of those asked for are about as large, and may be out of view.
            if (!(radius > 0.0) || radius < 0.5 * smallest || center.z + 5.0 * radius <= 0.0) continue;
            const auto beyond = [&](double place, double tangent) {
                if (grid.parallel) return std::abs(place) > tangent + 5.0 * radius;
                return std::abs(place) > tangent * center.z + 5.0 * radius * (1.0 + tangent);
            };
            if (beyond(center.x, grid.tan_x) || beyond(center.y, grid.tan_y)) continue;
            around.push_back(static_cast<std::uint32_t>(i));
            if (radius >= smallest) asked.push_back(static_cast<std::uint32_t>(i));
        }
        Shapes out{std::vector<Bend>(surfels.size()), std::vector<Creases>(surfels.size())};
        const std::vector<Bend> bends = bends_of(surfels, objects, asked, around);
        for (std::size_t k = 0; k < asked.size(); ++k) {
            out.bends[asked[k]] = bends[k];
            if (bends[k].sharp) sharp.push_back(asked[k]);
        }
        const std::vector<Creases> creases = creases_of(surfels, objects, sharp, around);
        for (std::size_t k = 0; k < sharp.size(); ++k) out.creases[sharp[k]] = creases[k];
        return out;
    }

    // Gives kernels the walls in their way, but those that hardly fill a pixel: nobody could tell.
    void add_walls(DrawnGeometry& geometry, const KernelWalls& walls) const {
        for (DrawnKernel& kernel : geometry.kernels) {
            kernel.walls[0] = kernel.walls[1] = static_cast<std::int32_t>(geometry.walls.size());
            if (kernel.agreement < filling) continue;
            const auto i = static_cast<std::size_t>(kernel.index);
            const auto [begin, end] = walls.of(i);
            if (begin == end) continue;
            const Vec3 along = frame.turn_back(stored(kernel.direction));
            const Vec3 across = cross(frame.turn_back(stored(kernel.normal)), along);  // of backs, too
            const Frame own = frame_around(surfels.normals[i]);
            const auto turned = [&](float x, float y, const Vec3& axis) {
                return static_cast<float>(x * dot(own.u, axis) + y * dot(own.v, axis));
            };
            for (const WallTrace* wall = begin; wall != end; ++wall) {
                const auto [ax, ay, bx, by] = wall->ends;
                geometry.walls.push_back(
                    {{turned(ax, ay, along), turned(ax, ay, across), turned(bx, by, along), turned(bx, by, across)}});
            }
            kernel.walls[1] = static_cast<std::int32_t>(geometry.walls.size());
        }
    }

    // Where a corner of one patch lies on an edge of another, as where meshes are cut, pixels between them would stay
    // open: corners are drawn at places of a grid in each pixel. They are moved outwards by a hair, and edges with
    // them, but for those of slivers.
    void close_cracks(Triangle& t) const {
        const Vec3 ab = t.b - t.a, bc = t.c - t.b, ca = t.a - t.c;
        const double sides[3] = {length(ab), length(bc), length(ca)};
        if (!(sides[0] > 0.0 && sides[1] > 0.0 && sides[2] > 0.0)) return;
        const Vec3 u = ab / sides[0], v = bc / sides[1], w = ca / sides[2];
        const auto hair = [&](const Vec3& corner) { return crack * subpixel(std::max(corner.z, 0.0)); };
        t.a += hair(t.a) * (w - u), t.b += hair(t.b) * (u - v), t.c += hair(t.c) * (v - w);
    }

    // Of patches that coincide the last is seen (Cover), and the area of others is what of them it leaves. Those are
    // drawn a hair farther away, at the same pixels, the more so the less is left.
    std::vector<double> behind() const {
        std::vector<double> drawn(surfels.areas.empty() ? 0 : surfels.size()), out(surfels.size(), 0.0);
        if (drawn.empty()) return out;
        for (const Triangle& t : surfels.triangles) drawn[t.surfel] += area_of(t);
        for (std::size_t i = 0; i < out.size(); ++i)
            if (surfels.areas[i] < least_seen * drawn[i]) out[i] = hair_behind * (2.0 - surfels.areas[i] / drawn[i]);
        return out;
    }

    void move_back(Triangle& t, double farther) const {
        for (Vec3* corner : {&t.a, &t.b, &t.c})
            if (grid.parallel)
                corner->z += farther * std::abs(corner->z);
            else
                *corner *= 1.0 + farther;
    }

    void add_triangle(DrawnGeometry& geometry, const Triangle& world, const Vec3& normal, int index, int object,
                      double farther = 0.0) const {
        Triangle t{frame.to_camera(world.a), frame.to_camera(world.b), frame.to_camera(world.c), 0};
        const double farthest = std::max({t.a.z, t.b.z, t.c.z});
        if (farthest <= 0.0) return;
        const bool away = dot(cross_of(t), way_to(t.a)) >= 0.0, back = away && !options.culling && index >= 0;
        if (away && !back) return;
        if (index >= 0) close_cracks(t);
        if (farther > 0.0) move_back(t, farther);
        FlatTriangle& flat = geometry.triangles.emplace_back();
        store(flat.corners[0], t.a);
        store(flat.corners[1], t.b);
        store(flat.corners[2], t.c);
        store(flat.normal, (back ? -1.0 : 1.0) * frame.turn(normal));
        flat.index = index;
        flat.group = object < 0 ? -1 : 2 * object + (back ? 1 : 0);
        geometry.far_depth = std::max(geometry.far_depth, farthest);
    }

    void add_emitter(DrawnGeometry& geometry, const VisibleEmitter& e, int index) const {
        const Vec3 opposite = e.corner + e.u + e.v;
        const Vec3 normal = normalized(cross(e.u, e.v));
        add_triangle(geometry, {e.corner, e.corner + e.u, opposite, 0}, normal, index, -1);
        add_triangle(geometry, {e.corner, opposite, e.corner + e.v, 0}, normal, index, -1);
    }
};

}  // namespace

DrawnGeometry drawn_geometry(const Surfels& surfels, const std::vector<std::int32_t>& objects,
                             const std::vector<VisibleEmitter>& emitters, const CameraFrame& frame,
                             const PixelGrid& grid, const DrawingOptions& options) {
    const Drawing drawing{surfels, objects, frame, grid, options};
    DrawnGeometry geometry;
    const std::vector<Reach> reach = reaches(surfels);
    const Shapes shapes = drawing.shapes(reach);
    geometry.disks = made<DrawnDisk>(surfels.size(), [&](std::size_t i, DrawnDisk& disk) {
        return reach[i].disk > 0.0 && drawing.make(i, reach[i].disk, shapes.bends[i], shapes.creases[i], disk);
    });
    if (options.kernels) {
        const std::optional<KernelWalls> found =
            options.walls ? std::nullopt : std::make_optional<KernelWalls>(surfels, options.footprint);
        const KernelWalls& walls = options.walls ? *options.walls : *found;
        geometry.kernels = made<DrawnKernel>(surfels.size(), [&](std::size_t i, DrawnKernel& kernel) {
            return drawing.make(i, reach[i], walls.depth(i), kernel);
        });
        drawing.add_walls(geometry, walls);
    }
    const std::vector<double> behind = drawing.behind();
    for (const Triangle& t : surfels.triangles) {
        drawing.add_triangle(geometry, t, surfels.normals[t.surfel], static_cast<std::int32_t>(t.surfel),
                             objects[t.surfel], behind[t.surfel]);
    }
    for (std::size_t k = 0; k < emitters.size(); ++k) {
        const VisibleEmitter& e = emitters[k];
        require(is_finite(e.corner) && is_finite(e.u) && is_finite(e.v) && is_finite(e.radiance), "emitters: number ",
                k, " is not finite");
        require(length(cross(e.u, e.v)) > 0.0, "emitters: the edges of number ", k, " span no area");
        drawing.add_emitter(geometry, e, -2 - static_cast<std::int32_t>(k));
    }
    for (const DrawnDisk& disk : geometry.disks)
        geometry.far_depth = std::max(geometry.far_depth, static_cast<double>(disk.center[2] + disk.radius + disk.sag));
    return geometry;
}

}  // namespace surflux
