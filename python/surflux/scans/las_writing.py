"""LAS and LAZ, written by laspy: the extra surflux[scans]."""

import os
from pathlib import Path

import numpy as np

from surflux._base.files import file_error, unfinished_name
from surflux.scans.outside import outside

_ANGLE_STEP = 0.006  # degrees
_OWN = ("classification", "intensity", "return_number", "number_of_returns", "point_source_id", "gps_time", "nir")
_FINE = 1e-4  # of the spacing of points: steps of coordinates of what was no LAS file


def write_las(path, columns, frame=None):
    """Attributes of LAS under their names, all others as extra dimensions. Colours have 16 bits.

    Coordinates have the steps of the LAS file that they come from, so that they come back bit by bit; others are
    rounded to 1e-4 of their spacing or finer. The file's coordinate reference system is kept, which formats of points
    up to 5 say by keys of GeoTIFF and later ones by WKT: so points keep the generation of their format, too.
    """
    with outside(path, "laspy"):
        import laspy

        points = columns["points"]
        frame = _frame_of(points) if frame is None else frame
        kind = 3 if frame["point_format"] < 6 else 8 if "nir" in columns else 7
        header = laspy.LasHeader(version=frame["version"] if kind == 3 else "1.4", point_format=kind)
        header.offsets, header.scales = frame["offsets"], frame["scales"]
        header.vlrs.extend(frame["reference"])
        header.global_encoding.wkt = frame["wkt"]
        header.global_encoding.gps_time_type = frame["gps_time_type"]
        extra = {}
        for name, values in columns.items():
            if name in ("points", "colors", "scan_angle", *_OWN):
                continue
            extra |= _dimensions(name, values)
        header.add_extra_dims([laspy.ExtraBytesParams(name, values.dtype) for name, values in extra.items()])
        record = laspy.LasData(header)
        whole = [_whole(path, points[:, k], header.offsets[k], header.scales[k]) for k in range(3)]
        record.points = laspy.ScaleAwarePointRecord.zeros(len(points), header=header)
        record.X, record.Y, record.Z = whole
        for name in _OWN:
            if name in columns:
                record[name] = _fitting(path, name, columns[name], record[name].dtype)
        if "scan_angle" in columns:
            name, step, room = ("scan_angle", _ANGLE_STEP, np.int16) if kind > 5 else ("scan_angle_rank", 1.0, np.int8)
            steps = np.rint(np.asarray(columns["scan_angle"], np.float64) / step)
            record[name] = _fitting(path, "scan_angle", steps, np.dtype(room))
        if "colors" in columns:
            for k, name in enumerate(("red", "green", "blue")):
                record[name] = columns["colors"][:, k].astype(np.uint16) * 257
        for name, values in extra.items():
            record[name] = values
        real = Path(os.path.realpath(path))
        beside = real.with_name(unfinished_name(real))
        try:
            record.write(beside)
            os.replace(beside, real)
        finally:
            beside.unlink(missing_ok=True)


def frame_of(header):
    """What write_las takes over from the header of laspy."""
    return {
        "offsets": np.array(header.offsets),
        "scales": np.array(header.scales),
        "point_format": header.point_format.id,
        "version": str(header.version),
        "reference": [vlr for vlr in header.vlrs if vlr.user_id == "LASF_Projection"],
        "wkt": header.global_encoding.wkt,
        "gps_time_type": header.global_encoding.gps_time_type,
    }


def _frame_of(points):
    """The same of points that come from elsewhere: coordinates in powers of ten that 32 bits hold."""
    low, high = points.min(axis=0), points.max(axis=0)
    size = float(np.max(high - low)) or 1.0
    wanted = _FINE * size / np.sqrt(len(points))
    scale = 10.0 ** np.floor(np.log10(max(wanted, size / 2.0**31)))
    if size / scale > 2.0**31 - 1:
        scale *= 10.0
    found = {"offsets": np.floor(low), "scales": np.full(3, scale), "point_format": 7, "version": "1.4"}
    return found | {"reference": [], "wkt": True, "gps_time_type": 0}


def _whole(path, values, offset, scale):
    steps = np.rint((values - offset) / scale)
    if len(steps) and (steps.min() < -(2**31) or steps.max() >= 2**31):
        raise file_error(path, "its coordinates do not fit the 32 bits that LAS has for them")
    return steps.astype(np.int32)


def _fitting(path, name, values, dtype):
    """values as LAS holds them, where it does."""
    values = np.asarray(values)
    if dtype.kind == "f":
        return values.astype(dtype)
    limits = np.iinfo(dtype)
    with np.errstate(invalid="ignore"):
        fits = (values >= limits.min) & (values <= limits.max)
    if not np.all(fits):
        worst = values[~fits][0]
        raise file_error(path, f"{name}: LAS has room from {limits.min} to {limits.max}, got {worst:g}")
    return np.rint(values).astype(dtype) if values.dtype.kind == "f" else values.astype(dtype)


def _dimensions(name, values):
    """Extra dimensions of an attribute, whose names have up to 32 bytes."""
    values = values.astype(np.uint8) if values.dtype == bool else values
    if values.ndim == 2:
        channels = {"normals": ("nx", "ny", "nz")}.get(name)
        wide = values.shape[1]
        channels = channels or [f"{name[:28]}_{c}" for c in ("rgb" if wide == 3 else range(wide))]
        return {one: np.ascontiguousarray(values[:, k], np.float32) for k, one in enumerate(channels)}
    return {str(name)[:32]: np.ascontiguousarray(values)}
