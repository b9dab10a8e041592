"""`surflux area`: effective areas."""

import surflux as sf
from surflux._base import check


def measured(options, cloud, points=None):
    """What is found of surfels: a dict for programs, and lines of text. Writes options.output, if any.

    points: Points that the surfels are of; None of those of scenes, and of patches, which go into a file with theirs.
    """
    knobs = {name: getattr(options, name) for name in ("kappa", "resolution", "epsilon")}
    areas = sf.effective_areas(
        cloud,
        method=options.method,
        backend=options.backend,
        threads=options.threads,
        progress=True,
        **{name: value for name, value in knobs.items() if value is not None},
    )
    if options.output:
        cloud.areas = areas
        cloud.save(options.output) if points is None else points.save(options.output, cloud)
    result = {
        "input": options.input,
        "surfels": len(cloud),
        "area": float(areas.sum()),
        "smallest": float(areas.min()),
        "largest": float(areas.max()),
        "method": options.method,
        "output": options.output,
    }
    lines = [f"{check.counted(len(cloud), 'surfel')}, area {result['area']:.6g}"]
    lines.append(f"  each from {result['smallest']:.3g} to {result['largest']:.3g}")
    if options.output:
        lines.append(f"surfels with areas: {options.output}")
    return result, lines
