"""`surflux check`: normals that point inwards, rooms, and surfaces that lie in one place."""

import numpy as np

import surflux as sf
from surflux import _core
from surflux._base import check
from surflux._base.passes import progress_callback, thread_limit
from surflux.geometry.orientation import inward_and_unsure
from surflux.meshes.winding import opposite_edges
from surflux.scenes.coincidence import coincidence_of, rounded_for
from surflux.solving.light_on_backs import lamps_in_bodies

LISTED = 10  # of the largest patches
# Directions from a place, and the share of them in which it has fronts of a room all around.
DIRECTIONS, ALL_AROUND = 256, 0.9


def checked(options, scene, mesh=None, points=None):
    """What is found in a scene: a dict for programs, and lines of text. Writes options.output, if any.

    mesh: the Mesh that it was made of, if it was one. points: Points that it was made of, which keep all they have.
    """
    cloud = scene.surfels
    wrong, unclear, doubted, rooms, number = [], [], [], [], 0
    for index, one in enumerate(scene.objects):
        patches, facing_in, unsure, inside = _sides_of(one, _witnesses(scene, options.viewpoint), options)
        wrong.append(np.where(patches > 0, patches + number, 0))
        number += int(patches.max(initial=0))
        unclear.append(facing_in)
        doubted.append(unsure)
        if inside is not None:
            rooms.append((index, inside))
    patches, unclear, unsure = np.concatenate(wrong), np.concatenate(unclear), np.concatenate(doubted)
    coincident, lines = coincidence_of(scene)
    lamps = list(lamps_in_bodies(scene.lights, scene._to_core())) if scene.lights else []
    lines += [text for _, _, text in lamps]
    sizes = np.bincount(patches)[1:]
    order = np.argsort(-sizes, kind="stable")
    largest = [(int(sizes[k]), cloud.points[patches == k + 1].mean(axis=0)) for k in order[:LISTED]]
    counts = {"surfels": len(cloud), "inward": int(sizes.sum()), "patches": len(sizes)}
    counts |= {"unclear": int(unclear.sum()), "unsure": int(unsure.sum())}
    result = {"input": options.input, **counts, **coincident}
    result["lamps_on_backs"] = [{"light": index, "share": share} for index, share, _ in lamps]
    of_mesh = _inward_faces(scene.objects[0], patches > 0) if len(scene.objects) == 1 else None
    result |= {} if of_mesh is None else {"inward_faces": np.flatnonzero(of_mesh)}
    result |= {"largest": [{"surfels": size, "center": center} for size, center in largest], "output": options.output}

    place = rounded_for(cloud)
    if mesh is not None:
        edges = opposite_edges(mesh)
        result["opposite_edges"] = len(edges)
        if len(edges):
            lines.append(
                f"{check.counted(len(edges), 'edge')} shared by faces that are wound opposite ways, so that one of "
                f"them faces the other side, the first around ({place(edges[0].mean(axis=0))})"
            )
    for index, inside in rooms:
        lines.append(f"object {index} is a room: {inside} stands inside, and sees fronts all around")
    counted = check.counted(len(cloud), "surfel")
    if len(sizes):
        many = "1 patch" if len(sizes) == 1 else f"{len(sizes)} patches"
        lines.append(f"{counted}, {sizes.sum()} of them point inwards, in {many}")
        lines += [f"  {size} around ({place(center)})" for size, center in largest]
        if len(sizes) > LISTED:
            lines.append(f"  ... and {len(sizes) - LISTED} smaller ones")
        lines += _faces_text(of_mesh)
        flag = " --bodies" if options.bodies else " --rooms" if options.rooms else ""
        lines += _next_step(options, flag, rooms=not options.bodies)
    else:
        known = "is known to point" if unsure.any() else "points"
        lines.append(f"{counted}, none in a patch that {known} inwards")
    if unclear.any():
        around = place(cloud.points[unclear].mean(axis=0))
        lines.append(
            f"{int(unclear.sum())} surfels around ({around}) face a common interior: a room seen from inside, which is "
            "right (--rooms says so), or a body turned inside out (--bodies)"
        )
        lines += _next_step(options, " --bodies", rooms=False, condition="if it is a body, ")
    if unsure.any():
        around = place(cloud.points[unsure].mean(axis=0))
        lines.append(
            f"{int(unsure.sum())} surfels around ({around}) stand on lines along which normals change sides: a part of "
            "their surface may be turned over, and points that are so far apart do not tell which. `surflux view` "
            "shows it; Surfels.flipped turns round what lies to one side"
        )
    if options.output:
        turned = cloud.flipped(patches > 0)
        turned.save(options.output) if points is None else points.save(options.output, turned)
        lines.append(f"{'surfels turned round' if len(sizes) else 'no surfel turned round'}: {options.output}")
    return result, lines


def _sides_of(one, witnesses, options):
    """Patches that point the wrong way, surfels of sheets that are rooms or turned inside out, those where
    normals change sides, and what is inside.
    """

    def found(rooms):
        with thread_limit(options.threads), progress_callback(True, "inward") as callback:
            return inward_and_unsure(one, rooms, options.smallest, callback=callback)

    nothing = np.zeros(len(one), bool)
    if options.rooms:
        patches, unsure = found(True)
        return patches, nothing, unsure, None
    bodies, unsure = found(False)
    if options.bodies or not bodies.any():
        return bodies, nothing, unsure, None
    rooms, _ = found(True)
    # Where rays say of most of a sheet that it faces inwards, its surfels are right by one reading alone.
    facing_in = (bodies > 0) != (rooms > 0)
    if not facing_in.any():
        return bodies, nothing, unsure, None
    inside = next((name for name, at in witnesses if _sees_fronts_all_around(one, at)), None)
    if inside is not None:
        return rooms, nothing, unsure, inside
    return _renumbered(np.where(facing_in, 0, bodies)), facing_in, unsure, None


def _inward_faces(one, inward):
    """(f,) booleans: faces of a mesh most of whose area lies in surfels that point inwards (n,); None of no mesh."""
    if one.faces is None:
        return None
    surfel, face, share = one._faces.shares(one)
    areas, count = share * one.areas[surfel], one._faces.count
    return np.bincount(face, areas * inward[surfel], count) > 0.5 * np.bincount(face, areas, count)


def _faces_text(inward):
    """How many faces point inwards (f,), and which, as lines."""
    if inward is None or not inward.any():
        return []
    numbers = np.flatnonzero(inward)
    if len(numbers) == len(inward):
        return ["these are all faces of the mesh: `surflux solve --normals flip` turns all of them"]
    points = "points" if len(numbers) == 1 else "point"
    of = check.counted(len(inward), "face")
    return [f"of {of} of the mesh {len(numbers)} {points} inwards, numbered from 0: {check.listed(numbers, LISTED)}"]


def _witnesses(scene, viewpoint):
    """What stands in the air of a scene: names and places."""
    if viewpoint is not None:
        yield "the viewpoint", np.asarray(viewpoint, float)
    if scene.camera is not None:
        yield "the camera", np.asarray(scene.camera.eye, float)
    for k, light in enumerate(scene.lights):
        if isinstance(light, (sf.PointLight, sf.SpotLight, sf.PhotometricLight)):
            yield f"light {k}", np.asarray(light.position)
        elif isinstance(light, sf.AreaLight):
            yield f"light {k}", np.asarray(light.corner) + 0.5 * np.add(light.edge_u, light.edge_v)


def _sees_fronts_all_around(one, at):
    k = np.arange(DIRECTIONS) + 0.5
    z = 1.0 - 2.0 * k / DIRECTIONS
    phi = np.pi * (1.0 + np.sqrt(5.0)) * k
    directions = np.column_stack([np.sqrt(1.0 - z * z) * np.cos(phi), np.sqrt(1.0 - z * z) * np.sin(phi), z])
    scene = _core.Scene([one._core], [])
    met, _ = _core.seen_fronts(scene, np.tile(at, (DIRECTIONS, 1)), directions)
    return np.mean(met >= 0) >= ALL_AROUND


def _renumbered(patches):
    """The same patches, numbered from 1 without gaps."""
    return np.unique(np.append(patches, 0), return_inverse=True)[1][:-1]


def _next_step(options, flags, *, rooms, condition=""):
    if options.output:
        return []
    if options.input.lower().endswith(".toml"):
        keys = "orient = true and rooms = true" if rooms else "orient = true"
        return [f"  {condition}{keys} in its [[object]] {'turn' if rooms else 'turns'} them round"]
    call = f"s.flipped(sf.inward_patches(s{', rooms=True' if rooms else ''}) > 0)"
    return [f"  {condition}`surflux check {options.input}{flags} -o OUT.ply` turns them round, as {call} does"]
