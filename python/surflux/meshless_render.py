"""Pictures of meshless solutions, straight from their basis (L07 section 6.2)."""

import numpy as np

from surflux.fields import PROBES, SHADOW_RAYS, SKY_RAYS


def basis_layers(field, surfels, lamps, camera, size, samples, direct, splat):
    """The layers of Solution.render, with the basis evaluated at every subpixel.

    Args:
        field: BasisField.
        surfels: Surfels of the solution.
        lamps: as _core.render_splats takes them.
        camera: as _core.render_splats takes it.
        size: (width, height) in pixels.
        samples: subpixels of a pixel each way.
        direct: "interpolated" or "traced".
        splat: (exitance by surfel, lamps, width, height, samples, black background?) -> what _core.render_splats gives.
    """
    width, height = size
    fine = samples * width, samples * height
    seen = field.basis.image(lamps, camera, *fine)
    dark = [(*lamp[:3], np.zeros(3)) for lamp in lamps]
    # Radiance per irradiance: reflectance / pi, and 0 where a lamp or nothing is seen.
    white = splat(surfels.reflectance, dark, *fine, 1, True)["radiance"]

    def pixels(irradiance):
        values = white * irradiance
        return values.reshape(height, samples, width, samples, 3).mean(axis=(1, 3))

    beside = field.emitted is not None  # is there light that the basis leaves out?
    exitance = surfels.emission
    if beside and direct == "interpolated":
        exitance = exitance + surfels.reflectance * field.lit
    picture = splat(exitance, lamps, width, height, samples, False)
    picture["direct"] = picture["radiance"]
    if direct == "traced":
        picture["direct"] = picture["direct"] + pixels(_traced(field.basis, seen))
    elif not beside:
        picture["direct"] = picture["direct"] + pixels(seen["direct"])
    picture["indirect"] = pixels(seen["all"] - seen["direct"])
    if beside and field.emitted.any():
        picture["indirect"] += splat(surfels.reflectance * field.emitted, dark, width, height, samples, True)[
            "radiance"
        ]
    picture["radiance"] = picture["direct"] + picture["indirect"]
    return picture


def _traced(basis, seen):
    """Direct light by rays from where every subpixel sees a surfel."""
    there = seen["index"] >= 0
    out = np.zeros(seen["all"].shape, np.float32)
    normals = seen["normal"][there].astype(np.float64)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    out[there] = basis.direct_at(seen["position"][there], normals, PROBES, SHADOW_RAYS, SKY_RAYS, 0, None)
    return out
