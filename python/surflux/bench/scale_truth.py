"""What `surflux bench --scale` measures against: path tracing that takes minutes, kept in a folder."""

import hashlib
import os
from pathlib import Path

import numpy as np

import surflux as sf
from surflux.bench.scenes import data_folder
from surflux.bench.truth import PointTruth, Truth, with_areas

MEASURED = 2000  # surfels, and as many points
DIRECT_PLACES = 128
SEED = 0


class ScaleTruth:
    """Irradiance at area-sampled surfels of a scene file and at random points of its surface.

    Attributes:
        surfels: Truth, as `truth` has it.
        points: PointTruth.
    """

    def __init__(self, stem, count=None, cache=None, threads=None, measured=MEASURED):
        """count: of surfels, as load_scene takes it. cache: folder to keep what has been traced in, or None."""
        path = data_folder() / f"{stem}.toml"
        digest = hashlib.sha256(path.read_bytes()).hexdigest()[:8]
        name = f"{stem}-{'whole' if count is None else count}-{digest}-seed{SEED}-{measured}.npz"
        self._file = None if cache is None else Path(cache) / name
        scene = sf.load_scene(path, surfels=count)
        surfels = with_areas(scene)
        self.place_of = surfels.points  # of all surfels, so that others can tell whether they have the same
        kept = {"surfels": None, "points": None}
        if self._file is not None and self._file.is_file():
            kept = _read(self._file, surfels.points)
        self.surfels = Truth(
            scene, surfels, measured, seed=SEED, direct_places=DIRECT_PLACES, threads=threads, state=kept["surfels"]
        )
        self.points = PointTruth(scene, surfels, measured, seed=SEED + 1, threads=threads, state=kept["points"])
        self._save()

    def refine(self):
        """One more round of paths for the surfels and for the points."""
        self.surfels.refine()
        self.points.refine()
        self._save()

    def _save(self):
        if self._file is None:
            return
        self._file.parent.mkdir(parents=True, exist_ok=True)
        beside = self._file.with_suffix(f".{os.getpid()}.npz")
        state = {
            f"{name}_{key}": value
            for name, truth in (("surfels", self.surfels), ("points", self.points))
            for key, value in truth.state.items()
        }
        np.savez(beside, all_points=_digest(self.place_of), **state)
        os.replace(beside, self._file)


def _read(path, points):
    """The states in a file; ValueError where it is of other surfels."""
    with np.load(path) as data:
        if str(data["all_points"]) != _digest(points):
            raise ValueError(f"--cache: {path} is of a scene with other surfels; remove it")
        return {
            name: {key: data[f"{name}_{key}"] for key in ("index", "sums", "rounds", "paths")}
            for name in ("surfels", "points")
        }


def _digest(points):
    """Of positions, as they are in float32: the last bits may differ between machines."""
    return hashlib.sha256(points.astype(np.float32).tobytes()).hexdigest()
