#include <gtest/gtest.h>

#include <limits>

#include "shapes.h"
#include "surflux/core/random.h"
#include "surflux/trace/tracer.h"

namespace surflux {
namespace {

using shapes::scene_of;

// A convex body under a cloud of disks that are tangent to it: an ellipsoid with these semi-axes, each point moved at
// random by up to `jitter` of the distance between them.
Surfels ellipsoid(std::size_t n, const Vec3& axes, double jitter) {
    Surfels s;
    const double step = jitter * std::sqrt(4.0 * pi / static_cast<double>(n));
    for (std::size_t i = 0; i < n; ++i) {
        Random random(5, i);
        const double z = 1.0 - 2.0 * (static_cast<double>(i) + 0.5) / static_cast<double>(n);
        const double phi = pi * (1.0 + std::sqrt(5.0)) * static_cast<double>(i), r = std::sqrt(1.0 - z * z);
        const Frame frame = frame_around({r * std::cos(phi), r * std::sin(phi), z});
        const Vec3 u =
            normalized(frame.n + step * (random.uniform() - 0.5) * frame.u + step * (random.uniform() - 0.5) * frame.v);
        s.positions.push_back({axes.x * u.x, axes.y * u.y, axes.z * u.z});
        s.normals.push_back(normalized(Vec3{u.x / axes.x, u.y / axes.y, u.z / axes.z}));
    }
    shapes::finish(s, 0.5, 0.0);
    s.radii = estimate_radii(s.positions, s.normals);
    s.areas.assign(n, 1.0);
    return s;
}

// A box of these half sizes whose edges are cylinders and whose corners spheres of radius `round`: the ends of a grid's
// normals on the sphere, moved out along each axis, and what lies between on the faces and edges.
Surfels rounded_box(int n, const Vec3& half, double round) {
    Surfels s;
    const double step = round * 0.5 * pi / n;
    // Along a face or an edge, the places between its ends: whole steps.
    const auto add = [&](const Vec3& at, const Vec3& normal) {
        s.positions.push_back(at), s.normals.push_back(normal);
    };
    const Vec3 core{half.x - round, half.y - round, half.z - round};
    const auto places = [&](int axis, const auto& at) {
        const int count = static_cast<int>(std::ceil(2.0 * core[axis] / step));
        for (int k = 0; k <= count; ++k) at(-core[axis] + 2.0 * core[axis] * k / count);
    };
    for (int axis = 0; axis < 3; ++axis)
        for (const double side : {-1.0, 1.0}) {
            const int b = (axis + 1) % 3, c = (axis + 2) % 3;
            places(b, [&](double x) {
                places(c, [&](double y) {
                    Vec3 at, normal;
                    at[axis] = side * half[axis], at[b] = x, at[c] = y;
                    normal[axis] = side;
                    add(at, normal);
                });
            });
            for (const double other : {-1.0, 1.0})
                for (int k = 1; k < n; ++k)
                    places(axis, [&](double x) {
                        const double turn = 0.5 * pi * k / n;
                        Vec3 at, normal;
                        normal[b] = side * std::cos(turn), normal[c] = other * std::sin(turn);
                        at[axis] = x;
                        at[b] = side * core[b] + round * normal[b], at[c] = other * core[c] + round * normal[c];
                        add(at, normal);
                    });
        }
    // Corners: rings of latitude between the edges.
    for (int corner = 0; corner < 8; ++corner)
        for (int k = 1; k < n; ++k) {
            const int ring = n - k + 1;
            for (int m = 1; m < ring; ++m) {
                const double up = 0.5 * pi * k / n, turn = 0.5 * pi * m / ring;
                const Vec3 u{std::cos(up) * std::cos(turn), std::cos(up) * std::sin(turn), std::sin(up)};
                Vec3 at, normal;
                for (int axis = 0; axis < 3; ++axis) {
                    const double side = corner >> axis & 1 ? 1.0 : -1.0;
                    normal[axis] = side * u[axis];
                    at[axis] = side * core[axis] + round * normal[axis];
                }
                add(at, normal);
            }
        }
    shapes::finish(s, 0.5, 0.0);
    s.radii = estimate_radii(s.positions, s.normals);
    s.areas.assign(s.size(), 1.0);
    return s;
}

constexpr double infinity = std::numeric_limits<double>::infinity();

struct Cloud {
    const char* name;
    Scene scene;
};

std::vector<Cloud> convex_clouds() {
    std::vector<Cloud> out;
    for (const std::size_t n : {500u, 1000u, 4000u}) {  // fewer turn by more than a right angle at the tips
        out.push_back({"sphere", scene_of({ellipsoid(n, {1, 1, 1}, 0.0)})});
        out.push_back({"jittered sphere", scene_of({ellipsoid(n, {1, 1, 1}, 0.7)})});
        out.push_back({"long", scene_of({ellipsoid(n, {1, 1, 3}, 0.0)})});
        out.push_back({"jittered long", scene_of({ellipsoid(n, {1, 1, 3}, 0.7)})});
    }
    for (const int n : {3, 5}) out.push_back({"rounded box", scene_of({rounded_box(n, {1, 1, 3}, 0.4)})});
    return out;
}

Vec3 on_sphere(double a, double b) {
    const double z = 1.0 - 2.0 * a, ring = std::sqrt(1.0 - z * z);
    return {ring * std::cos(2.0 * pi * b), ring * std::sin(2.0 * pi * b), z};
}

// Isotropic lines through a ball around the origin.
std::vector<Ray> lines(std::size_t count, double radius) {
    std::vector<Ray> rays;
    EvenPoints even(4, 1, 3);
    for (std::size_t k = 0; k < count; ++k) {
        const double* u = even.next();
        const Frame frame = frame_around(on_sphere(u[0], u[1]));
        const double distance = radius * std::sqrt(u[2]), turn = 2.0 * pi * u[3];
        const Vec3 beside = distance * (std::cos(turn) * frame.u + std::sin(turn) * frame.v);
        rays.push_back({{beside - 4.0 * radius * frame.n, frame.n, Hit::none}, frame.n});
    }
    return rays;
}

TEST(Rims, NoLightComesIntoAConvexCloudUnderThem) {
    // From well inside, every ray meets a back: nothing is seen of what is outside, and no front.
    for (const Cloud& cloud : convex_clouds()) {
        const Tracer tracer(cloud.scene);
        std::vector<Ray> rays;
        std::vector<Hit> hits;
        EvenPoints even(2, 1, 4);
        for (const Vec3& at : {Vec3{}, Vec3{0.4, 0.3, 0.2}, Vec3{-0.3, 0.5, 0.5}})
            for (int k = 0; k < 8000; ++k) {
                const double* u = even.next();
                const Vec3 d = on_sphere(u[0], u[1]);
                rays.push_back({{at, d, Hit::none}, d});
            }
        tracer.closest(rays, hits);
        std::size_t out = 0;
        for (const Hit& hit : hits) out += !hit || hit.front;
        EXPECT_EQ(out, 0u) << cloud.name << " " << cloud.scene.surfels.size();
    }
}

// Is the line below the tangent planes of all points at once, somewhere?
bool has_been_inside(const Surfels& s, const Ray& ray) {
    double first = 0.0, last = infinity;
    for (std::size_t i = 0; i < s.size(); ++i) {
        const double rise = dot(ray.direction, s.normals[i]);
        const double crossing = dot(s.positions[i] - ray.from.position, s.normals[i]) / rise;
        rise > 0.0 ? last = std::min(last, crossing) : first = std::max(first, crossing);
    }
    return first < last;
}

TEST(Rims, NoBackOfAConvexCloudIsSeenFromOutside) {
    // But where a line comes in between disks that miss each other.
    for (const Cloud& cloud : convex_clouds()) {
        const Tracer tracer(cloud.scene);
        const std::vector<Ray> rays = lines(30000, 3.4);
        std::vector<Hit> hits;
        tracer.closest(rays, hits);
        std::size_t backs = 0;
        for (std::size_t k = 0; k < rays.size(); ++k)
            backs += hits[k] && !hits[k].front && !has_been_inside(cloud.scene.surfels, rays[k]);
        EXPECT_EQ(backs, 0u) << cloud.name << " " << cloud.scene.surfels.size();
    }
}

TEST(Rims, NothingMeetsAConvexCloudThatLeavesIt) {
    for (const Cloud& cloud : convex_clouds()) {
        const Tracer tracer(cloud.scene);
        const Surfels& s = cloud.scene.surfels;
        std::vector<Ray> rays;
        std::vector<Hit> hits;
        EvenPoints even(2, 1, 5);
        for (std::uint32_t i = 0; i < s.size(); ++i) {
            const Frame frame = frame_around(s.normals[i]);
            for (int k = 0; k < 64; ++k) {
                const double* u = even.next();
                rays.push_back(
                    {{s.positions[i], s.normals[i], i}, frame.to_world(square_to_cosine_hemisphere(u[0], u[1]))});
            }
        }
        tracer.closest(rays, hits);
        std::size_t met = 0;
        for (const Hit& hit : hits) met += bool(hit);
        EXPECT_EQ(met, 0u) << cloud.name << " " << s.size();
    }
}

TEST(Rims, CopiesOfACloudDoNotStandInForWhatIsAround) {
    const Surfels one = ellipsoid(1000, {1, 1, 3}, 0.7);
    const Scene scene = scene_of({one, one, one, one});
    const Tracer tracer(scene);
    const std::vector<Ray> rays = lines(30000, 3.4);
    std::vector<Hit> hits;
    tracer.closest(rays, hits);
    for (const Hit& hit : hits) ASSERT_TRUE(hit.front || !hit);
}

}  // namespace
}  // namespace surflux
