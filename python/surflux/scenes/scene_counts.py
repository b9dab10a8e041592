"""How many surfels each object of a scene file comes in, so that they make a given number in all."""

import math

from surflux._base.check import counted


def shared_out(sources, wanted):
    """The count of each Source, in proportion to what the file says, so that the scene has `wanted` surfels.

    Objects that come in one number alone, patches, keep it. What rounding leaves over goes, one by one, to those that
    lost most by it.

    Raises:
        ValueError: `surfels`, where that number cannot be had.
    """
    counts = [source.count for source in sources]
    free = [k for k, source in enumerate(sources) if source.fewest < source.most]
    fixed = sum(n * source.sides for n, source in zip(counts, sources, strict=True)) - sum(
        counts[k] * sources[k].sides for k in free
    )
    least = fixed + sum(sources[k].fewest * sources[k].sides for k in free)
    if wanted < least:
        patches = f", {fixed} of them patches" if fixed else ""
        raise ValueError(f"surfels: wanted at least {least}{patches}, for this scene has no fewer; got {wanted}")
    if not free and wanted > fixed:
        raise ValueError(f"surfels: wanted {fixed}, for all of this scene are patches; got {wanted}")

    # Objects at their fewest drop out, and the others share the rest: again until no more do.
    sharing = list(free)
    while True:
        rest = wanted - fixed - sum(counts[k] * sources[k].sides for k in free if k not in sharing)
        scale = rest / max(1, sum(sources[k].count * sources[k].sides for k in sharing))
        small = [k for k in sharing if sources[k].count * scale < sources[k].fewest]
        for k in small:
            counts[k] = sources[k].fewest
        sharing = [k for k in sharing if k not in small]
        if not small:
            break
    exact = {k: sources[k].count * scale for k in sharing}
    for k in sharing:
        counts[k] = math.floor(exact[k] + 1e-9)
    left = wanted - fixed - sum(counts[k] * sources[k].sides for k in free)
    while left > 0:
        able = [k for k in sharing if sources[k].sides <= left]
        if not able:
            raise ValueError(f"surfels: wanted one more or one less, for two-sided surfels come in pairs; got {wanted}")
        k = max(able, key=lambda k: (exact[k] - counts[k], -k))
        counts[k] += 1
        left -= sources[k].sides
    for k in free:
        if counts[k] > sources[k].most:
            raise ValueError(
                f"surfels: wanted fewer, for object {k + 1} would have to come in {counts[k]} and there "
                f"{'is' if sources[k].most == 1 else 'are'} only {counted(sources[k].most, 'surfel')}; got {wanted}"
            )
    return counts
