"""`surflux bench`: view factors of a closed cube of 864 faces beside the peer pyviewfactor, in one run."""

import importlib.util
from time import perf_counter

import numpy as np

import surflux as sf
from surflux.scenes import shapes

NAME = "view factors beside pyviewfactor"
CELLS = 12  # along each edge
# Howell, A Catalog of Radiation Heat Transfer Configuration Factors, C-11: opposite faces of a cube.
OPPOSITE = 2.0 / np.pi * (0.5 * np.log(4.0 / 3.0) + 2.0 * np.sqrt(2.0) * np.arctan(np.sqrt(0.5)) - np.pi / 2.0)


def why_not():
    """Why the case cannot run here, or None."""
    return None if importlib.util.find_spec("pyviewfactor") else "needs pip install 'surflux[bench]'"


def beside_peer(threads):
    import pyviewfactor

    return cube_factors(threads, pyviewfactor)


def cube_factors(threads, peer):
    """(surfels, seconds, error, against, seconds by program); `peer`: a module of the face of pyviewfactor."""
    import pyvista

    vertices, faces, _ = shapes.box(patches=CELLS, inward=True)
    start = perf_counter()
    scene = sf.Scene([sf.Surfels.from_mesh((vertices, faces))])
    factors = sf.form_factors(scene, threads=threads)
    seconds = perf_counter() - start
    error, rows = errors_of(factors)
    against = f"between faces, largest; row sums {rows:.1e}"
    mesh = pyvista.PolyData(vertices, faces=np.insert(faces, 0, 4, axis=1).ravel())
    start = perf_counter()
    # Nothing stands in a cube, and so it is spared to look; its F[i, j] is from j to i.
    theirs = peer.compute_viewfactor_matrix(mesh, skip_obstruction=True).T
    stages = {"surflux": seconds, "pyviewfactor": perf_counter() - start}
    error_of_theirs, rows_of_theirs = errors_of(theirs)
    against += f"; pyviewfactor {error_of_theirs:.1e}, row sums {rows_of_theirs:.1e}"
    return len(factors), seconds, error, against, stages


def errors_of(factors):
    """Largest errors of the factors between whole faces, and of the sums of rows."""
    per_face = CELLS * CELLS
    faces = factors.reshape(6, per_face, 6, per_face).sum(axis=3).mean(axis=1)
    expected = np.where(np.kron(np.eye(3), np.ones((2, 2))) == 1.0, OPPOSITE, (1.0 - OPPOSITE) / 4.0)
    np.fill_diagonal(expected, 0.0)
    return np.abs(faces - expected).max(), np.abs(factors.sum(axis=1) - 1.0).max()
