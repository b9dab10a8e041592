"""Every solver that runs the cases. A new one joins by a line in SOLVERS."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

import surflux as sf


@dataclass(frozen=True)
class Solver:
    """Finds the irradiance H (n, 3) at scene.surfels.

    Attributes:
        run: callable (scene, **quality) -> H.
        factors: True where it is a matrix of form factors, and runs only what is one row of it: scenes without lights
            in which nothing is reflected.
        own_error: a relative error that it makes by its own knobs, whatever the density: where a case asks for less,
            this is asked for, and no order where the errors are below.
        more_error: by the name of a case: where it is another.
    """

    run: Callable
    factors: bool = False
    own_error: float = 0.0
    more_error: dict = field(default_factory=dict)

    def __call__(self, scene, **quality):
        return self.run(scene, **quality)

    def error_of(self, case):
        return self.more_error.get(case.name, self.own_error)

    def takes(self, problem):
        return not self.factors or (not problem.scene.lights and not problem.scene.surfels.reflectance.any())


def at_surfels(solution, scene):
    """The field of a Solution at the scene's own surfels: the mean by area over what each was refined into."""
    n = len(scene.surfels)
    areas = solution.surfels.areas
    total = np.bincount(solution.parents, areas, n)
    sums = [np.bincount(solution.parents, areas * h, n) for h in solution.irradiance.T]
    return np.stack(sums, axis=1) / total[:, None]


def all_pairs(scene, **quality):
    return sf.solve(scene, tolerance=1e-7, transport="pairs", insert=False, **quality).irradiance


def by_rays(scene, rays):
    """The field of points at their places, of patches the mean over what they were refined into.

    Rays for what is found by chance are too few to gather by: as many as there are by default.
    """
    solution = sf.solve(scene, tolerance=1e-7, transport="rays", rays=max(256, rays))
    surfels = scene.surfels
    found = at_surfels(solution, scene)
    disks = np.setdiff1d(np.arange(len(surfels)), surfels.triangle_surfel)
    if len(disks):
        found[disks] = solution.irradiance_at(surfels.points[disks], surfels.normals[disks], "interpolated")
    return found


def meshless(scene, rays):
    """At the places of points, the means over patches, as its solution has it; no fewer rays than by default.

    Three levels: finer ones lower no error here that the rays of the coarser ones do not leave.
    """
    return sf.solve_meshless(scene, levels=3, tolerance=1e-7, rays=max(512, rays)).irradiance


def by_form_factors(scene, **quality):
    """H = F E: nothing is reflected."""
    return sf.form_factors(scene, **quality) @ scene.surfels.emission


# Errors that 256 rays leave, above the usual ones, at the last density; 1.3 times what was measured. A share f of a
# hemisphere is found with a relative error of up to sqrt((1 - f) / (256 f)).
BY_RAYS = {
    # Surfels that stand alone, and no neighbours whose rays would even it out: f = .02 to .2.
    "elements under a disk, patches": 0.085,
    "elements under a disk, points": 0.07,
    "elements under a square, patches": 0.15,
    "elements under a square, points": 0.2,
    "upright elements under a square, patches": 0.23,
    "upright elements under a square, points": 0.38,
    # A lamp hidden in part, f = .07 to .15: with 16 times the rays a quarter of it is left.
    "squares with one between, points": 0.07,
    # Black enclosures of which a part glows that is too large to aim at.
    "cylinder, patches, an end glows": 0.045,
    "cylinder, points, an end glows": 0.045,
    # Light that comes through an opening, in the dark half.
    "behind a slit": 0.05,
    "two long rooms": 0.08,
    # One bounce from a floor of few points to a wall on its edge.
    "one bounce, points": 0.035,
}

# Errors of 512 rays in a basis of three levels, above the usual ones; 1.3 times what was measured.
MESHLESS = {
    # A black enclosure of few points of which a part glows, as by rays.
    "cylinder, points, an end glows": 0.038,
    # A lamp hidden in part.
    "squares with one between, points": 0.04,
    # Light that comes through an opening, in the dark half.
    "two long rooms": 0.11,
    "behind a slit": 0.05,
}

SOLVERS = {
    "solve": Solver(all_pairs),
    "solve by rays": Solver(by_rays, own_error=0.03, more_error=BY_RAYS),
    "solve_meshless": Solver(meshless, own_error=0.03, more_error=MESHLESS),
    "form_factors": Solver(by_form_factors, factors=True),
}
