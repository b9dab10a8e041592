"""Pictures of meshless solutions, straight from their basis (L07 section 6.2)."""

import numpy as np

from surflux._base.passes import report

SUBPIXELS_AT_ONCE = 1 << 20  # that a band of rows holds: all of its layers take 0.3 GB


def basis_layers(field, surfels, lamps, view, names, splat, progress):
    """The layers of Solution.render, with the basis evaluated at every subpixel, band by band.

    Args:
        field: BasisField.
        surfels: Surfels of the solution.
        lamps: as _core.render_splats takes them.
        view: rendering.View.
        names: of the layers that are wanted.
        splat: as rendering.picture has it.
        progress: a callback (done, total), or None.
    """
    (width, height), samples = view.size, view.samples
    rows = max(1, SUBPIXELS_AT_ONCE // (width * samples * samples))
    bands = []
    for top in range(0, height, rows):
        report(progress, top, height)
        count = min(rows, height - top)
        bands.append(_band(field, surfels, lamps, view, names, splat, top, count))
    report(progress, height, height)
    return {name: np.concatenate([band[name] for band in bands]) for name in bands[0]}


def _band(field, surfels, lamps, view, names, splat, top, count):
    """The layers of rows [top, top + count)."""
    (width, height), samples = view.size, view.samples
    fine = samples * width, samples * height
    part = {"top": samples * top, "rows": samples * count}
    exitance = surfels.emission
    if view.direct == "interpolated":
        exitance = exitance + surfels.reflectance * field.lit
    layers = [(exitance / np.pi, True), (surfels.reflectance, False)]
    if field.emitted.any():
        layers.append((surfels.reflectance * field.emitted / np.pi, False))
    seen = field.basis.image(lamps, view.camera, *fine, **part, culling=view.culling)
    if seen["hidden"].any():
        _fill_hidden(field, seen)
    drawn = splat(layers, fine, 1, None, **part)
    found, albedo, *rest = drawn["layers"]
    if view.direct == "traced":
        found += albedo / np.pi * _traced(field.basis, seen, view.rays)
    else:  # what the basis holds of it: all, or the light of the sky
        found += albedo / np.pi * seen["direct"]
    indirect = albedo / np.pi * (seen["all"] - seen["direct"])
    if rest:
        indirect += rest[0]

    def mean(values):  # numpy's own, of two short axes, takes six times as long
        parts = (values[y::samples, x::samples] for y in range(samples) for x in range(samples))
        return sum(parts) / np.float32(samples * samples)

    middle = (slice(samples // 2, None, samples),) * 2
    out = {name: drawn[name][middle] for name in ("depth", "normal", "index")}
    out["alpha"] = mean(drawn["coverage"])
    out |= {"direct": mean(found), "indirect": mean(indirect), "albedo": mean(albedo)}
    out["radiance"] = out["direct"] + out["indirect"]
    if "level" in names:
        index = out["index"]
        there = index >= 0
        out["level"] = np.full(index.shape, np.nan, np.float32)
        places = seen["position"][middle][there], seen["normal"][middle][there].astype(np.float64)
        out["level"][there] = field.basis.levels_at(*places, index[there])
    return out


def _fill_hidden(field, seen):
    """Where no function speaks, surfels do, less what the layers bring of them."""
    hidden = seen["hidden"] != 0
    normals = seen["normal"][hidden].astype(np.float64)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    others, direct = field.at_surfels(seen["position"][hidden], normals)
    on = seen["index"][hidden]
    others, direct = np.maximum(others - field.emitted[on], 0.0), np.maximum(direct - field.lit[on], 0.0)
    seen["all"][hidden] = others + direct
    seen["direct"][hidden] = direct


def _traced(basis, seen, rays):
    """Direct light by rays from where every subpixel sees a surfel."""
    there = seen["index"] >= 0
    out = np.zeros(seen["all"].shape, np.float32)
    normals = seen["normal"][there].astype(np.float64)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    out[there] = basis.direct_at(seen["position"][there], normals, rays, 0, None)
    return out
