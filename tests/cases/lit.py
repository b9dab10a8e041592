"""Surfaces under lights and skies: direct irradiance in closed form, and one bounce of it."""

import numpy as np

import surflux as sf
from cases import closed_forms
from cases.builders import ball_inside, rectangle, strips, surfels_of
from cases.case import Case, Problem, Wanted, knobs

ALL = slice(None)
SKY = np.array([1.0, 2.0, 0.5])
SPHERE_AXES = np.array([1.0, 0.6, 0.4])


def floor(n, kind, size=2.0, rho=0.5):
    """A square around the origin that faces up."""
    return rectangle([-size / 2, -size / 2, 0], [size, 0, 0], [0, size, 0], (n, n), kind, rho)


def under_light(kind, light, expected):
    """A floor of 2 x 2 under one light; expected: (points, normals) -> H."""

    def build(n):
        return Problem(sf.Scene([floor(n, kind)], [light]), [Wanted(ALL, expected)])

    return build


def carpeted(n):
    """The floor with a carpet of 1 x 1 modelled into it: one mesh, in which both lie in one plane."""
    at = [[-1, -1], [1, -1], [1, 1], [-1, 1], [-0.43, -0.5], [0.57, -0.5], [0.57, 0.5], [-0.43, 0.5]]
    mesh = ([[*xy, 0] for xy in at], [[0, 1, 2, 3], [4, 5, 6, 7]])
    both = sf.Surfels.from_mesh(mesh, patch_area=4 / n**2)
    return Problem(sf.Scene([both], [sf.AreaLight(**LAMP)]), [Wanted(ALL, of_lamp)])


def scanned_twice(n):
    """Two clouds of one sphere under the sky, one of them of half as many points again."""
    clouds = [surfels_of(p, p) for p in (ball_inside(n).points, ball_inside(3 * n // 2).points)]
    return Problem(sf.Scene(clouds, [sf.Environment(SKY)]), [Wanted(ALL, np.pi * SKY)], quality=knobs(256))


def convex_cloud(cloud):
    def build(n):
        if cloud == "random":
            p = np.random.default_rng(5).normal(size=(n, 3))
            p /= np.linalg.norm(p, axis=1, keepdims=True)
            points, normals = p, p
        else:
            p = ball_inside(n).points
            # The normal of an ellipsoid at a p, a the axes, is along p / a.
            points, normals = (p, p) if cloud == "sphere" else (p * SPHERE_AXES, p / SPHERE_AXES)
        scene = sf.Scene([surfels_of(points, normals)], [sf.Environment(SKY)])
        return Problem(scene, [Wanted(ALL, np.pi * SKY)], quality=knobs(256))

    return build


def half_sky(kind, tilt):
    """The upper half of the sky over a plane tilted by `tilt` degrees, and no ground."""

    def build(n):
        image = np.zeros((8, 16, 3))
        image[:4] = 3.0
        b = np.radians(tilt)
        u, v = np.array([np.cos(b), 0, -np.sin(b)]), np.array([0, 1.0, 0])
        plane = rectangle([0, 0, 0], u, v, (n, n), kind, 0.5)
        sky = sf.Environment(image)
        expected = 3 * np.pi * (1 + np.cos(b)) / 2
        return Problem(sf.Scene([plane], [sky]), [Wanted(ALL, expected)], quality=knobs(16 * n * n))

    return build


def canyon(n):
    """Width and height 1, black walls, a sky of radiance 1; the middle of a canyon 40 long, with nothing at its ends.

    What stands at the ends instead of walls is 1 / 20 high seen from the middle: it adds 1 / (pi 20^2) at most.
    """
    at = [-20.0, -5.0, *np.linspace(-0.5, 0.5, 4), 5.0, 20.0]
    along, across, up = [0, 1, 0], np.array([1.0, 0, 0]), np.array([0, 0, 1.0])
    base = strips([1, 0, 0], along, at, -across, n)  # along x across: up
    left = strips([0, 0, 0], along, at, up, n)
    right = strips([1, 0, 1], along, at, -up, n)
    k = len(base)

    def sky(points, normals):
        x, z = points[:, 0], points[:, 2]
        of_floor = 0.5 * (x / np.hypot(x, 1) + (1 - x) / np.hypot(1 - x, 1))
        # From a wall, the opening begins at the wall's own rim, straight above, and ends at the other one.
        of_wall = 0.5 * (1 - (1 - z) / np.hypot(1, 1 - z))
        return np.pi * np.where(normals[:, 2] > 0.5, of_floor, of_wall)

    wanted = [Wanted(slice(first + 2 * n, first + 5 * n), sky) for first in (0, k, 2 * k)]
    return Problem(sf.Scene([base, left, right], [sf.Environment(1.0)]), wanted, 1 / n, knobs(16 * n * n))


def one_bounce(kind):
    """A floor of rho = .8 under the sun straight above, which a black wall at its side sees."""

    def build(n):
        ground = rectangle([0, 0, 0], [1, 0, 0], [0, 1, 0], (n, n), kind, 0.8)
        wall = rectangle([0, 0, 0.05], [0, 1, 0], [0, 0, 1], (n, n), kind)
        corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)

        def bounced(points, normals):
            return 0.8 * 5.0 * closed_forms.element_to_polygon(points, normals, corners)

        wanted = [Wanted(slice(n * n, None), bounced)]
        scene = sf.Scene([ground, wall], [sf.DirectionalLight([0, 0, -1], 5.0)])
        return Problem(scene, wanted, quality=knobs(16 * n * n if kind == "patches" else 256))

    return build


POINT = {"position": [0.2, -0.3, 0.8], "intensity": 3.0}
SPOT = {"position": [0.2, -0.3, 1.0], "direction": [-0.2, 0.3, -1.0], "intensity": 3.0, "cone": 60.0, "penumbra": 25.0}
SUN = {"direction": [0.3, 0.2, -0.6], "irradiance": 4.0}
LAMP = {"corner": [-0.4, -0.2, 0.5], "edge_u": [0, 0.6, 0], "edge_v": [0.9, 0, 0], "exitance": 2.0}
LAMP_CORNERS = np.array([[-0.4, -0.2, 0.5], [-0.4, 0.4, 0.5], [0.5, 0.4, 0.5], [0.5, -0.2, 0.5]])


def of_point(points, normals):
    return closed_forms.point_light(points, normals, **POINT)


def of_spot(points, normals):
    return closed_forms.spot_light(points, normals, **SPOT)


def of_lamp(points, normals):
    return 2.0 * closed_forms.element_to_polygon(points, normals, LAMP_CORNERS)


def of_sun(points, normals):
    return np.full(len(points), 4.0 * 0.6 / 0.7)


def lights(kind, order_and_tolerance):
    """The four lights over a floor of patches or points."""
    which = {
        "point light": (sf.PointLight(**POINT), of_point),
        "spot light": (sf.SpotLight(**SPOT), of_spot),
        "sun": (sf.DirectionalLight(**SUN), of_sun),
        "area light": (sf.AreaLight(**LAMP), of_lamp),
    }
    for name, (derivation, *numbers) in order_and_tolerance.items():
        exact = {} if len(numbers) > 1 else {"floor": ROUNDING}
        # Points so close that all lights are wide over their disks, which share the power of what is narrow.
        densities = (20, 30, 40) if kind == "points" else (5, 10, 20)
        yield Case(f"{name}, {kind}", under_light(kind, *which[name]), densities, derivation, *numbers, **exact)


ROUNDING = "a closed form of the light's own, with nothing in its way: rounding alone is left"
CONVEX = "Half of the sky stands over every point of a convex surface: H = pi L. "
OWN_DISKS = "what leaves a point meets none of the disks around it, or so few that rays do not find them"
HALF = "Tilted by b, a plane without ground sees (1 + cos b) / 2 of the upper half, which gives pi L. "
SKY_CELLS = "cells of the sky that the horizon crosses have a mean cosine that is off by some 1e-4"
UNIFORM_SKY = "Rows of patches tell what escapes, better than any rays, and a sky of one radiance goes with that. "
CANYON = (
    "From the floor the opening has the factor (sin a + sin b) / 2, a and b the angles to both rims, .447214 in the "
    "middle; from a wall (1 - sin c) / 2. The mean over the floor is sqrt(2) - 1 (DESIGN section 7). "
)
FLOATS = "the exchange of patches is exact to some 1e-7 and kept in float"
BOUNCE = "What the floor sends back is rho D; Lambert's polygon from every point of the wall. "
POINT_LIGHT = "I cos / r^2; over a patch, I times its solid angle over its area. "
SPOT_LIGHT = "I cos / r^2 times smoothstep of the angle between (cone - penumbra) / 2 and cone / 2. "
SPOT_KINKS = (
    "Over a patch by 8 x 8 Gauss points, which find the two kinks of smoothstep to order 2; solvers are exact. "
)
AREA_LIGHT = "M times Lambert's polygon. "
GAUSS = "Over a patch, the mean by 4 x 4 Gauss points: order 8. "

CASES = [
    *(
        Case(
            f"convex cloud under the sky, {name}",
            convex_cloud(name),
            (100, 300, 900),
            CONVEX,
            tolerance,
            floor=OWN_DISKS,
        )
        for name, tolerance in (("sphere", 1e-12), ("ellipsoid", 2.5e-4), ("random", 1e-12))
    ),
    Case(
        "two scans of a sphere under the sky",
        scanned_twice,
        (100, 300, 900),
        CONVEX + "Two clouds of one surface hide nothing of each other. ",
        1e-12,
        floor=OWN_DISKS,
    ),
    Case("carpet in a floor, area light", carpeted, (5, 10, 20), AREA_LIGHT + GAUSS, 5e-11, 5.0),
    Case("half sky, patches", half_sky("patches", 0.0), (4, 8, 16), HALF, 1e-4, floor=SKY_CELLS),
    Case("half sky, points", half_sky("points", 0.0), (4, 8, 16), HALF, 1e-4, floor=SKY_CELLS),
    Case("half sky on a slope, patches", half_sky("patches", 60.0), (4, 8, 16), HALF, 5e-4, floor=SKY_CELLS),
    Case("half sky on a slope, points", half_sky("points", 60.0), (4, 8, 16), HALF, 5e-4, floor=SKY_CELLS),
    Case("half sky over a ledge, patches", half_sky("patches", 120.0), (4, 8, 16), HALF, 2e-3, floor=SKY_CELLS),
    Case("canyon", canyon, (4, 8, 16), CANYON + UNIFORM_SKY, 3e-4, floor="what its ends lack is left", off=2e-3),
    *lights(
        "patches",
        {
            "point light": (POINT_LIGHT, 1e-12),
            "spot light": (SPOT_LIGHT + SPOT_KINKS, 1.1e-5, 2.0),
            "sun": ("E cos. ", 1e-12),
            "area light": (AREA_LIGHT + GAUSS, 5e-11, 5.0),
        },
    ),
    *lights(
        "points",
        {
            "point light": (POINT_LIGHT, 1e-12),
            "spot light": (SPOT_LIGHT, 1e-12),
            "sun": ("E cos. ", 1e-12),
            "area light": (AREA_LIGHT, 1e-12),
        },
    ),
    Case("one bounce, patches", one_bounce("patches"), (4, 8, 16), BOUNCE, 6e-6, floor=FLOATS),
    Case(
        "one bounce, points",
        one_bounce("points"),
        (6, 11, 20),
        BOUNCE + "Areas and rims of clouds are found to order 1. ",
        2e-2,
        0.8,
        off=None,
    ),
]
