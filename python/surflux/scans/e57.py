"""E57 by pye57, the extra surflux[scans]: scan by scan, each in its pose."""

import os

import numpy as np

from surflux._base.files import file_error
from surflux.scans.columns import PointFile
from surflux.scans.outside import outside

_STEP = 500_000  # points read at once
_CARTESIAN = ("cartesianX", "cartesianY", "cartesianZ")
_SPHERICAL = ("sphericalRange", "sphericalAzimuth", "sphericalElevation")
_RGB = ("colorRed", "colorGreen", "colorBlue")
_NORMAL = ("nor:normalX", "nor:normalY", "nor:normalZ")
_INVALID = ("cartesianInvalidState", "sphericalInvalidState")
_OTHERS = {"intensity": "intensity", "timeStamp": "time", "returnIndex": "return_number"}
_OTHERS |= {"returnCount": "number_of_returns"}


def open_e57(path):
    """A PointFile of all scans, in the frame of the file.

    Points that the scanner calls invalid are not finite here. Colours are fractions of what the limits of the scans
    say, where all have some. Attributes: intensity, time, return_number, number_of_returns and, of more than one scan,
    scan. The viewpoints are the positions of the scans' poses.
    """
    with outside(path, "pye57"):
        import pye57

        file = pye57.E57(os.fsdecode(path))
        try:
            headers = [file.get_header(k) for k in range(file.scan_count)]
            counts = [header.point_count for header in headers]
            fields = [set(header.point_fields) for header in headers]
        except BaseException:
            file.close()
            raise
    viewpoints = []
    return PointFile(sum(counts), _chunks(path, file, headers, fields, viewpoints), lambda: viewpoints)


def _chunks(path, file, headers, fields, viewpoints):
    wanted = (*_RGB, *_NORMAL, *_OTHERS)  # of which columns are made where all scans have them
    common = [name for name in wanted if all(name in there for there in fields)]
    whites = [_white(header) for header in headers]
    has_whites = all(white > 0.0 for white in whites)  # else the largest number of the file says what white is
    with file:
        for k, (header, there) in enumerate(zip(headers, fields, strict=True)):
            with outside(path, "pye57"):
                posed = header.has_pose()
                rotation, translation = (header.rotation_matrix, header.translation) if posed else (None, None)
            viewpoints.append(translation.tolist() if posed else None)
            places = next((names for names in (_CARTESIAN, _SPHERICAL) if set(names) <= there), None)
            if places is None:
                raise file_error(path, "its points have neither Cartesian nor spherical coordinates", f"scan {k}")
            read = (*places, *common, *(name for name in _INVALID if name in there))
            count = 0
            for columns in _read(path, file, header, read):
                count += len(columns[places[0]])
                chunk = {"points": _placed(columns, places, rotation, translation)}
                if set(_RGB) <= set(common):
                    colors = np.stack([columns[name] for name in _RGB], axis=-1)
                    chunk["colors"] = (np.clip(colors / whites[k], 0.0, 1.0) if has_whites else colors).astype(
                        np.float32
                    )
                if set(_NORMAL) <= set(common):
                    normals = np.stack([columns[name] for name in _NORMAL], axis=-1)
                    chunk["normals"] = normals if rotation is None else normals @ rotation.T
                for name in common:
                    if name in _OTHERS:
                        chunk[_OTHERS[name]] = columns[name].astype(np.float32 if name == "intensity" else np.float64)
                for name in ("return_number", "number_of_returns"):
                    if name in chunk:  # E57 counts returns from 0
                        chunk[name] = (chunk[name] + (name == "return_number")).astype(np.uint8)
                if len(headers) > 1:
                    chunk["scan"] = np.full(len(chunk["points"]), k, dtype=np.uint32)
                yield chunk
            if count < header.point_count:
                reason = f"truncated: {header.point_count} points are promised, and {count} are there"
                raise file_error(path, reason, f"scan {k}")


def _read(path, file, header, names):
    """Chunks of a scan's columns, float64."""
    with outside(path, "pye57"):
        from pye57 import libe57

        if header.point_count == 0:
            return
        columns = {name: np.zeros(min(_STEP, header.point_count)) for name in names}
        buffers = libe57.VectorSourceDestBuffer()
        for name, values in columns.items():
            buffers.append(libe57.SourceDestBuffer(file.image_file, name, values, len(values), True, True))
        reader = header.points.reader(buffers)
    while True:
        with outside(path, "pye57"):
            count = reader.read()
        if count == 0:
            break
        yield {name: values[:count].copy() for name, values in columns.items()}
    with outside(path, "pye57"):
        reader.close()


def _placed(columns, places, rotation, translation):
    points = np.stack([columns[name] for name in places], axis=-1)
    if places is _SPHERICAL:
        distance, azimuth, elevation = points.T
        flat = distance * np.cos(elevation)
        height = distance * np.sin(elevation)
        points = np.stack([flat * np.cos(azimuth), flat * np.sin(azimuth), height], axis=-1)
    for name in _INVALID:
        if name in columns:
            points[columns[name] != 0] = np.nan
    return points if rotation is None else points @ rotation.T + translation


def _white(header):
    """The colour that the limits of a scan call white; 0 where they say none."""
    try:
        white = float(max(header["colorLimits"][f"{name}Maximum"].value() for name in _RGB))
    except Exception:  # libe57's, of a node that is not there
        return 0.0
    return white if np.isfinite(white) and white > 0.0 else 0.0
