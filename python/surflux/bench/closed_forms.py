"""`surflux bench --site FOLDER --only closed_forms`: errors beside Solution.error where the light is known."""

import numpy as np

import surflux as sf
from surflux.bench.areas import percent
from surflux.scenes import shapes

SEEDS = 0, 1, 2
SOLVERS = {
    "`solve`, rays": lambda scene, seed: sf.solve(scene, transport="rays", insert=False, seed=seed),
    "`solve`, pairs": lambda scene, seed: sf.solve(scene, transport="pairs", insert=False, seed=seed),
    "`solve_meshless`": lambda scene, seed: sf.solve_meshless(scene, seed=seed),
}


def rows(threads=None):
    """For each of SCENES and SOLVERS the RMS error of H and the solver's own estimate, means over SEEDS."""
    found = []
    for scene, make in SCENES.items():
        problem, exact = make()
        for solver, solve in SOLVERS.items():
            solutions = [solve(problem, seed) for seed in SEEDS]
            row = {"scene": scene, "solver": solver, "surfels": len(exact)}
            row["error, %"] = percent(np.mean([relative_rms(s, exact[:, None]) for s in solutions]))
            found.append(row | {"its own estimate, %": percent(np.mean([s.error for s in solutions]))})
    return found


def relative_rms(solution, exact):
    weight = solution.surfels.areas[:, None]
    off = weight * (solution.irradiance - exact) ** 2
    return np.sqrt(off.sum() / (weight * exact**2 * np.ones(3)).sum())


def sphere(n=2000):
    """The inside of a sphere, of which a cap of half its radius glows: H = mean(E) / (1 - mean(rho)), E of a quarter of
    the area."""
    p = shapes.sphere(n).points
    emission = np.where(p[:, 2] > 0.5, 10.0, 0.0)
    return sf.Scene([sf.Surfels(p, -p, reflectance=0.5 + 0.4 * p[:, 0], emission=emission)]), np.full(n, 2.5 / 0.5)


def concentric(inner, outer):
    """A glowing black sphere of half the size in another, of which rho is .5: from the outer one a quarter of the light
    goes to the inner one, so that B = .5 (.25 + .75 B) there."""
    exact = np.repeat([0.2, 0.4], [len(inner), len(outer)])
    return sf.Scene([inner, outer]), exact


def of_points(n=500):
    inner, outer = shapes.sphere(n).points, shapes.sphere(4 * n).points
    glowing = sf.Surfels(0.5 * inner, inner, reflectance=0.0, emission=1.0)
    return concentric(glowing, sf.Surfels(outer, -outer, reflectance=0.5))


def of_triangles(level=3):
    vertices, faces = shapes.icosphere(level)
    faces = np.asarray(faces)
    glowing = sf.Surfels.from_mesh((0.5 * vertices, faces), reflectance=0.0, emission=1.0)
    return concentric(glowing, sf.Surfels.from_mesh((vertices, faces[:, ::-1]), reflectance=0.5))


SCENES = {
    "sphere from inside, points": sphere,
    "concentric spheres, points": of_points,
    "concentric spheres, triangles": of_triangles,
}
