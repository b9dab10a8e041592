"""Points of a file that a command reads, and writes with what it found."""

import numpy as np

from surflux.points.ply_arrays import left_of_solution
from surflux.points.reading import warn_of_faces
from surflux.points.scan import read_scan_with_faces
from surflux.solutions.lit_points import spread


class Points:
    """Points of a file: their Surfels, and these written beside all that the file says of them."""

    def __init__(self, options):
        self._scan, faces = read_scan_with_faces(options.input, points=options.points, progress=True)
        warn_of_faces(options.input, faces)
        none = left_of_solution(self._scan.attributes)  # as `read` leaves them out
        self._rows = np.arange(len(self._scan)) if none is None else np.flatnonzero(~none)
        self.surfels = self._scan[self._rows].surfels(viewpoint=options.viewpoint, progress=True)

    def save(self, path, surfels):
        """All points in their order, with normals, radii and, where they are known, areas; NaN of those that are none.

        surfels: the points', or the same turned round.
        """
        at = self._rows, len(self._scan)
        columns = {"radius": surfels.radii, "area": surfels.areas}
        columns = {name: spread(of, *at, np.float64) for name, of in columns.items() if of is not None}
        self._scan.save(path, columns, normals=spread(surfels.normals, *at))
