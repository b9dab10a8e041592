"""What windows are drawn of: surfels as points, disks, and splats that run into each other; polygons; words."""

import numpy as np

from surflux import _core
from surflux.geometry.cores import disks_among

STYLES = ("disks", "splats", "points")
# Corners of a drawn disk; fewer where there are so many that nobody can see their outline.
_CORNERS, _FEW_CORNERS, _MANY = 16, 6, 100_000
_SLOPE = 0.4  # of the cones that stand for disks
_NEIGHBORS = 9
_SHEET = 4.0  # over the radius: splats so far off a surface that its inverse is are hardly of it


def disk_corners(count):
    """How many corners each of count disks is drawn with."""
    return _CORNERS if count <= _MANY else _FEW_CORNERS


def text_actor(text, size, place, *, side="left", top=False, fixed=False, grey=0.0):
    """Text at a place of what it is added to, in fractions of that.

    side: "left", "centered" or "right": which part of the text stands there. top: its upper end, else its lower.
    fixed: letters of one width.
    """
    import pyvista

    actor = pyvista.Text(text)
    look = actor.GetTextProperty()
    look.SetFontSize(size)
    look.SetColor(grey, grey, grey)
    look.SetBackgroundColor(1.0, 1.0, 1.0)
    look.SetBackgroundOpacity(0.8)
    look.SetFontFamilyToCourier() if fixed else look.SetFontFamilyToArial()
    look.SetVerticalJustificationToTop() if top else look.SetVerticalJustificationToBottom()
    {
        "left": look.SetJustificationToLeft,
        "centered": look.SetJustificationToCentered,
        "right": look.SetJustificationToRight,
    }[side]()
    where = actor.GetPositionCoordinate()
    where.SetCoordinateSystemToNormalizedViewport()
    where.SetValue(*place)
    return actor


def rings(centers, normals, radii, corners):
    """Points (n, corners, 3) around n centres, counterclockwise as seen against the normals."""
    helper = np.where(np.abs(normals[:, :1]) < 0.6, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
    u = np.cross(normals, helper)
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    v = np.cross(normals, u)
    angle = 2 * np.pi * np.arange(corners) / corners
    ring = np.cos(angle)[None, :, None] * u[:, None] + np.sin(angle)[None, :, None] * v[:, None]
    return centers[:, None] + radii[:, None, None] * ring


def polygons(corners):
    """pyvista.PolyData of n polygons with corners (n, k, 3)."""
    import pyvista

    return pyvista.PolyData(corners.reshape(-1, 3), faces=polygon_cells(*corners.shape[:2], 0))


def polygon_cells(count, corners, first):
    """VTK's list of `count` polygons with consecutive corners from `first` on."""
    corner = first + np.arange(count * corners).reshape(count, corners)
    return np.hstack([np.full((count, 1), corners), corner]).ravel()


def polylines(points):
    """pyvista.PolyData of n lines through points (n, k, 3)."""
    import pyvista

    n, k = points.shape[:2]
    cells = np.column_stack([np.full(n, k), np.arange(n * k).reshape(n, k)])
    return pyvista.PolyData(points.reshape(-1, 3), lines=cells.ravel())


def cones(tips, normals, radii, triangles):
    """pyvista.PolyData of disks as shallow cones whose tips stand where the disks do, then of triangles (t, 3, 3).

    Flat disks that overlap would hide each other at random; of cones each is seen where it is the nearest. A disk has
    disk_corners(n) cells, and one point more: its tip, then its rim.
    """
    import pyvista

    count, corners = len(tips), disk_corners(len(tips))
    rims = rings(tips, normals, radii, corners) - _SLOPE * (radii[:, None] * normals)[:, None]
    points = np.concatenate([tips[:, None], rims], axis=1).reshape(-1, 3)
    first = (corners + 1) * np.arange(count)[:, None]
    rim = np.arange(corners)[None, :]
    fans = np.stack(np.broadcast_arrays(first, first + 1 + rim, first + 1 + (rim + 1) % corners), axis=-1)
    flat = len(points) + np.arange(3 * len(triangles)).reshape(-1, 3)
    return pyvista.PolyData.from_regular_faces(
        np.concatenate([points, triangles.reshape(-1, 3)]), np.concatenate([fans.reshape(-1, 3), flat])
    )


class Shape:
    """A mesh that stands for surfels, and which of its parts show which surfel.

    "disks": shallow cones whose tips stand where the disks do: of disks that overlap each is seen where it is the
    nearest. "splats": the same, with every corner in the mean of the colours around it, weighed as the splats of a page
    are, by Gaussians of the distance, of those that face alike and are of one sheet. "points": one point each. Patches
    of meshes are drawn as their triangles; points have none.

    Args:
        s: Surfels.
        style: one of STYLES.
        origin: (3,) that the mesh is drawn around.
        radii, triangles: (n,) and (t, 3, 3), as they are drawn: without gaps where surfels were inserted.

    Attributes:
        mesh: pyvista.PolyData around the origin.
        by_point: whether colours belong to its points, not its cells.
    """

    def __init__(self, s, style, origin, radii, triangles):
        import pyvista

        centers = s.points - origin
        self.by_point = style != "disks"
        self._weights = self._neighbors = None
        if style == "points":
            self.mesh = pyvista.PolyData(centers)
            self._owner = np.arange(len(s))
            return
        disk = disks_among(s)
        corners = disk_corners(len(disk))
        tips, n, r = centers[disk], s.normals[disk], radii[disk]
        self.mesh = cones(tips, n, r, triangles - origin)
        of_points = np.concatenate([np.repeat(disk, corners + 1), np.repeat(s.triangle_surfel, 3)])
        self._owner = of_points if self.by_point else np.concatenate([np.repeat(disk, corners), s.triangle_surfel])
        if style == "splats":
            flat_rims = np.concatenate([tips[:, None], rings(tips, n, r, corners)], axis=1).reshape(-1, 3)
            self._weigh(s, centers, radii, np.concatenate([flat_rims, (triangles - origin).reshape(-1, 3)]), of_points)

    def spread(self, values):
        """Values (n,) or (n, k) of surfels as those of the mesh's points or cells."""
        if self._weights is None:
            return values[self._owner]
        out = np.zeros((len(self._owner), *values.shape[1:]))
        for k in range(self._weights.shape[1]):
            weight = self._weights[:, k]
            out += (weight if values.ndim == 1 else weight[:, None]) * values[self._neighbors[self._owner, k]]
        return out

    def _weigh(self, s, centers, radii, at, owner):
        self._neighbors = _core.nearest_points(centers, min(_NEIGHBORS, len(s)))
        self._weights = np.zeros((len(owner), self._neighbors.shape[1]), np.float32)
        normals, own = s.normals, np.arange(len(s))
        for k in range(self._neighbors.shape[1]):
            other = self._neighbors[:, k]
            fresh = (np.einsum("ij,ij->i", normals, normals[other]) > 0.5) & (other != own)  # short rows repeat it
            across = normals + normals[other]
            across /= np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-9)  # 0 of what faces away
            away = (at - centers[other][owner]) / radii[other][owner, None]
            off = _SHEET * np.einsum("ij,ij->i", away, across[owner])
            apart = np.einsum("ij,ij->i", away, away) + (off * off) ** 2
            weighs = np.ones(len(s), bool) if k == 0 else fresh
            self._weights[:, k] = np.where(weighs[owner], np.exp(-2.0 * np.minimum(apart, 36.0)), 0.0)
        self._weights /= self._weights.sum(axis=1, keepdims=True)
