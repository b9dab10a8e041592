"""Solving a scene, and what comes out: radiosity per surfel."""

import math
import os

import numpy as np

from surflux import _check, _core
from surflux._passes import stage_callback, thread_limit
from surflux.camera import Camera
from surflux.files import file_error, load_arrays, pack_comments, save_surfels, unpack_comments
from surflux.lights import AreaLight
from surflux.scene import Scene
from surflux.surfels import Surfels


def solve(
    scene,
    *,
    zeta=0.02,
    insert=True,
    tolerance=1e-4,
    max_surfels=None,
    rays=256,
    probes=16,
    shadow_rays=64,
    epsilon=0.8,
    max_memory=None,
    seed=0,
    threads=None,
    progress=False,
):
    """Radiosity of all surfels of a scene, with shadows and all interreflection.

    Solves B = E + rho H, H = D + F B (D04 eq. 1, with the unknown as D03 section 3 has it) for red, green and blue, or
    once where the scene is grey. All pairs of surfels exchange light: memory grows as 4 n^2 bytes, seconds as n^2.
    The exchange A_i F_ij is symmetric and scaled by one diagonal until each row, with what rays find to leave the
    scene or to end on a back face, makes 1 (Solution.history reports the largest correction). The linear system is
    solved by conjugate gradients. The scene stays as it is; areas that it lacks are computed.

    Args:
        scene: Scene.
        zeta, insert, max_surfels: steer the refinement, which this version does not have yet: it solves on the
            scene's own surfels whatever they say. Checked, so that scripts that use them keep working.
        tolerance: |residual| / |right-hand side| of the linear system; in (0, 1).
        rays: per surfel, to measure what escapes and what Environments send; 16 or more.
        probes, shadow_rays: shadow rays from a surfel to a light: as many to begin with, and where they disagree.
        epsilon: surfels with n_i . n_j above this that overlap stand for the same surface (D04 eq. 10); in (0, 1).
        max_memory: bytes for the exchange; None for three quarters of what the machine has.
        seed: of everything random; the result is the same for the same seed, whatever the number of threads.
        threads: at most this many; None for all.
        progress: True for bars on stderr, or a callback (done, total) -> bool, called for one stage after another;
            False cancels.

    Returns:
        Solution.

    Raises:
        ValueError: an argument out of range, by name; more surfels than the memory takes.
        Cancelled: the callback returned False.

    >>> import surflux as sf
    >>> points = [[x, y, 0.0] for x in range(10) for y in range(10)]
    >>> cloud = sf.Surfels(points, normals=[[0, 0, 1]] * 100, reflectance=0.5)
    >>> solution = sf.solve(sf.Scene([cloud], lights=[sf.Environment(1.0)]))
    >>> bool(abs(solution.irradiance - 3.14159).max() < 1e-4)  # a flat cloud sees the whole sky
    True
    """
    if not isinstance(scene, Scene):
        raise ValueError(f"scene: wanted a Scene, got {type(scene).__name__}")
    _check.number("zeta", zeta, 0.0, low_open=True)
    _check.flag("insert", insert)
    if max_surfels is not None:
        _check.count("max_surfels", max_surfels)
    options = {
        "tolerance": _check.number("tolerance", tolerance, 0.0, 1.0, low_open=True, high_open=True),
        "rays": _check.count("rays", rays, 16),
        "probes": _check.count("probes", probes),
        "shadow_rays": _check.count("shadow_rays", shadow_rays),
        "epsilon": _check.number("epsilon", epsilon, 0.0, 1.0, low_open=True, high_open=True),
        "max_memory": 0.0 if max_memory is None else _check.number("max_memory", max_memory, 0.0, low_open=True),
        "seed": _check.seed("seed", seed),
    }
    if options["shadow_rays"] < options["probes"]:
        raise ValueError(f"shadow_rays: wanted at least the {probes} probes, got {shadow_rays}")
    with thread_limit(threads):
        areas_seconds, core = _timed(lambda: scene._to_core(progress=progress))
        with stage_callback(progress) as callback:
            result = _core.solve(core, **options, progress=callback)
    timings = {"areas": areas_seconds, **result["timings"]}
    return Solution(
        Surfels._from_core(result["surfels"]),
        parents=result["parents"],
        radiosity=result["radiosity"],
        irradiance=result["irradiance"],
        direct=result["direct"],
        error=result["error"],
        timings=timings,
        history=[{"iteration": k + 1, **figures} for k, figures in enumerate(result["history"])],
        lamps=[light for light in scene.lights if isinstance(light, AreaLight)],
        camera=scene.camera,
    )


def form_factors(
    scene, visibility=True, *, rays=256, epsilon=0.8, seed=0, threads=None, progress=False, return_escape=False
):
    """Form factors between all surfels of a scene.

    F[i, j] is the fraction of what surfel i emits that reaches surfel j: A_i F_ij = A_j F_ji to rounding. F[i, i] is
    that of a concave piece onto itself. With visibility, each row plus what escapes plus what back faces absorb is 1,
    by the symmetric diagonal scaling that `solve` uses.

    Args:
        scene: Scene of at most 20 000 surfels.
        visibility: False takes every pair as free, and scales nothing.
        rays, epsilon, seed, threads, progress: see `solve`.
        return_escape: True returns (F, escape), escape (n,) being the share of each row that is not in F: what leaves
            the scene and what ends on back faces. Needs visibility.

    Returns:
        (n, n) float64.

    Raises:
        ValueError: an argument out of range, by name; more than 20 000 surfels.
        Cancelled: the callback returned False.

    >>> import surflux as sf
    >>> corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
    >>> floor_and_ceiling = sf.Surfels.from_mesh((corners, [[0, 1, 2, 3], [7, 6, 5, 4]]), patch_area=0.01)
    >>> F = sf.form_factors(sf.Scene([floor_and_ceiling]))
    >>> print(f"{F[:100, 100:].sum() / 100:.3f}")  # opposite faces of a cube: .1998
    0.200
    """
    if not isinstance(scene, Scene):
        raise ValueError(f"scene: wanted a Scene, got {type(scene).__name__}")
    count = sum(len(s) for s in scene.objects)
    if count > 20_000:
        raise ValueError(f"scene: wanted at most 20000 surfels for a dense matrix, got {count}")
    _check.flag("visibility", visibility)
    _check.flag("return_escape", return_escape)
    if return_escape and not visibility:
        raise ValueError("return_escape: wanted visibility=True with it, for what escapes is found by rays")
    options = {
        "rays": _check.count("rays", rays, 16),
        "epsilon": _check.number("epsilon", epsilon, 0.0, 1.0, low_open=True, high_open=True),
        "seed": _check.seed("seed", seed),
    }
    with thread_limit(threads):
        core = scene._to_core(progress=progress)
        with stage_callback(progress) as callback:
            factors, escape, absorbed, _ = _core.form_factors(core, visibility, **options, progress=callback)
    return (factors, escape + absorbed) if return_escape else factors


class Solution:
    """What a solver found. Arrays are read-only and go by the rows of `surfels`.

    Attributes:
        surfels: Surfels of the solution, with areas.
        parents: (n,) index of each surfel in scene.surfels.
        radiosity: (n, 3) exitance B = E + rho H, in the unit of the lights (W/m2).
        irradiance: (n, 3) H, direct light included.
        direct: (n, 3) the part of H that comes from lights and Environments.
        error: the solver's own estimate of the relative RMS error of H: fresh rays from 500 surfels gather the
            solution once more. What the direct light is off by is not in it; NaN where it was not estimated.
        timings: dict, seconds per stage.
        history: list of dicts, the figures of each iteration: surfels, links (pairs that exchange light), rays,
            largest_correction (of the diagonal that closes the exchange, max |d_i - 1|), closure_residual,
            largest_shortfall (of a row that no diagonal fills; back faces are taken to absorb it),
            closure_applications, channels (1 where all is grey), applications of the operator, residual, error,
            power_in and where it ends: power_absorbed, power_escaped and power_into_backs (all channels added up; a
            grey scene has its one three times), seconds.
        camera: Camera from which the scene wants to be seen, or None.
    """

    def __init__(
        self,
        surfels,
        *,
        parents,
        radiosity,
        irradiance,
        direct,
        error=math.nan,
        timings=None,
        history=(),
        lamps=(),
        camera=None,
    ):
        self.surfels = surfels
        self.parents = _frozen(parents)
        self.radiosity = _frozen(radiosity)
        self.irradiance = _frozen(irradiance)
        self.direct = _frozen(direct)
        self.error = error
        self.timings = dict(timings or {})
        self.history = list(history)
        self.camera = camera
        self._lamps = list(lamps)

    def __repr__(self):
        return f"Solution({len(self.surfels)} surfels, error {self.error:.2g}, {sum(self.timings.values()):.3g} s)"

    def render(self, camera=None, size=(800, 600), *, background=0.0, samples=2, layers=False):
        """A picture: the surfels splatted as disks, blended per pixel, the scene's area lights as they shine.

        Drawn by OpenGL without a window (D04 step 4), in float32.

        Args:
            camera: Camera; None for the scene's own, or one that has all surfels in view.
            size: (width, height) in pixels.
            background: radiance where nothing is, scalar or RGB.
            samples: the picture is drawn this many times finer each way and averaged; 1 to 8.
            layers: True for a dict with "radiance", "direct" and "indirect" (h, w, 3), "depth" (h, w), along the
                view axis and infinite where nothing is, "normal" (h, w, 3) and "index" (h, w) of the surfel, or -1.

        Returns:
            (h, w, 3) float32, linear radiance, row 0 on top; or the dict.

        Raises:
            ValueError: an argument out of range, by name.
            DeviceError: there is no OpenGL; says what was tried.
        """
        if camera is None:
            camera = self.camera or Camera.fit(_extremes(self.surfels), aspect=size[0] / size[1])
        if not isinstance(camera, Camera):
            raise ValueError(f"camera: wanted a Camera or None, got {type(camera).__name__}")
        if not (isinstance(size, (tuple, list)) and len(size) == 2):
            raise ValueError(f"size: wanted (width, height), got {size!r}")
        width, height = (_check.count("size", v, 1, 16384) for v in size)
        background = _check.rgb("background", background)
        samples = _check.count("samples", samples, 1, 8)
        _check.flag("layers", layers)

        def draw(exitance, lamps):
            return _core.render_splats(
                self.surfels._core,
                exitance / np.pi,
                [(lamp.corner, lamp.edge_u, lamp.edge_v, np.divide(lamp.exitance, np.pi)) for lamp in lamps],
                (camera.eye, camera.target, camera.up, camera.fov),
                width,
                height,
                background,
                FOOTPRINT,
                samples,
            )

        picture = draw(self.radiosity, self._lamps)
        if not layers:
            return picture["radiance"]
        rho = self.surfels.reflectance
        picture["direct"] = draw(self.surfels.emission + rho * self.direct, self._lamps)["radiance"]
        picture["indirect"] = draw(rho * (self.irradiance - self.direct), [])["radiance"]
        return {name: picture[name] for name in ("radiance", "direct", "indirect", "depth", "normal", "index")}

    def plot(self, color="radiosity", **options):
        """Shows the surfels with pyvista, coloured by what was solved; see Surfels.plot for the options."""
        from surflux.viewer import plot

        values = {"radiosity": self.radiosity, "irradiance": self.irradiance, "direct": self.direct}
        options.setdefault("camera", self.camera)
        return plot(self.surfels, color=color, values=values, **options)

    def save(self, path):
        """Writes surfels, radiosity, irradiance, camera and figures as one binary PLY file; see load_solution.

        Raises:
            FileError: the file cannot be written.
        """
        lamps = [[list(v) for v in (lamp.corner, lamp.edge_u, lamp.edge_v, lamp.exitance)] for lamp in self._lamps]
        about = {
            "solution": 1,
            "error": None if math.isnan(self.error) else self.error,
            "timings": self.timings,
            "history": self.history,
            "camera": None if self.camera is None else self.camera.to_dict(),
            "lamps": lamps,
        }
        save_surfels(
            path,
            self.surfels._core,
            radiosity=self.radiosity,
            irradiance=self.irradiance,
            direct=self.direct,
            columns={"parent": self.parents},
            comments=pack_comments(about),
        )


# Splats reach this many radii: beyond 1, so that every pixel of a disk lies well inside of some splat.
FOOTPRINT = 1.5


def load_solution(path):
    """The Solution that Solution.save wrote.

    Raises:
        FileError: with the path and the reason; a file of points that holds no solution is none.

    >>> import surflux as sf
    >>> floor = sf.Surfels([[0, 0, 0]], normals=[[0, 0, 1]], radii=0.1, areas=0.03)
    >>> sf.solve(sf.Scene([floor], lights=[sf.DirectionalLight([0, 0, -1], 2.0)])).save("floor.ply")
    >>> sf.load_solution("floor.ply").irradiance
    array([[2., 2., 2.]])
    """
    arrays = load_arrays(path)
    about = unpack_comments(arrays["comments"], path)
    if about.get("solution") != 1 or any(arrays[name] is None for name in ("radiosity", "irradiance", "direct")):
        raise file_error(path, f"holds points but no solution; `surflux solve {os.fsdecode(path)}` makes one")
    try:
        camera = None if about["camera"] is None else Camera(**about["camera"])
        lamps = [AreaLight(*lamp) for lamp in about["lamps"]]
        error = math.nan if about["error"] is None else float(about["error"])
        timings = {stage: float(seconds) for stage, seconds in dict(about["timings"]).items()}
        history = [dict(figures) for figures in about["history"]]
    except (KeyError, TypeError, ValueError, OverflowError) as fault:
        raise file_error(path, f"its description of the solution is damaged ({fault})") from fault
    given = ("normals", "radii", "areas", "reflectance", "emission")
    for name in given:
        if arrays[name] is None:
            raise file_error(path, f"its surfels have no {name}, which a solution has")
    try:
        _check.finite_array("normals", arrays["normals"], (None, 3))
        core = _core.Surfels(
            arrays["points"], *(arrays[name] for name in given), arrays["triangles"], arrays["triangle_surfel"]
        )
    except ValueError as fault:
        raise file_error(path, str(fault)) from fault
    return Solution(
        Surfels._from_core(core),
        parents=_parents(path, arrays["columns"].get("parent")),
        radiosity=arrays["radiosity"],
        irradiance=arrays["irradiance"],
        direct=arrays["direct"],
        error=error,
        timings=timings,
        history=history,
        lamps=lamps,
        camera=camera,
    )


def _parents(path, column):
    if column is None:
        raise file_error(path, "its surfels have no parent, which a solution has")
    with np.errstate(invalid="ignore"):
        bad = ~((column >= 0) & (column < 2**32) & (column == np.floor(column)))
    if np.any(bad):
        row = int(np.argmax(bad))
        raise file_error(path, f"vertex {row}: parent is {column[row]:g}; wanted the index of a surfel")
    return column.astype(np.uint32)


def _frozen(values):
    values = np.array(values)
    values.setflags(write=False)
    return values


def _timed(work):
    from time import perf_counter

    start = perf_counter()
    result = work()
    return perf_counter() - start, result


def _extremes(surfels):
    reach = surfels.radii[:, None]
    return np.concatenate([surfels.points - reach, surfels.points + reach])
