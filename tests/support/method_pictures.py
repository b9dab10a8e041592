"""Pictures of the method for the guide: shares of a disk, the cut of a scene, where the light of a surfel comes from.

python tests/support/method_pictures.py data
"""

import sys
from pathlib import Path

import numpy as np
from matplotlib import pyplot

import surflux as sf


def shares(path):
    """Disks on a plane, and of one in the middle what it keeps of itself beside its neighbours."""
    rng = np.random.default_rng(3)
    grid = np.stack(np.meshgrid(np.arange(7.0), np.arange(7.0)), axis=-1).reshape(-1, 2)
    points = np.column_stack([grid + rng.uniform(-0.35, 0.35, grid.shape), np.zeros(len(grid))])
    s = sf.Surfels(points, normals=[[0, 0, 1]] * len(points))
    middle = int(np.linalg.norm(points[:, :2] - 3.0, axis=1).argmin())
    found = sf.area_shares(s, middle, resolution=256)
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(7.2, 3.4))
    for k, (point, radius) in enumerate(zip(points, s.radii, strict=True)):
        left.add_patch(pyplot.Circle(point[:2], radius, fill=k == middle, alpha=0.5, facecolor="tab:orange"))
        left.add_patch(pyplot.Circle(point[:2], radius, fill=False, linewidth=0.6, color="tab:blue"))
    left.plot(points[:, 0], points[:, 1], ".", color="black", markersize=4)
    left.set(xlim=(0.6, 5.4), ylim=(0.6, 5.4), aspect="equal", xticks=[], yticks=[])
    left.set_title("disks overlap", fontsize=10)
    image = right.imshow(found.shares[0], origin="lower", cmap="viridis", vmin=0, vmax=1)
    figure.colorbar(image, ax=right, label="share")
    right.set(xticks=[], yticks=[])
    disk = np.pi * s.radii[middle] ** 2
    right.set_title(f"its share: {found.area:.2f} of {disk:.2f}", fontsize=10)
    figure.tight_layout()
    figure.savefig(path, dpi=90)


def light(cut, picked):
    scene = sf.examples.three_spheres()
    solution = sf.solve(scene)
    sf.view(solution, color="cut", screenshot=cut, size=(520, 480), camera=scene.camera)
    place = np.linalg.norm(solution.surfels.points - [2.35, 1.2, 0.0], axis=1).argmin()
    sf.view(solution, pick=int(place), screenshot=picked, size=(760, 560), camera=scene.camera)
    print(f"{len(np.unique(solution.cut))} nodes for {len(solution.surfels)} surfels")


if __name__ == "__main__":
    folder = Path(sys.argv[1])
    shares(folder / "method_shares.png")
    light(folder / "method_cut.png", folder / "method_gathering.png")
