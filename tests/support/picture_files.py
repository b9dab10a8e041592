"""EXR and HDR files as other programs write them, without OpenImageIO."""

import struct

import numpy as np


def write_exr(path, channels, window=None, display=None):
    """Uncompressed lines of floats.

    channels: (h, w) by name. window, display: first and last column and row, as (left, top, right, bottom), of the
    pixels that the file holds, and of those that are shown.
    """
    names = sorted(channels)
    height, width = channels[names[0]].shape
    window = window or (0, 0, width - 1, height - 1)

    def attribute(name, kind, data):
        return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(data)) + data

    listed = b"".join(name.encode() + b"\0" + struct.pack("<iBBBBii", 2, 0, 0, 0, 0, 1, 1) for name in names) + b"\0"
    head = struct.pack("<ii", 20000630, 2)
    head += attribute("channels", "chlist", listed) + attribute("compression", "compression", b"\0")
    head += attribute("dataWindow", "box2i", struct.pack("<4i", *window))
    head += attribute("displayWindow", "box2i", struct.pack("<4i", *(display or window)))
    head += attribute("lineOrder", "lineOrder", b"\0") + attribute("pixelAspectRatio", "float", struct.pack("<f", 1))
    head += attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0))
    head += attribute("screenWindowWidth", "float", struct.pack("<f", 1)) + b"\0"
    lines = []
    for y in range(height):
        data = b"".join(channels[name][y].astype("<f4").tobytes() for name in names)
        lines.append(struct.pack("<ii", window[1] + y, len(data)) + data)
    begins = len(head) + 8 * height + np.cumsum([0] + [len(line) for line in lines[:-1]])
    path.write_bytes(head + struct.pack(f"<{height}Q", *begins) + b"".join(lines))
    return path


def write_hdr(path, pixels, said="", axes="-Y {h} +X {w}"):
    """Flat RGBE of pixels (h, w, 3), as they stand in the file. said: more lines of the header."""
    largest = pixels.max(axis=2)
    mantissa, exponent = np.frexp(largest)
    scale = np.where(largest > 0, mantissa * 256.0 / np.where(largest > 0, largest, 1.0), 0.0)
    rgbe = np.concatenate([pixels * scale[..., None], np.where(largest > 0, exponent + 128, 0)[..., None]], axis=2)
    size = axes.format(h=len(pixels), w=len(pixels[0]))
    head = f"#?RADIANCE\n{said}FORMAT=32-bit_rle_rgbe\n\n{size}\n"
    path.write_bytes(head.encode("latin-1") + rgbe.astype(np.uint8).tobytes())
    return path
