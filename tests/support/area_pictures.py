"""Pictures of areas as surflux draws them, and where to look in them."""

import numpy as np

import surflux as sf
from surflux.drawing import sharing

# Of a picture of 800 x 600 the surfels take 496 x 528 pixels. Looking down, 132 of them make one unit at z = 0.
ABOVE = {"eye": (0, 0, 4), "target": (0, 0, 0), "up": (0, 1, 0), "fov": 2 * np.degrees(np.arctan(0.5))}
UNIT = 132
DARK, BRIGHT = [68, 1, 84], [253, 231, 37]  # the two ends of viridis
PICKED = list(sharing.PICKED)
BARS = [89, 128, 166]
DOWN = [0.0, 0, 1]


def read(path):
    from PIL import Image

    return np.asarray(Image.open(path).convert("RGB")).astype(int)


def picture(tmp_path, s, pick=None, *, view=ABOVE, **options):
    camera = None if view is None else sf.Camera(**view)
    return read(s.plot_areas(pick, screenshot=tmp_path / "a.png", camera=camera, **options))


def at(image, x, y):
    """The pixel where the point (x, y, 0) is seen."""
    return image[round(263.5 - UNIT * y), round(247.5 + UNIT * x)].tolist()


def is_color(image, rgb):
    return (np.abs(image - np.array(rgb)) <= 3).all(axis=-1)


def part(image, which):
    """The pixels of a part of the window while a disk is picked."""
    sides = {
        "main": (0, 528, 0, 496),
        "words": (0, 186, 496, 800),
        "own": (186, 360, 496, 648),
        "leaders": (186, 360, 648, 800),
        "histogram": (360, 600, 496, 800),
        "tall histogram": (240, 600, 496, 800),
    }[which]
    return image[sides[0] : sides[1], sides[2] : sides[3]]


def share_at(image, which, x, y):
    """The pixel of a picture of shares at (x, y), in units of half its side: 174 pixels show 3 of them."""
    return part(image, which)[round(87 - 0.1 * 58 - 58 * y), round(75.5 + 58 * x)].tolist()


def pair(**options):
    return sf.Surfels([[-1, 0, 0], [1, 0, 0]], [DOWN] * 2, radii=[0.5, 0.8], **options)


def grid(n=7, spacing=0.4, **options):
    x = spacing * (np.arange(n) - (n - 1) / 2)
    points = np.array([[a, b, 0] for b in x for a in x])
    return sf.Surfels(points, [DOWN] * len(points), radii=1.5 * spacing, **options)


def axis(image):
    """The columns between which a histogram stands: the line on its left, and where the line below it ends."""
    dark = image.max(axis=2) < 140
    return np.argmax(dark.sum(axis=0)), np.flatnonzero(dark[np.argmax(dark.sum(axis=1))])[-1]
