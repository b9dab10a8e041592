"""`surflux solve CLOUD --normals HOW`: which side of a cloud is lit."""

TEXT = (
    'of a file of points: "check" (default) turns over what faces inwards, and says so, "keep" takes them as they are, '
    '"flip" turns all points over'
)


def facing_cloud(options, read):
    """The cloud that read(options, orient) gives, with normals as --normals has them; around --eye, a room closes."""
    if options.normals == "keep":
        return read(options, False)
    if options.normals == "flip":
        return read(options, False).flipped()
    return read(options, True if options.eye is None else options.eye)
