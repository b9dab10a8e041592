"""Small files of points in the formats of scanners, for tests."""

import struct

import numpy as np

KINDS = {"f": "F", "u": "U", "i": "I"}


def table(n, seed=0, kind="f4"):
    """A structured table of n random points with colours, normals, intensity and labels."""
    random = np.random.default_rng(seed)
    names = [(axis, kind) for axis in "xyz"] + [("rgb", "f4")]
    names += [(f"normal_{axis}", "f4") for axis in "xyz"] + [("intensity", "f4"), ("label", "u4")]
    rows = np.zeros(n, dtype=names)
    for axis in "xyz":
        rows[axis] = random.uniform(-1.0, 1.0, n)
    rows["rgb"] = packed(random.integers(0, 256, (n, 3)))
    rows["normal_z"] = 1.0
    rows["intensity"] = random.uniform(0.0, 1.0, n)
    rows["label"] = np.arange(n)
    return rows


def packed(colors):
    """Colours (n, 3) of 8 bits as the floats of PCL."""
    red, green, blue = np.asarray(colors, dtype=np.uint32).T
    return (red << 16 | green << 8 | blue).view(np.float32)


def pcd(path, rows, data="binary", viewpoint="0 0 0 1 0 0 0", size=None, **lines):
    """A PCD file of a structured table; `lines` stand in place of lines of the header."""
    names = rows.dtype.names
    width, height = size or (len(rows), 1)
    header = {
        "VERSION": "0.7",
        "FIELDS": " ".join(names),
        "SIZE": " ".join(str(rows.dtype[name].base.itemsize) for name in names),
        "TYPE": " ".join(KINDS[rows.dtype[name].base.kind] for name in names),
        "COUNT": " ".join("1" for _ in names),
        "WIDTH": width,
        "HEIGHT": height,
        "VIEWPOINT": viewpoint,
        "POINTS": len(rows),
        "DATA": data,
        **lines,
    }
    text = "# .PCD v0.7 - Point Cloud Data file format\n"
    text += "".join(f"{key} {value}\n" for key, value in header.items() if value is not None)
    if data == "ascii":
        body = "\n".join(" ".join(repr(value.item()) for value in row) for row in rows).encode() + b"\n"
    elif data == "binary_compressed":
        plain = b"".join(np.ascontiguousarray(rows[name]).tobytes() for name in names)
        squeezed = lzf(plain)
        body = struct.pack("<II", len(squeezed), len(plain)) + squeezed
    else:
        body = rows.tobytes()
    path.write_bytes(text.encode() + body)
    return path


def lzf(data):
    """LZF of some bytes, found by the last place of each three of them: slow, and enough for tests."""
    out, plain, seen, at = bytearray(), bytearray(), {}, 0

    def flush():
        for begin in range(0, len(plain), 32):
            piece = plain[begin : begin + 32]
            out.append(len(piece) - 1)
            out.extend(piece)
        plain.clear()

    while at < len(data):
        key = data[at : at + 3]
        before = seen.get(key)
        seen[key] = at
        length = 0
        if len(key) == 3 and before is not None and at - before <= 8192:
            while length < 264 and at + length < len(data) and data[before + length] == data[at + length]:
                length += 1
        if length < 3:
            plain.append(data[at])
            at += 1
            continue
        flush()
        offset, length = at - before - 1, length - 2
        out.append(min(length, 7) << 5 | offset >> 8)
        if length >= 7:
            out.append(length - 7)
        out.append(offset & 255)
        at += length + 2
    flush()
    return bytes(out)


def las(path, n=40, seed=0, point_format=7, colors=65535, offset=(6e5, 4e6, 0.0), extra=()):
    """A LAS or LAZ file by laspy, by the suffix of the path; (points, laspy's record)."""
    import laspy

    random = np.random.default_rng(seed)
    header = laspy.LasHeader(point_format=point_format, version="1.4")
    header.scales, header.offsets = [0.001] * 3, list(offset)
    for name in extra:
        header.add_extra_dim(laspy.ExtraBytesParams(name=name, type=np.float32))
    data = laspy.LasData(header)
    points = np.round(random.uniform(0.0, 100.0, (n, 3)), 3) + offset
    data.x, data.y, data.z = points.T
    data.intensity = random.integers(0, 5000, n).astype(np.uint16)
    data.classification = (np.arange(n) % 7).astype(np.uint8)
    data.return_number = (1 + np.arange(n) % 3).astype(np.uint8)
    data.number_of_returns = np.full(n, 3, dtype=np.uint8)
    data.point_source_id = np.full(n, 12, dtype=np.uint16)
    if "gps_time" in header.point_format.dimension_names:
        data.gps_time = 1e9 + np.arange(n) / 7.0
    if "red" in header.point_format.dimension_names:
        for name in ("red", "green", "blue"):
            data[name] = random.integers(0, colors + 1, n).astype(np.uint16)
        data.red[0] = colors
    for name in extra:
        data[name] = random.uniform(-1.0, 1.0, n).astype(np.float32)
    data.write(str(path))
    return points, data
