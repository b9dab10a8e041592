"""LAS and LAZ, written by laspy: the extra surflux[scans]."""

import numpy as np

from surflux._base.files import unfinished
from surflux._base.warn import warn
from surflux.scans.laz import backends
from surflux.scans.names import scalars
from surflux.scans.outside import outside

_ANGLE_STEP = 0.006  # degrees
# What a point has a field for: the largest number in it, of formats up to 5 and from 6 on; None where there is none.
_FIELDS = {
    "intensity": (65535, 65535),
    "classification": (31, 255),
    "return_number": (7, 15),
    "number_of_returns": (7, 15),
    "point_source_id": (65535, 65535),
    "user_data": (255, 255),
    "synthetic": (1, 1),
    "key_point": (1, 1),
    "withheld": (1, 1),
    "overlap": (None, 1),
    "scanner_channel": (None, 3),
    "scan_direction_flag": (1, 1),
    "edge_of_flight_line": (1, 1),
    "nir": (None, 65535),
}
_FINE = 1e-4  # of the spacing of points: steps of coordinates of what was no LAS file,
_SURVEYED = 1e-4  # or of this length, as surveys expect, where points are far apart
_COARSE = 0.05  # of the spacing: steps coarser than that are said
_NAME = 32  # bytes of an extra dimension's, and of its description
IN_PLACE_OF = "in place of "  # and the name of a field: description of what that field does not hold


def write_las(path, columns, frame=None):
    """Attributes of LAS under their names, all others as extra dimensions. Colours have 16 bits.

    Coordinates have the steps of the LAS file that they come from, so that they come back bit by bit; others are
    rounded to 1e-4, and to 1e-4 of their spacing, or finer, as far as 32 bits reach. The file's coordinate reference
    system is kept, which formats of points up to 5 say by keys of GeoTIFF and later ones by WKT: so points keep the
    generation of their format, too. What a field cannot hold, as fractions of an intensity, is an extra dimension of
    another name, and a warning says so; its description says which field it stands for, and open_las reads it under
    that name.
    """
    with outside(path, "laspy", "write"):
        import laspy

        points = columns["points"]
        frame = _frame_of(points, path) if frame is None else frame
        kind = 3 if frame["point_format"] < 6 else 8 if "nir" in columns else 7
        header = laspy.LasHeader(version=max(frame["version"], "1.2") if kind == 3 else "1.4", point_format=kind)
        header.offsets, header.scales = frame["offsets"], frame["scales"]
        header.vlrs.extend(frame["reference"])
        header.global_encoding.wkt = frame["wkt"]
        header.global_encoding.gps_time_type = frame["gps_time_type"]
        fields, others, moved = _sorted_out(path, columns, kind > 5)
        taken = {*header.point_format.dimension_names, "x", "y", "z"}
        extra = scalars(path, others, most=_NAME, taken=taken, told=moved)
        fields_of = {id(others[field]): IN_PLACE_OF + field for field in moved if others[field].ndim == 1}
        told = {name: fields_of.get(id(values), "") for name, values in extra.items()}
        extra = {name: np.ascontiguousarray(values, _kind(values)) for name, values in extra.items()}
        header.add_extra_dims(
            [laspy.ExtraBytesParams(name, values.dtype, told[name]) for name, values in extra.items()]
        )
        record = laspy.LasData(header)
        whole = [_whole(points[:, k], header.offsets[k], header.scales[k]) for k in range(3)]
        record.points = laspy.ScaleAwarePointRecord.zeros(len(points), header=header)
        record.X, record.Y, record.Z = whole
        for name, values in (fields | extra).items():
            record[name] = values
        if "colors" in columns:
            colors = columns["colors"]
            colors = colors.astype(np.uint16) * (257 if colors.dtype == np.uint8 else 1)
            record.red, record.green, record.blue = colors.T
        with unfinished(path) as beside:
            record.write(beside, laz_backend=backends())


def _sorted_out(path, columns, late):
    """(what fields of a point hold, by their names, all other columns, names of those that a field does not hold).

    late: of formats from 6 on. A warning says of which fields.
    """
    fields, others, moved = {}, {}, []
    for name, values in columns.items():
        if name in ("points", "colors"):
            continue
        if name == "gps_time" and values.ndim == 1:
            fields[name] = values.astype(np.float64)
            continue
        if name == "scan_angle" and values.ndim == 1:
            own, step, most = ("scan_angle", _ANGLE_STEP, 30000) if late else ("scan_angle_rank", 1.0, 90)
            steps = np.rint(values.astype(np.float64) / step)
            if np.all(np.abs(steps) <= most):  # NaN is not
                fields[own] = steps.astype(np.int16 if late else np.int8)
                continue
        most = _FIELDS.get(name, (None, None))[1 if late else 0]
        if most is not None and values.ndim == 1 and np.all((values >= 0) & (values <= most) & (values == values // 1)):
            fields[name] = values.astype(np.uint16)
            continue
        others[name] = values
        if most is not None or name == "scan_angle":
            moved.append(name)
    if moved:
        warn(f"{path}: LAS has no room for values of {', '.join(moved)}: they stand in extra dimensions")
    return fields, others, moved


def _kind(values):
    """The type of an extra dimension."""
    return {"b": np.uint8, "f": np.float32 if values.dtype.itemsize < 8 else np.float64}.get(
        values.dtype.kind, values.dtype
    )


def frame_of(header):
    """What write_las takes over from the header of laspy."""
    return {
        "offsets": np.array(header.offsets),
        "scales": np.array(header.scales),
        "point_format": header.point_format.id,
        "version": str(header.version),
        "reference": [vlr for vlr in (*header.vlrs, *(header.evlrs or ())) if vlr.user_id == "LASF_Projection"],
        "wkt": header.global_encoding.wkt,
        "gps_time_type": header.global_encoding.gps_time_type,
    }


def _frame_of(points, path):
    """The same of points that come from elsewhere: coordinates in a power of ten that says all of their spacing.

    It is 1e-4 at most: sparse points, such as the corners of a survey, are known no worse. Spacing is that of 98 % of
    them: strays far off do not make it coarser, as long as 32 bits hold all, else 1, 2 or 5 times as coarse as a power
    of ten.
    """
    low, high = points.min(axis=0), points.max(axis=0)
    size = float(np.max(high - low)) or 1.0
    most = float(np.max(np.ptp(np.percentile(points, [1, 99], axis=0), axis=0))) or size
    spacing = most / np.sqrt(len(points))
    scale, least = 10.0 ** np.floor(np.log10(min(_FINE * spacing, _SURVEYED))), size / (2.0**32 - 4)
    if scale < least:
        power = 10.0 ** np.floor(np.log10(least))
        scale = next(step * power for step in (1.0, 2.0, 5.0, 10.0) if step * power >= least)
    if scale > _COARSE * spacing:
        warn(
            f"{path}: coordinates are rounded to {scale:g}, for they reach over {size:.3g} and LAS has 32 bits for each"
        )
    offsets = scale * np.floor(0.5 * (low + high) / scale)
    found = {"offsets": offsets, "scales": np.full(3, scale), "point_format": 7, "version": "1.4"}
    return found | {"reference": [], "wkt": True, "gps_time_type": 0}


def _whole(values, offset, scale):
    steps = np.rint((values - offset) / scale)
    if len(steps) and (steps.min() < -(2**31) or steps.max() >= 2**31):
        raise ValueError("its coordinates do not fit the 32 bits that LAS has for them")
    return steps.astype(np.int32)
