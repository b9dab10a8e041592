"""Mitsuba 3 beside ours: irradiance at places of a scene of polygons, by its `path` integrator.

Its camera is one ray for each sample, from a hair in front of the place straight onto it: the radiance it returns is
(E + rho H) / pi, and from that hit on Mitsuba samples lights by itself. Black places reflect nothing to look at: there
the rays leave the place, cosine-distributed, as the light that they would reflect.
"""

import sys

import numpy as np

DARK = 1e-3  # reflectance below which a place counts as black
RAYS_AT_ONCE = 2_000_000


def load(threads=None):
    """The module mitsuba with a variant set, vectorized with LLVM where that can be had; None where it is not there.

    Says on stderr what is left out, and why.
    """
    try:
        import drjit
        import mitsuba
    except ModuleNotFoundError:
        print("bench: Mitsuba left out: it is not installed (pip install 'surflux[bench]')", file=sys.stderr)
        return None
    try:
        mitsuba.set_variant("llvm_ad_rgb")
        drjit.eval(mitsuba.Float(1.0) + 1.0)
    except (ImportError, RuntimeError):
        mitsuba.set_variant("scalar_rgb")
    if threads is not None:
        drjit.set_thread_count(threads)
    return mitsuba


def is_vectorized(mitsuba):
    return mitsuba.variant().startswith("llvm")


class Renderer:
    """Mitsuba's path integrator, without a limit to the number of bounces, on a scene of its own."""

    def __init__(self, mitsuba, scene):
        self.mitsuba, self.scene = mitsuba, scene
        self.integrator = mitsuba.load_dict({"type": "path", "max_depth": -1})
        box = scene.bbox()
        self._hair = 1e-4 * float(np.linalg.norm(np.array(box.max) - np.array(box.min)))

    @classmethod
    def of_surfels(cls, mitsuba, scene):
        """The same triangles, reflectances and emissions as a Scene without lights or disks."""
        if scene.lights or any(len(np.unique(s.triangle_surfel)) < len(s) for s in scene.objects):
            raise ValueError("scene: wanted polygons alone, and no lights but those that emit")
        content = {"type": "scene"}
        for k, s in enumerate(scene.objects):
            emission = s.emission[s.triangle_surfel]
            # An emitter of Mitsuba has one radiance for all its mesh.
            for i, glow in enumerate(np.unique(emission, axis=0)):
                rows = np.all(emission == glow, axis=1)
                rho = s.reflectance[s.triangle_surfel[rows]]
                content[f"mesh_{k}_{i}"] = _mesh(mitsuba, s.triangles[rows], rho, glow)
        return cls(mitsuba, mitsuba.load_dict(content))

    def meets(self, points, normals):
        """(n,) bool: does the ray onto each point meet the front of a surface there first?"""
        if not is_vectorized(self.mitsuba):
            found = [self.scene.ray_intersect(ray) for ray in self._single_rays(points, normals)]
            distance, facing = np.array([hit.t for hit in found]), np.array([np.array(hit.n) for hit in found])
        else:
            hit = self.scene.ray_intersect(self._rays(points, normals))
            distance, facing = np.array(hit.t), np.array(hit.n).T
        return (np.abs(distance / self._hair - 1.0) < 0.1) & (np.sum(facing * normals, axis=1) > 0.0)

    def irradiance(self, places, normals, reflectance, emission, seed=0, batches=1, sampler="multijitter"):
        """Means over places (n, k, 3) of n surfels, one path each, with normals, reflectance and emission (n, 3).

        Returns (n, batches, 3), each batch from k / batches places in a row.
        """
        n, k = places.shape[:2]
        out = np.empty((n, batches, 3))
        dark = reflectance.min(axis=1) < DARK
        step = max(1, RAYS_AT_ONCE // k)
        for rows in (np.nonzero(~dark)[0], np.nonzero(dark)[0]):
            for first in range(0, len(rows), step):
                some = rows[first : first + step]
                away = bool(dark[some[0]])
                flat, facing = places[some].reshape(-1, 3), np.repeat(normals[some], k, axis=0)
                radiance = self._radiance(flat, facing, k, batches, away, [seed, first], sampler)
                found = np.pi * radiance.reshape(len(some), batches, 3)
                out[some] = found if away else (found - emission[some, None]) / reflectance[some, None]
        return out

    def _radiance(self, places, normals, k, batches, away, seed, kind):
        mi = self.mitsuba
        sampler = mi.load_dict({"type": kind, "sample_count": k})
        seed = int(np.random.default_rng(seed).integers(2**31))
        if not is_vectorized(mi):
            sampler.seed(seed)
            found = [self._one(ray, normal, away, sampler) for ray, normal in self._single_rays(places, normals, True)]
            return np.array(found).reshape(-1, k // batches, 3).mean(axis=1)
        import drjit

        sampler.set_samples_per_wavefront(k)
        sampler.seed(seed, len(places))
        ray = self._rays(places, normals)
        if away:
            frame = mi.Frame3f(-ray.d)
            ray.d = frame.to_world(mi.warp.square_to_cosine_hemisphere(sampler.next_2d()))
        radiance, _, _ = self.integrator.sample(self.scene, sampler, ray)
        sums = [drjit.block_reduce(drjit.ReduceOp.Add, c, k // batches) for c in (radiance.x, radiance.y, radiance.z)]
        drjit.eval(sums)
        return np.stack([np.array(c) for c in sums], axis=1) / (k // batches)

    def _rays(self, places, normals):
        mi = self.mitsuba
        origin = (places + self._hair * normals).T.astype(np.float32)
        return mi.RayDifferential3f(mi.Point3f(origin), mi.Vector3f((-normals).T.astype(np.float32)))

    def _single_rays(self, places, normals, with_normals=False):
        mi = self.mitsuba
        for place, normal in zip(places, normals, strict=True):
            ray = mi.RayDifferential3f(mi.Point3f(*(place + self._hair * normal)), mi.Vector3f(*-normal))
            yield (ray, normal) if with_normals else ray

    def _one(self, ray, normal, away, sampler):
        mi = self.mitsuba
        if away:
            frame = mi.Frame3f(mi.Vector3f(*normal))
            ray.d = frame.to_world(mi.warp.square_to_cosine_hemisphere(sampler.next_2d()))
        radiance, _, _ = self.integrator.sample(self.scene, sampler, ray)
        sampler.advance()
        return np.array(radiance)


def _mesh(mitsuba, triangles, reflectance, emission):
    """Triangles (t, 3, 3), each with its reflectance, as one mesh that emits as a whole."""
    properties = mitsuba.Properties()
    properties["face_normals"] = True
    properties["bsdf"] = mitsuba.load_dict(
        {"type": "diffuse", "reflectance": {"type": "mesh_attribute", "name": "face_reflectance"}}
    )
    if np.any(emission):
        radiance = {"type": "rgb", "value": [float(c) / np.pi for c in emission]}
        properties["emitter"] = mitsuba.load_dict({"type": "area", "radiance": radiance})
    mesh = mitsuba.Mesh("surfels", 3 * len(triangles), len(triangles), props=properties)
    values = mitsuba.traverse(mesh)
    values["vertex_positions"] = triangles.astype(np.float32).ravel()
    values["faces"] = np.arange(3 * len(triangles), dtype=np.uint32)
    values.update()
    mesh.add_attribute("face_reflectance", 3, reflectance.astype(np.float32).ravel())
    return mesh
