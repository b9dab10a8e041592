"""Pictures that are put together at every subpixel, and averaged over pixels then, band by band of rows."""

import numpy as np

from surflux import _core
from surflux._base.passes import report

SUBPIXELS_AT_ONCE = 1 << 20  # that a band of rows holds: all of its layers take 0.3 GB


class Band:
    """Rows [top, top + count) of a picture, each pixel of samples x samples subpixels."""

    def __init__(self, view, top, count, callback):
        self._view = view
        self.callback = callback  # (done, total) of whatever is done for the band, by which it can be cancelled
        samples, (width, height) = view.samples, view.size
        self.samples = samples
        self.fine = samples * width, samples * height  # size of the whole picture in subpixels
        self.part = {"top": samples * top, "rows": samples * count}  # of it, as what draws takes it
        self.middle = (slice(samples // 2, None, samples),) * 2  # subpixel of each pixel

    def layers(self, drawn, direct, indirect, albedo):
        """Those of the pixels of a picture; drawn: what render_splats gives of the subpixels."""
        out = {name: drawn[name][self.middle] for name in ("depth", "normal", "index")}
        out["alpha"] = self.mean(drawn["coverage"])
        out |= {"direct": self.mean(direct), "indirect": self.mean(indirect), "albedo": self.mean(albedo)}
        return out | {"radiance": out["direct"] + out["indirect"]}

    def mean(self, values):
        """Over the subpixels of each pixel; numpy's own, of two short axes, takes six times as long."""
        n = self.samples
        parts = (values[y::n, x::n] for y in range(n) for x in range(n))
        return sum(parts) / np.float32(n * n)

    def places(self, surfels, drawn):
        """(h, w, 3) what subpixels see; drawn: their "depth" and "index"."""
        depth, index = drawn["depth"], drawn["index"]
        return _core.seen_places(surfels, self._view.camera, *self.fine, self.part["top"], depth, index)

    def colored(self, layers, colors, seen, places):
        """SeenColors.put_on of the band."""
        return colors.put_on(layers, seen, places, self._view.through, self.fine[1])

    def traced(self, scene, surfels, drawn, places):
        """(h, w, 3) irradiance that lights bring directly to what subpixels see, by rays; scene, surfels: compiled.

        drawn: "normal" and "index" of each subpixel, of which `places` are (h, w, 3). Backs have the light of fronts.
        """
        index = drawn["index"]
        there = index >= 0
        normals = drawn["normal"][there].astype(np.float64)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        normals[np.einsum("ij,ij->i", normals, surfels.normals[index[there]]) < 0.0] *= -1.0
        out = np.zeros((*index.shape, 3), np.float32)
        out[there] = _core.direct_at(scene, places[there], normals, self._view.rays, 0, self.callback)
        return out


def in_bands(view, draw, progress):
    """Layers of a whole picture, from draw(Band) of as many rows as fit; progress: a callback (done, total) or None."""
    (width, height), samples = view.size, view.samples
    rows = max(1, SUBPIXELS_AT_ONCE // (width * samples * samples))
    bands = []
    for top in range(0, height, rows):
        report(progress, top, height)
        callback = None if progress is None else lambda done, total, top=top: progress(top, height)
        bands.append(draw(Band(view, top, min(rows, height - top), callback)))
    report(progress, height, height)
    return {name: np.concatenate([band[name] for band in bands]) for name in bands[0]}
