"""Effective areas: what each surfel contributes to the area of its surface (D04 section 5)."""

from surflux import _check, _core
from surflux._passes import progress_callback, thread_limit

METHODS = ("paper", "curved")
BACKENDS = ("auto", "cpu", "gl")


def effective_areas(
    s,
    *,
    method="curved",
    kappa=3.0,
    resolution=32,
    epsilon=0.8,
    backend="auto",
    threads=None,
    progress=False,
):
    """Effective areas S of surfels: (n,) float64, in the square of the unit of their positions. s stays as it is.

    Surfels that stand for mesh patches get the exact area of their triangles. All others get the integral of their
    share of their own tangent disk (D04 eq. 4 to 9).

    Args:
        s: Surfels.
        method: "curved", second order: weights are taken at an estimate of the surface point over each pixel, so that
            a sphere of 642 surfels is right to 0.1 %; or "paper", D04 eq. 9 as D03 eq. 9 has it, on the tangent disks
            themselves, which lie outside a convex surface: +2.2 % there.
        kappa: how fast a surfel's weight falls with distance, above 0: exp(-kappa r / R) on the disks (at most 80), or
            r^(-2 kappa) (1 - r / R) at the surface (at most 8).
        resolution: the disk is integrated on a grid of resolution x resolution, 4 to 512.
        epsilon: a neighbour counts only where the cosine between the normals is above epsilon; between 0 and 1.
        backend: where the shares are integrated. "cpu": kernels for this processor. "gl": OpenGL, as D04 5.3 draws
            them, neighbours blended additively into a float atlas; it gives the areas of "cpu" up to rounding (1e-6 for
            "curved"; for "paper", 1e-4, where a pixel's centre lies on the rim of a disk). "auto": the faster one by
            what the machine is. That is "cpu", unless OpenGL is drawn by a GPU, not by software (llvmpipe and its
            like), and there is more than about a second of work for the CPU: 100 000 surfels at resolution 32 for each
            thread. The environment's SURFLUX_GL chooses "egl" or "osmesa"; unset, EGL comes first.
        threads: at most this many; None for all. A software OpenGL starts its own besides.
        progress: True for a bar on stderr, or a callback (done, total) -> bool, where False cancels.

    Raises:
        ValueError: an argument out of range, by name.
        DeviceError: backend "gl", and there is no OpenGL; says what was tried and what to install.
        Cancelled: the callback returned False.

    >>> import surflux as sf
    >>> grid = sf.Surfels([[x, y, 0] for y in range(11) for x in range(11)], normals=[[0, 0, 1]] * 121, radii=2.0)
    >>> print(f"{sf.effective_areas(grid)[60]:.2f}")  # in the middle, each surfel has a unit square to itself
    1.00
    """
    from surflux.surfels import Surfels

    if not isinstance(s, Surfels):
        raise ValueError(f"s: wanted Surfels, got {type(s).__name__}")
    _check.choice("method", method, METHODS)
    _check.choice("backend", backend, BACKENDS)
    kappa = _check.number("kappa", kappa, 0.0, 80.0 if method == "paper" else 8.0, low_open=True)
    resolution = _check.count("resolution", resolution, 4, 512)
    epsilon = _check.number("epsilon", epsilon, 0.0, 1.0, low_open=True, high_open=True)

    with thread_limit(threads), progress_callback(progress, "areas") as callback:
        return _core.effective_areas(
            s._core,
            curved=method == "curved",
            kappa=kappa,
            resolution=resolution,
            epsilon=epsilon,
            backend=_core.AreaBackend.__members__[backend],
            progress=callback,
        )
