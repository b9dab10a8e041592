"""Small scenes for tests, which cases are built from as well."""

from cases.builders import ball_inside, cloud_room, cube_inside, patch, rms, surfels_of

__all__ = ["ball_inside", "cloud_room", "cube_inside", "patch", "rms", "surfels_of"]
