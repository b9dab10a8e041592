"""LAS files that say where on earth they lie."""

import numpy as np


def las_in(path, system=None, points=((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)), keys=None):
    """A LAS file in a system of pyproj, or with GeoTIFF keys {number: value}."""
    import laspy
    import pyproj

    header = laspy.LasHeader(point_format=6 if keys is None else 3, version="1.4" if keys is None else "1.2")
    points = np.asarray(points)
    header.scales, header.offsets = [1e-3] * 3, points[0].round()
    if keys is not None:
        rows = [(1, 1, 0, len(keys)), *((key, 0, 1, value) for key, value in sorted(keys.items()))]
        header.vlrs.append(laspy.VLR("LASF_Projection", 34735, "", np.array(rows, np.uint16).tobytes()))
    elif system is not None:
        header.add_crs(pyproj.CRS(system))
    data = laspy.LasData(header)
    data.x, data.y, data.z = points.T
    data.write(path)
    return path
