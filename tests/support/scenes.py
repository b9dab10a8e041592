"""Small scenes for tests, which cases are built from as well."""

import surflux as sf
from cases.builders import ball_inside, cloud_room, cube_inside, patch, rms, surfels_of

__all__ = ["ball_inside", "cloud_room", "cube_inside", "patch", "rms", "solve_own", "surfels_of"]


def solve_own(scene, **options):
    """Irradiance of the scene's own surfels by all pairs: what tests compare surfel by surfel, and to many digits."""
    return sf.solve(scene, transport="pairs", insert=False, **options)
