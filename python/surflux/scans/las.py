"""LAS and LAZ, COPC among them, by laspy: the extra surflux[scans]."""

import os

import numpy as np

from surflux._base.files import file_error
from surflux.scans.columns import CHUNK, FLAGS, PointFile, sorted_out
from surflux.scans.las_writing import IN_PLACE_OF, frame_of
from surflux.scans.laz import backends
from surflux.scans.outside import outside

_ATTRIBUTES = ("intensity", "classification", "return_number", "number_of_returns", "point_source_id", "gps_time")
_ANGLE_STEP = 0.006  # degrees, of formats from 6 on


def open_las(path):
    """A PointFile.

    Scale and offset are applied in float64. Attributes: intensity, classification, return_number, number_of_returns,
    point_source_id, gps_time, nir, scan_angle in degrees, FLAGS, and the extra dimensions of the file by their names;
    those that write_las wrote in place of a field, by the name of the field, which is left out.
    """
    _check_records(path)
    with outside(path, "laspy"):
        import laspy

        reader = laspy.open(path, laz_backend=backends())
        header = reader.header
        if header.are_points_compressed and not backends():
            reader.close()
            raise ImportError("LAZ without a backend", name="lazrs")
    return PointFile(header.point_count, _chunks(path, reader), frame=frame_of(header))


def las_header(path):
    """The header of laspy, for whoever wants no points of it yet."""
    _check_records(path)
    with outside(path, "laspy"):
        import laspy

        with laspy.open(path, laz_backend=backends()) as reader:
            return reader.header


def _check_records(path):
    """Refuses a header with more records than the file has room for: laspy would go through all of them."""
    size = os.path.getsize(path)
    with open(path, "rb") as file:
        head = file.read(247)
    for at, least in ((100, 54), (243, 60)):  # of variable length records, and of extended ones
        if len(head) < at + 4 or (at > 200 and head[25] < 4):  # LAS 1.4 has these
            continue
        records = int.from_bytes(head[at : at + 4], "little")
        if records * least > size:
            raise file_error(path, f"the header promises {records} records of {least} bytes or more", f"byte {at}")


def _chunks(path, reader):
    header = reader.header
    there = set(header.point_format.dimension_names)
    extra = tuple(header.point_format.extra_dimension_names)
    instead = _in_place_of_fields(header)
    count = 0
    with reader:
        while count < header.point_count:
            with outside(path, "laspy"):
                record = reader.read_points(min(CHUNK, header.point_count - count))
                columns = {axis: np.asarray(record[axis], dtype=np.float64) for axis in "xyz"}
                for name in (*_ATTRIBUTES, "nir", *FLAGS, *extra):
                    if name in there and name not in instead:
                        columns[name] = np.array(record[name])
                if "scan_angle" in there:
                    columns["scan_angle"] = np.float32(_ANGLE_STEP) * np.asarray(record["scan_angle"], np.float32)
                elif "scan_angle_rank" in there:
                    columns["scan_angle"] = np.array(record["scan_angle_rank"], dtype=np.float32)
                for name, field in instead.items():
                    columns[field] = np.array(record[name])
                if {"red", "green", "blue"} <= there:
                    columns |= {name: np.array(record[name]) for name in ("red", "green", "blue")}
            if len(record) == 0:
                break
            count += len(record)
            yield sorted_out(columns)
    if count < header.point_count:
        raise file_error(path, f"truncated: the header promises {header.point_count} points, and {count} are there")


def _in_place_of_fields(header):
    """{name of an extra dimension: name of the field that it stands for}, as write_las describes them."""
    fields = {*_ATTRIBUTES, "nir", *FLAGS, "scan_angle"}
    told = {one.name: one.description for one in header.point_format.extra_dimensions}
    found = {name: text.removeprefix(IN_PLACE_OF) for name, text in told.items() if text.startswith(IN_PLACE_OF)}
    return {name: field for name, field in found.items() if field in fields}
