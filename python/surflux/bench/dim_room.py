"""A dim room beside a bright one, and errors by local light: what an eye sees in it that has grown used to the dark."""

import numpy as np

import surflux as sf
from surflux.scenes import shapes

WALL, DOOR, HEIGHT = 0.1, 0.04, 2.4  # m
SIDES = (-3.0, 3.0 + WALL), (0.0, 3.6)
OPENING, LINTEL = (1.5, 2.4), 2.0
GAP = 0.03


def door_ajar(density=1.0):
    """Two rooms of 3 x 3.6 x 2.4 m with a door between them that stands 3 cm open, and a lamp in one of them.

    The lamp does not shine through the gap. The other room, beyond x = WALL, has a table with three balls on it. Floor
    and ceiling go on beneath and above the wall. Surfels are patches of about (10 cm / density)^2, and points.
    """
    patch = 0.01 / density**2
    (x0, x1), (y0, y1) = SIDES

    def box(low, high, rho, patch_area=patch, inward=False, turn=None):
        vertices, faces, _ = shapes.box(np.subtract(high, low), inward=inward)
        vertices = vertices + (np.add(low, high) / 2 - (vertices.min(axis=0) + vertices.max(axis=0)) / 2)
        return sf.Surfels.from_mesh((vertices if turn is None else turn(vertices), faces), patch_area, rho)

    def ajar(vertices):
        hinge, angle = np.array([WALL, OPENING[0], 0.0]), np.arcsin(GAP / (OPENING[1] - OPENING[0]))
        c, s = np.cos(angle), np.sin(angle)
        return hinge + (vertices - hinge) @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]).T

    walls = [
        box((0.0, y0, 0.0), (WALL, OPENING[0], HEIGHT), 0.8),
        box((0.0, OPENING[1], 0.0), (WALL, y1, HEIGHT), 0.8),
        box((0.0, OPENING[0], LINTEL), (WALL, OPENING[1], HEIGHT), 0.8),
    ]
    leaf = box((WALL, OPENING[0], 0.0), (WALL + DOOR, OPENING[1], LINTEL), [0.8, 0.75, 0.7], turn=ajar)
    table = [box((1.0, 1.3, 0.72), (1.8, 2.5, 0.76), [0.6, 0.45, 0.3], patch / 4)]
    for x in (1.02, 1.73):
        for y in (1.32, 2.43):
            table.append(box((x, y, 0.0), (x + 0.05, y + 0.05, 0.72), [0.6, 0.45, 0.3], patch / 4))
    balls = []
    for y, rho in ((1.6, [0.7, 0.7, 0.7]), (1.95, [0.7, 0.3, 0.2]), (2.25, [0.3, 0.5, 0.7])):
        unit = shapes.sphere(round(642 * density**2))
        balls.append(sf.Surfels(0.12 * unit.points + [1.4, y, 0.881], unit.normals, reflectance=rho))
    lamp = sf.AreaLight([-1.6, 2.9, HEIGHT - 0.01], [0.6, 0.0, 0.0], [0.0, -0.3, 0.0], 60.0)
    room = box((x0, y0, 0.0), (x1, y1, HEIGHT), 0.8, inward=True)
    objects = sf.divide_patches([room, *walls, leaf, *table, *balls])
    return sf.Scene(objects, [lamp], name="door ajar")
