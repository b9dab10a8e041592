"""Pictures of meshless solutions, straight from their basis (L07 section 6.2)."""

import numpy as np

from surflux.solutions.subpixels import in_bands


def basis_layers(field, surfels, lamps, view, names, splat, progress, colors):
    """The layers of Solution.render, with light from the basis for every subpixel, band by band.

    Args:
        field: BasisField.
        surfels: Surfels of the solution.
        lamps: as _core.render_splats takes them.
        view: rendering.View.
        names: of the layers that are wanted.
        splat: as rendering.picture has it.
        progress: a callback (done, total), or None.
        colors: SeenColors.
    """
    return in_bands(view, lambda band: _layers(field, lamps, view, names, splat, band, colors, surfels), progress)


def _layers(field, lamps, view, names, splat, band, colors, surfels):
    exitance, rho = colors.emission, colors.reflectance
    if view.direct == "interpolated":
        exitance = exitance + rho * field.lit
    layers = [(exitance / np.pi, True), (rho, False)]
    if field.emitted is not None:
        layers.append((rho * field.emitted / np.pi, False))
    seen = field.basis.image(lamps, view.camera, *band.fine, view.samples, **band.part, culling=view.culling)
    if seen["hidden"].any():
        _fill_hidden(field, seen)
    drawn = splat(layers, band.fine, 1, None, **band.part)
    found, albedo, *rest = band.colored(drawn["layers"], colors, seen, seen["position"])
    if view.direct == "traced":
        found += albedo / np.pi * band.traced(field.scene, surfels._core, seen, seen["position"])
    else:  # what the basis holds of it: all, or the light of the sky
        found += albedo / np.pi * seen["direct"]
    indirect = albedo / np.pi * (seen["all"] - seen["direct"])
    if rest:
        indirect += rest[0]
    out = band.layers(drawn, found, indirect, albedo)
    if "level" in names:
        index = out["index"]
        there = index >= 0
        out["level"] = np.full(index.shape, np.nan, np.float32)
        places = seen["position"][band.middle][there], seen["normal"][band.middle][there].astype(np.float64)
        out["level"][there] = field.basis.levels_at(*places, index[there])
    return out


def _fill_hidden(field, seen):
    """Where no function speaks, surfels do, less what the layers bring of them."""
    hidden = seen["hidden"] != 0
    normals = seen["normal"][hidden].astype(np.float64)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    others, direct = field.at_surfels(seen["position"][hidden], normals)
    on = seen["index"][hidden]
    if field.emitted is not None:
        others = np.maximum(others - field.emitted[on], 0.0)
    direct = np.maximum(direct - field.lit[on], 0.0)
    seen["all"][hidden] = others + direct
    seen["direct"][hidden] = direct
