"""Films of a scene that stays, under light that changes: each frame is relit and drawn."""

from surflux._base import check
from surflux.pictures.animation import write_frames
from surflux.pictures.framing import own_or_framing
from surflux.solutions.painting import Painter


def write_relit(relit, count, path, size, *, scene, dark, camera, **options):
    """Writes frames, of which OpenGL draws the first alone, as long as no lamp moves that is seen.

    Args:
        relit: function of a frame, from 0 on: its Solution.
        count: of frames, at least 1.
        path, size: see Solution.animate.
        scene: Scene of all frames, whose camera it is unless another is given.
        dark: (n,) which surfels no frame lights: they are not blended with others.
        camera: Camera or None.
        options: fps, exposure, stops, filmic and progress, see Solution.animate; all else goes to Solution.render.

    Returns:
        list of the Paths written.
    """
    if camera is None and isinstance(size, (tuple, list)) and len(size) == 2:
        camera = own_or_framing(scene.camera, scene.surfels, [check.count("size", side) for side in size])
    painter = Painter(dark)  # the same surfels in all frames: what is dark in one of them is not what is never lit

    def drawn(k, **settings):
        return painter.layers(relit(k), camera, size, **settings)

    return write_frames(drawn, count, path, size, **options)
