"""What every solver gives: radiosity per surfel, pictures of it, and its file."""

from __future__ import annotations

import copy
import math
from collections.abc import Iterable, Mapping
from typing import Any, Literal, Unpack, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surflux import _core
from surflux._base import check
from surflux._base.frozen import frozen
from surflux._base.passes import progress_callback, stage, thread_limit, watched
from surflux._base.types import Floats, Image, Integers, Progress, Size
from surflux.pictures.camera import Camera
from surflux.points.surfels import Surfels
from surflux.scenes.lights import AreaLight, Environment
from surflux.scenes.scene import Scene
from surflux.solutions import estimating, rendering, saving, showing, summaries, towards
from surflux.solutions.fields import RAYS, BasisField, Evaluation, SurfelField, basis_field, light_of, warn_of_mid_air
from surflux.solutions.leaves import inserted_among, insertion_depth, means_of_faces, means_of_parents


class Solution:
    """What a solver found. Arrays are read-only and go by the rows of `surfels`.

    Attributes:
        surfels: Surfels of the solution, with areas: the scene's, and those inserted in place of some of them.
        parents: (n,) index of each surfel in scene.surfels.
        objects: (n,) index of the object in scene.objects that each surfel belongs to.
        levels: (n,) how finely light was gathered. `solve`: 0 at the surfel itself, 1, 2 and so on at a group that many
            levels above it in the hierarchy, -1, -2 and so on for surfels inserted that many levels below the scene's
            own. `solve_meshless`: the finest level of points that has a say, 0 being the coarsest; one more than the
            finest of all where light was gathered at the surfel itself, of which `irradiance_at` and pictures do not
            know.
        radiosity: (n, 3) exitance B = E + rho H, in the unit of the lights (W/m2).
        irradiance: (n, 3) H, direct light included: the mean over the patch of a mesh, at the centre of a disk; of
            inserted surfels over the part of the patch that is theirs, or at their place.
        direct: (n, 3) the part of H that comes from lights and Environments.
        cut: (n,) index of the node that each surfel's light was solved for, which may be a group of surfels (D04 7.1):
            `history[-1]["cut"]` of them. None where there was none, as with solve_meshless.
        error: the solver's own estimate of the relative RMS error of H, direct light included: from the residuals at
            2000 surfels or more, drawn by area, that fresh rays find there, and what they bring to all others over all
            bounces. Never less than what its rays can tell; NaN where no light arrives at all, so that there is
            nothing to be relative to, and where it was not estimated (estimate_error).
        timings: dict, seconds per stage.
        history: list of dicts, the figures of each iteration (of relit scenes once, surfels and powers alone): surfels,
            cut (nodes that light was solved for), refined (nodes that gave way to get there), inserted (all that ever
            were, split ones included), left_out (surfels that max_surfels kept from being split), of solve_meshless
            level (the finest of the basis), points (its functions) and surfels_gathered (surfels finer than the basis,
            with rays of their own), links (pairs of a node and what it gathers from, or of surfels; with solve_meshless
            one for each ray), rays, channels (1 where all is grey), applications of the operator, residual, imbalance
            (of what neighbourhoods send and what all receive from them, before reciprocity mended it) and
            imbalance_left (of that, afterwards, in the part that balances worst), error (an estimate from the variance
            of the rays and the error of interpolation; at the end that of `error`), error_uncertainty (the standard
            error of `error`), local_error and local_error_p90 (median and 90th percentile, over some 60 regions of the
            surface, of the RMS error of a region relative to its own light, where that is above a thousandth of the RMS
            of H; no less than rays can tell), power_in and where it ends (all channels added up; a grey scene has its
            one three times): power_absorbed, power_escaped and power_into_backs, both by the senders' own rays, and
            power_lost, the residual, of either sign, with its standard error by these rays, power_lost_error; of lamps
            and suns direct_on_backs (of their light the share that falls on backs, and so does not enter); parts (of
            the scene that see nothing of each other), largest_part_lost (of the part and channel that balance worst,
            what is lost or made of what enters), seconds up to then. With all pairs also largest_correction (of the
            diagonal that closes the exchange, max |d_i - 1|), closure_residual, largest_shortfall (of a row that no
            diagonal fills; back faces are taken to absorb it), short_rows and closure_applications. Where an error or a
            time was asked for, the last one has wanted_error, wanted_seconds, and how many attempts there were.
        attempts: list of dicts, where an error or a time was asked for: settings, estimated error and seconds of each
            attempt; an error of NaN is of one that the time was not enough for.
        camera: Camera from which the scene wants to be seen, or None.
    """

    surfels: Surfels
    parents: Integers
    objects: Integers
    levels: NDArray[np.int32]
    radiosity: Floats
    irradiance: Floats
    direct: Floats
    cut: Integers | None
    error: float
    timings: dict[str, float]
    history: list[dict[str, Any]]
    attempts: list[dict[str, Any]]
    camera: Camera | None

    def __init__(
        self,
        surfels: Surfels,
        *,
        parents: ArrayLike,
        objects: ArrayLike,
        radiosity: ArrayLike,
        irradiance: ArrayLike,
        direct: ArrayLike,
        emitted: ArrayLike | None = None,
        levels: ArrayLike | None = None,
        cut: ArrayLike | None = None,
        error: float = math.nan,
        timings: Mapping[str, float] | None = None,
        history: Iterable[dict[str, Any]] = (),
        attempts: Iterable[dict[str, Any]] = (),
        lamps: Iterable[AreaLight] = (),
        environments: Iterable[Environment] = (),
        camera: Camera | None = None,
        scene: Scene | None = None,
    ) -> None:
        self.surfels = surfels
        self.parents = frozen(parents)
        self.objects = frozen(objects)
        levels = np.zeros(len(surfels), np.int32) if levels is None else np.array(levels, np.int32)
        # What was inserted in a group whose light it shares is told by its depth.
        inserted = np.flatnonzero(inserted_among(self.parents))
        depth = insertion_depth(self.parents[inserted], surfels.areas[inserted])
        levels[inserted] = np.where(levels[inserted] >= 0, depth, levels[inserted])
        self.levels = frozen(levels)
        self.radiosity = frozen(radiosity)
        self.irradiance = frozen(irradiance)
        self.direct = frozen(direct)
        self._emitted = None if emitted is None else frozen(emitted)  # of H, by small surfels that shine, where known
        self.cut = None if cut is None else frozen(cut)
        self.error = error
        self.timings = dict(timings or {})
        self.history = list(history)
        self.attempts = list(attempts)
        self.camera = camera
        self._lamps, self._environments, self._scene = list(lamps), list(environments), scene  # what is seen of lights
        self._known_field, self._on_surface, self._walls = None, None, rendering.Walls()
        self._bounces = None  # how often light is reflected; None: until nothing is left of it
        # Of glossy surfels the light that comes to them, specular (n, 3) and exponents (n,); is it left out? Told so?
        self._mirrored, self._lobes_lost, self._lobes_told = None, False, False

    @property
    def _field(self):
        if isinstance(self._known_field, dict):  # as it was pickled
            self._known_field = basis_field(self._known_field, self)
        return self._known_field

    def __copy__(self) -> Solution:
        twin = Solution.__new__(Solution)
        twin.__dict__.update(self.__dict__)
        return twin

    def __deepcopy__(self, memo: dict[int, Any]) -> Solution:
        of_core = ("_known_field", "_on_surface", "_walls", "_mirrored")  # which solutions share
        kept = {name: value if name in of_core else copy.deepcopy(value, memo) for name, value in vars(self).items()}
        twin = self.__copy__()
        twin.__dict__.update(kept)
        return twin

    def __getstate__(self) -> dict[str, Any]:
        """All that cannot be made again; a basis of solve_meshless as its functions."""
        basis = self._known_field.pickled() if isinstance(self._known_field, BasisField) else self._known_field
        again = {"_on_surface": None, "_walls": rendering.Walls()} | towards.without_lobes(self, "pickle")
        return self.__dict__ | {"_known_field": basis if isinstance(basis, dict) else None} | again

    __repr__, __str__, _repr_html_ = summaries.as_text, summaries.as_lines, summaries.as_table

    def irradiance_at(
        self,
        points: ArrayLike,
        normals: ArrayLike,
        direct: Literal["interpolated", "traced"] | None = None,
        *,
        indirect: Literal["interpolated", "gathered"] = "interpolated",
        rays: int = RAYS,
        seed: int = 0,
        threads: int | None = None,
        progress: Progress = False,
    ) -> Floats:
        """Irradiance H at any points on surfaces.

        Direct light is found by rays from the points, and so is that of lamps that are meshes, of at most 15 % of the
        surface, but of relit solutions. All else is interpolated between surfels, to first order (Franke and Nielson
        1980), from those of one object that face about the same way; or gathered by rays, too (Reichert 1992), from
        surfaces that send what is interpolated there: closer in corners, behind furniture and below it.
        Points behind their surface, as rounding puts them, are moved up to it, as far as half the radius of a surfel.

        What is interpolated knows nothing of mid-air, nor of where nothing faces the way of the normal: a warning tells
        of points farther from every surfel than its corners, or twice its radius along it, or its radius off its plane.
        Gathered light is right there if surfels are small beside their distance; a warning tells of backs.

        Args:
            points: (m, 3).
            normals: (m, 3), of any length but 0.
            direct: "traced", by rays; or "interpolated" between surfels, a tenth of a millisecond a point faster: off
                at borders of shadows, by any amount near lamps closer than surfels are wide. None: traced, but of
                solutions from files, which hold no scene.
            indirect: "interpolated", or "gathered", some milliseconds a point, of solutions of no number of bounces.
            rays: from each point to the sky, and over the hemisphere to gather, best a power of 2; three times as many
                where little of the sky is seen. To a light half as many, or an eighth; to all mesh lamps a quarter.
            seed: of the rays.
            threads, progress: see `solve`.

        Returns:
            (m, 3) float64, in the unit of the lights (W/m2).

        Raises:
            ValueError: an argument, by name; "traced" or "gathered" of a solution without a scene, as that of a file.
            Cancelled: the callback returned False.

        >>> import surflux as sf
        >>> floor = sf.Surfels.from_mesh(([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]]), patch_area=0.1)
        >>> solution = sf.solve(sf.Scene([floor], lights=[sf.Environment(1.0)]))
        >>> print(solution.irradiance_at([[0.3, 0.6, 0.0]], [[0, 0, 1]]).round(4))
        [[3.1416 3.1416 3.1416]]
        """
        points = check.finite_array("points", points, (None, 3))
        normals = check.unit_vectors("normals", check.finite_array("normals", normals, (len(points), 3)))
        how = Evaluation(direct, indirect, rays, seed, self)
        with watched(threads, progress):
            callback = stage("irradiance")
            self._on_surface = self._on_surface or _core.OnSurface(self.surfels._core)
            if not how.is_gathered:
                warn_of_mid_air(self._on_surface(points, normals) != 0, self._scene is not None)
            scene = None if self._scene is None else self._scene._to_core()
            points = points if scene is None else _core.onto_surface(scene, points, normals)
            if self._field is None:
                self._known_field = SurfelField(self.surfels, self.objects, light_of(self), scene, callback)
            return np.asarray(self._field.irradiance(points, normals, how, callback))

    @overload
    def render(
        self,
        camera: Camera | None = None,
        size: Size = (800, 600),
        *,
        layers: Literal[False] = False,
        **options: Unpack[rendering.Options],
    ) -> Image: ...
    @overload
    def render(
        self,
        camera: Camera | None = None,
        size: Size = (800, 600),
        *,
        layers: Literal[True] | list[str] | tuple[str, ...],
        **options: Unpack[rendering.Options],
    ) -> dict[str, NDArray[Any]]: ...
    def render(
        self,
        camera: Camera | None = None,
        size: Size = (800, 600),
        *,
        background: ArrayLike | Environment = 0.0,
        samples: int = 2,
        layers: bool | list[str] | tuple[str, ...] = False,
        direct: Literal["interpolated", "traced"] = "interpolated",
        rays: int = 64,
        culling: bool = True,
        threads: int | None = None,
        progress: Progress = False,
    ) -> Any:
        """A picture: the surfels splatted as disks, blended per pixel, the scene's area lights as they shine.

        Drawn by OpenGL without a window (D04 step 4), in float32. One pass finds the surface that each subpixel sees:
        disks, bent along the surface, and the triangles of meshes. A second blends the surfels around that point with
        elliptical Gaussians, as wide as surfels lie apart or as a subpixel sees, whichever is more (object-space EWA:
        Ren, Pfister and Zwicker 2002), within one object, of a mesh one material, not across creases, and of what
        stands on the surface not beneath it: the floor on the other side of a wall lends nothing, nor does the wall
        behind a picture that hangs before it.
        Of a mesh with textures light is blended, over all of it, and times what the subpixel sees of them, filtered
        (mip maps, Williams 1983; at a slant at several places, McCormack and others 1999); a file does without them.
        A meshless solution that is not from a file is drawn from its basis, which every subpixel evaluates at what it
        sees (L07 section 6.2); what is not in the basis (see `indirect_only`) is blended from the surfels.

        Args:
            camera: Camera; None for the scene's own, or one that has all surfels in view.
            size: (width, height) in pixels.
            background: radiance where nothing is, scalar or RGB; True for the Environments of the scene's lights, in
                the direction of each subpixel, as rays of the solver find them; or an Environment.
            samples: the picture is drawn this many times finer each way and averaged; 1 to 8.
            layers: True for a dict of all that is known about each pixel, or a list of some of the names:
                "radiance", "direct" and "indirect" (h, w, 3), the two of which it is the sum; "albedo" (h, w, 3), the
                reflectance, 0 where no surfel is; "alpha" (h, w), the share of the pixel in which anything is, before
                the background; of one subpixel "normal" (h, w, 3), "depth" (h, w), along the view axis and infinite
                where nothing is, "index" (h, w) of the surfel, -1 where nothing is, and -2 - k where the scene's area
                light number k is; and "level" (h, w), the entry of `levels` there (of a meshless basis at the very
                place), or NaN. That is the middle one, of even samples the one right below the pixel's middle.
            direct: "interpolated" between surfels, or "traced": by rays from what every subpixel sees, slower, with
                sharp shadows whatever the surfels.
            rays: of what is traced, from each subpixel to the sky; see irradiance_at.
            culling: False shows surfaces from behind, too, in the colours of their fronts.
            threads: at most this many, where OpenGL does not draw; None for all.
            progress: True for a bar on stderr, or a callback (done, total) -> bool, where False cancels.

        Returns:
            (h, w, 3) float32, linear radiance, row 0 on top; or the dict.

        Raises:
            ValueError: an argument out of range, by name; "traced" of a solution from a file.
            DeviceError: there is no OpenGL; says what was tried.
            Cancelled: the callback returned False.

        >>> import surflux as sf
        >>> floor = sf.Surfels.from_mesh(([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]]), patch_area=0.1)
        >>> solution = sf.solve(sf.Scene([floor], lights=[sf.Environment(1.0)]))
        >>> layers = solution.render(sf.Camera([0.5, -1, 2], [0.5, 0.5, 0]), (40, 30), layers=["radiance", "depth"])
        >>> layers["radiance"][15, 20].round(3), layers["depth"][15, 20].round(2)
        (array([0.5, 0.5, 0.5], dtype=float32), np.float32(2.46))
        """
        names = rendering.layer_names(layers)
        view = rendering.View(self, camera, size, background, samples, culling, direct, rays)
        with thread_limit(threads), progress_callback(progress, "picture") as callback:
            found = rendering.picture(self, view, names, callback)
        return found if layers is not False else found["radiance"]

    radiance_towards, estimate_error = towards.radiance_towards, estimating.estimate_error
    save = saving.save
    animate, plot, to_pyvista, values = showing.animate, showing.plot, showing.to_pyvista, showing.values

    def per_face(self, name: Literal["irradiance", "direct", "radiosity"] = "irradiance", object: int = 0) -> Floats:
        """What was found, on the faces of the mesh that an object was made of: back to where it came from.

        Args:
            name: "irradiance", "direct" or "radiosity".
            object: index of it in scene.objects, made by Surfels.from_mesh.

        Returns:
            (f, 3): means by area over the patches of each face, with those behind it (two_sided); of patches that two
            coplanar triangles share each has the part in it. NaN of one that has none, for it has no area or was not
            among the surfels.

        Raises:
            ValueError: another name; an object that is not there, or not of a mesh; a solution from a file.

        >>> import surflux as sf
        >>> floor = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]]
        >>> solution = sf.solve(sf.Scene([sf.Surfels.from_mesh(floor, 0.1)], lights=[sf.Environment(1.0)]))
        >>> print(solution.per_face().round(3))
        [[3.142 3.142 3.142]
         [3.142 3.142 3.142]]
        """
        check.choice("name", name, ("irradiance", "direct", "radiosity"))
        if self._scene is None:
            raise ValueError("per_face: wanted a solution with its scene, which a file does not hold")
        object = check.count("object", object, 0, len(self._scene.objects) - 1)
        faces = self._scene.objects[object]._faces
        if faces is None:
            raise ValueError(f"object: wanted one of Surfels.from_mesh, but object {object} is not")
        return means_of_faces(self, getattr(self, name), object, faces)

    def per_surfel(self, name: Literal["irradiance", "direct", "radiosity"] = "irradiance") -> Floats:
        """What was found, at the surfels of the scene: those that were inserted in place of one give it their mean.

        Args:
            name: "irradiance", "direct" or "radiosity".

        Returns:
            (n, 3), by the rows of scene.surfels: means by area.

        Raises:
            ValueError: another name.

        >>> import surflux as sf
        >>> floor = sf.Surfels.from_mesh(([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]]), patch_area=0.3)
        >>> solution = sf.solve(sf.Scene([floor], lights=[sf.Environment(1.0)]))
        >>> solution.per_surfel().shape
        (4, 3)
        """
        check.choice("name", name, ("irradiance", "direct", "radiosity"))
        return means_of_parents(self.parents, self.surfels.areas, getattr(self, name))
