"""Gaussians as renderers draw them, from the published program of Kerbl and others 2023 and nothing of surflux."""

import numpy as np

C0 = 0.28209479177387814
C1 = 0.4886025119029199
C2 = (1.0925484305920792, -1.0925484305920792, 0.31539156525252005, -1.0925484305920792, 0.5462742152960396)
C3 = (-0.5900435899266435, 2.890611442640554, -0.4570457994644658, 0.3731763325901154)
C3 += (-0.4570457994644658, 1.445305721320277, -0.5900435899266435)


def colors(harmonics, directions):
    """(n, 3) of harmonics (n, k, 3) seen in unit directions (n, 3) from the camera: eval_sh of utils/sh_utils.py."""
    x, y, z = directions.T[:, :, None]
    h = harmonics.transpose(1, 0, 2)
    found = C0 * h[0]
    if len(h) > 1:
        found = found - C1 * y * h[1] + C1 * z * h[2] - C1 * x * h[3]
    if len(h) > 4:
        found = found + C2[0] * x * y * h[4] + C2[1] * y * z * h[5] + C2[2] * (2 * z * z - x * x - y * y) * h[6]
        found = found + C2[3] * x * z * h[7] + C2[4] * (x * x - y * y) * h[8]
    if len(h) > 9:
        found = found + C3[0] * y * (3 * x * x - y * y) * h[9] + C3[1] * x * y * z * h[10]
        found = found + C3[2] * y * (4 * z * z - x * x - y * y) * h[11]
        found = found + C3[3] * z * (2 * z * z - 3 * x * x - 3 * y * y) * h[12]
        found = found + C3[4] * x * (4 * z * z - x * x - y * y) * h[13]
        found = found + C3[5] * z * (x * x - y * y) * h[14] + C3[6] * x * (x * x - 3 * y * y) * h[15]
    return np.maximum(found + 0.5, 0.0)


def axes(rotations):
    """(n, 3, 3) of quaternions (w, x, y, z): build_rotation of utils/general_utils.py."""
    w, x, y, z = rotations.T
    out = np.empty((len(rotations), 3, 3))
    out[:, 0] = np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)], 1)
    out[:, 1] = np.stack([2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)], 1)
    out[:, 2] = np.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], 1)
    return out


def drawn(gaussians, camera, size, rows=slice(None)):
    """(h, w, 3) colours before black and (h, w) what is let through, of some Gaussians and a pinhole camera.

    Sorted by the distance of their centres, nearest first, each an ellipse out to three standard deviations, 0.3
    pixels^2 wider, its alpha at most .99 and nothing below 1/255: forward.cu of diff-gaussian-rasterization.
    """
    width, height = size
    forward = camera.target - camera.eye
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, camera.up)
    right /= np.linalg.norm(right)
    view = np.stack([right, np.cross(forward, right), forward])
    away = gaussians.positions[rows] - camera.eye
    distance = np.linalg.norm(away, axis=1)
    shown = colors(gaussians.harmonics[rows], away / distance[:, None])
    x, y, z = view @ away.T
    assert z.min() > 0.0
    focal = 0.5 * height / np.tan(np.radians(camera.fov) / 2)
    spread = axes(gaussians.rotations[rows]) * gaussians.scales[rows][:, None, :]
    none = np.zeros_like(z)
    to_pixels = np.stack([focal / z, none, -focal * x / z**2, none, focal / z, -focal * y / z**2], 1).reshape(-1, 2, 3)
    flat = to_pixels @ view @ spread
    covariance = flat @ flat.transpose(0, 2, 1) + 0.3 * np.eye(2)
    inverse = np.linalg.inv(covariance)
    centers = np.stack([0.5 * width + focal * x / z, 0.5 * height + focal * y / z], 1)
    reach = 3.0 * np.sqrt(np.linalg.eigvalsh(covariance)[:, 1:])
    low = np.clip(np.floor(centers - reach), 0, size).astype(int)
    high = np.clip(np.ceil(centers + reach), 0, size).astype(int)
    image, through = np.zeros((height, width, 3)), np.ones((height, width))
    for i in np.argsort(distance, kind="stable"):
        box = slice(low[i, 1], high[i, 1]), slice(low[i, 0], high[i, 0])
        u = np.arange(low[i, 0], high[i, 0]) + 0.5 - centers[i, 0]
        v = (np.arange(low[i, 1], high[i, 1]) + 0.5 - centers[i, 1])[:, None]
        (a, b), (_, c) = inverse[i]
        alpha = np.minimum(0.99, gaussians.opacities[rows][i] * np.exp(-0.5 * (a * u * u + 2 * b * u * v + c * v * v)))
        alpha[alpha < 1 / 255] = 0.0
        image[box] += (through[box] * alpha)[..., None] * shown[i]
        through[box] *= 1.0 - alpha
    return image, through
