"""What changes in `surflux relight`: lamps that move, or an environment that turns."""

from dataclasses import replace

import numpy as np

import surflux as sf
from surflux._base import check
from surflux._base.warn import FrameWarnings, warn
from surflux.cli.pictures import write_images, write_layers
from surflux.scenes.lights import environments_among
from surflux.solving.turning_light import TurningLight

OWN = "scene"  # as an environment: that of the scene


class MovingLamps:
    """Lamps, frame by frame: of --path, or those of the scene.

    Attributes:
        lighting: of precompute_transfer.
        count: of frames.
    """

    lighting = "local"

    def __init__(self, options):
        for name in ("turntable", "turn", "export"):
            if getattr(options, name) is not None:
                raise ValueError(f"--{name}: goes with --environment, or with a transfer of distant light")
        self._name, self._seed = options.input, 0 if options.seed is None else options.seed
        self._direct = "interpolated" if options.direct is None else options.direct
        check.choice("--direct", self._direct, ("interpolated", "traced"))
        self._frames = None if options.path is None else sf.load_lamps(options.path)
        self._first = None  # the Solution of frame 0, once it was relit
        self.count = 1 if self._frames is None else len(self._frames)
        self._said = FrameWarnings(self.count)

    def take(self, scene, off_screen):
        """Takes the lamps of the scene, where there are no others, before anything is found of it."""
        if self._frames is None:
            lamps = [light for light in scene.lights if not isinstance(light, sf.Environment)]
            if len(lamps) < len(scene.lights):
                warn(f"{self._name}: its environment is left out, for transfer is that of lamps (see --environment)")
            self._frames = [lamps]
        self._dark = not any(self._frames) and not np.any(scene.surfels.emission)
        if off_screen and self._dark:
            raise ValueError(f"{self._name}: has no lamps; --path LIGHTS.toml gives it some")

    def relit(self, transfer, k):
        """The Solution of frame k, from 0 on."""
        if k == 0 and self._first is not None:
            return self._first
        with self._said.of(k):
            found = transfer.relight(self._frames[k], seed=self._seed, progress=True)
        if k == 0:
            self._first = found
        return found

    def say(self):
        """Warns of what was wrong with frames that were relit."""
        self._said.say()

    def checked(self, transfer):
        """The Solution of frame 0, with its error; it warns of lamps that light nothing."""
        self.relit(transfer, 0).estimate_error(seed=self._seed, progress=True)
        return self._first

    def what(self, transfer):
        """In words, what has that error."""
        light = "the irradiance" if self.count == 1 else "the first frame's irradiance"
        return light if transfer.bounces is None else f"{light}, beside all reflections"

    def window(self, transfer, **options):
        """The window; where nothing shines, with a lamp that move_lamps places."""
        return sf.move_lamps(transfer, None if self._dark else self._frames[0], **options)

    def write_images(self, transfer, camera, options, images, *, background, samples, culling):
        """Pictures of the first frame."""
        if self._direct == "interpolated":
            settings = {"background": background, "samples": samples, "culling": culling}
            return write_images(self.relit(transfer, 0), camera, options, images, **settings)
        renderer = sf.LampRenderer(transfer, camera, options.size, samples=samples, culling=culling, progress=True)

        def drawn(layers):
            return renderer.frame(self._frames[0], layers=layers, seed=self._seed)

        return write_layers(drawn, camera, samples, options, images, background)

    def film(self, transfer, path, size, **options):
        if self._direct == "interpolated":  # which says it of all frames
            self._said = FrameWarnings(self.count)
        return sf.animate_lamps(transfer, self._frames, path, size, seed=self._seed, direct=self._direct, **options)


class TurningEnvironment:
    """An environment, once around in the frames of --turntable: of --environment, or that of the scene.

    Attributes: those of MovingLamps.
    """

    lighting = "distant"

    def __init__(self, options, transfer):
        self._name, self._turn = options.input, 0.0 if options.turn is None else options.turn
        if isinstance(transfer, sf.LocalTransfer):
            made = 'sf.precompute_transfer(scene, "distant") makes one that takes it'
            raise ValueError(f"--environment: {options.input} is a transfer of lamps; {made}")
        if options.direct is not None:
            raise ValueError("--direct: is for lamps, which go without --environment")
        if options.path is not None:
            raise ValueError("--path: is for lamps; an environment is turned by --turntable")
        if transfer is not None and options.seed is not None:
            raise ValueError(f"--seed: is for a scene; {options.input} is precomputed")
        if options.turntable is not None and not (options.image or options.output):
            raise ValueError("--turntable: wants an --image: a film (.mp4, .gif), or a pattern such as frames/%04d.png")
        self.count = 1 if options.turntable is None else options.turntable
        self._environment = self._light = None
        if options.environment not in (None, OWN):
            up = (0.0, 0.0, 1.0) if options.up is None else options.up
            self._environment = self._turned(sf.Environment(options.environment, up))

    def _turned(self, environment):
        return replace(environment, azimuth=environment.azimuth + self._turn) if self._turn else environment

    def take(self, scene, off_screen):
        """Takes the environment of the scene, where there is no other, before anything is found of it."""
        own = environments_among(scene.lights)
        if self._environment is None:
            if len(own) != 1:
                has = f"{len(own)} environments" if own else "no environment"
                raise ValueError(f"--environment: wanted an image, for {self._name} has {has} of its own")
            self._environment = self._turned(own[0])
        if len(own) < len(scene.lights):
            warn(f"{self._name}: its lamps are left out, for transfer is that of distant light")

    def relit(self, transfer, k):
        """The Solution of frame k, from 0 on."""
        self._light = self._light or TurningLight(transfer, self._environment)
        return self._light.relight(360.0 * k / self.count)

    def say(self):
        """Nothing: distant light has no lamp that stands in something."""

    def checked(self, transfer):
        """None: its harmonics are another light than the environment that it would be checked by."""

    def window(self, transfer, **options):
        return sf.turn_environment(transfer, self._environment, **options)

    def write_images(self, transfer, camera, options, images, **settings):
        """Pictures of the first frame."""
        write_images(self.relit(transfer, 0), camera, options, images, **settings)

    def film(self, transfer, path, size, **options):
        return sf.animate_environment(transfer, self._environment, path, size, frames=self.count, **options)

    def page(self, transfer, camera, title):
        return sf.Page(transfer, environment=self._environment, camera=camera, title=title)
