"""The window in which lamps are moved: what it shows, without the mouse and the keys."""

import numpy as np

from surflux.drawing.clicks import sight_ray
from surflux.pictures.framing import own_or_framing
from surflux.scenes.lights import AreaLight
from surflux.viewing.lamp_place import lamp_in_view
from surflux.viewing.lamps import Lamp
from surflux.viewing.relit_window import RelitView
from surflux.viewing.traced_light import TracedLight

_RADIUS, _CHOSEN = 0.015, 1.5  # of a lamp, over the extent, and of the chosen one over that of others
_QUICK = 4096  # shadow rays of light while something is dragged


class LampView(RelitView):
    """A view of a scene under lamps that can be changed; while one is dragged, direct light is found by one ray.

    Args:
        transfer: LocalTransfer.
        lights: list of lights; None for a point light that lights what is seen, as `lamp_in_view` places it.
        camera: Camera that it is to look through; None for the scene's own, or one that has all in view.
        size: (width, height) in pixels.
        options: see RelitView.

    Attributes:
        traced: whether direct light is that of every pixel. Set by `trace`.
        lamps: list of Lamp. chosen: index of the one that sliders and keys change.
        handles: the vtkSphereWidget of each lamp that has a place, by index, since `hold`.
    """

    def __init__(self, transfer, lights, camera=None, *, size=(800, 600), **options):
        self.transfer = transfer
        self.chosen, self.handles, self._held, self._spheres = 0, {}, None, 0
        self.traced, self._picture = False, None
        if lights is None:
            scene = transfer.scene
            looks = own_or_framing(scene.camera if camera is None else camera, scene.surfels, size)
            lights = [lamp_in_view(scene, looks, size)]
        solution = self.timed(transfer.relight, lights)  # which refuses what is no lamp
        self.lamps = [Lamp.of(light) for light in lights]
        super().__init__(solution, size=size, **options)

    def lights(self):
        """The lights as they are now."""
        return [lamp.light for lamp in self.lamps]

    def found(self, quick):
        lights = self.lights()
        if not quick:
            return self.transfer.relight(lights)
        return self.transfer._relit(lights, self.transfer._given(lights, None, None, _QUICK, 0), 1, 1)

    def trace(self, traced):
        """Shows direct light at every pixel, as LampRenderer draws it, or at every surfel."""
        self.traced = traced
        if traced:
            self._picture = self._picture or TracedLight(self)
            self.timed(self._picture.draw)
        else:
            self._picture.remove()
        self.say_light()
        self.describe(self.shown())

    def turning(self, begins):
        """While the camera moves, surfels stand in for the picture of it."""
        if self.traced and begins:
            self._picture.remove()
        elif self.traced:
            self._picture.draw()

    def relight(self, quick=False):
        if not (self.traced and quick):
            super().relight(quick)
            return
        if self.picked is not None:
            self.pick(None)
        self.subject.lamps = [light for light in self.lights() if isinstance(light, AreaLight)]
        self._draw_lamps()
        self.timed(self._picture.draw)
        self.say_light()
        self.describe(self.shown())

    def redraw(self):
        super().redraw()
        if self.traced:
            self._picture.draw()

    def frame(self, camera=None):
        super().frame(camera)
        if self.traced:
            self._picture.draw()

    def choose(self, index):
        """Makes a lamp the one that sliders and keys change."""
        self.chosen = index % len(self.lamps) if self.lamps else 0
        self.say_light()
        self._draw_lamps()
        self.describe(self.shown())

    def lamp(self):
        """The chosen Lamp, or None."""
        return self.lamps[self.chosen] if self.lamps else None

    def add(self):
        """A point light more, placed for what is seen now."""
        self.lamps.append(Lamp.of(lamp_in_view(self.transfer.scene, self.camera(), self.plotter.window_size)))
        self.chosen = len(self.lamps) - 1
        self.relight()

    def remove(self):
        """Takes the chosen lamp away."""
        if self.lamps:
            self.lamps.pop(self.chosen)
            self.chosen = max(0, min(self.chosen, len(self.lamps) - 1))
            self.relight()

    def move(self, index, center, quick=True):
        """Puts a lamp at a place of the window, which is drawn around the middle of the scene; it is the chosen one."""
        self.chosen = index
        self.lamps[index].move_to(np.asarray(center) + self.subject.origin())
        self.relight(quick)

    def nearer(self, factor):
        """Moves the chosen lamp along the line of sight: its distance from the eye is `factor` of what it was."""
        lamp = self.lamp()
        if lamp is not None and lamp.place is not None:
            eye = self.camera().eye
            lamp.move_to(eye + factor * (lamp.place - eye))
            self.relight()

    def hold(self, dragged, dropped):
        """Makes the spheres that stand for lamps handles, which the mouse drags.

        Args:
            dragged: called with a lamp's index and the centre of its sphere in the window, whenever it has moved.
            dropped: called with the index, when the mouse has let it go.
        """
        self._held = dragged, dropped
        for index in range(len(self.lamps)):
            self.plotter.remove_actor(f"lamp {index}", render=False)
        self._draw_lamps()

    def say_light(self):
        lamp = self.lamp()
        if lamp is None:
            self.note = "no lamp"
        else:
            self.note = (
                f"lamp {self.chosen + 1} of {len(self.lamps)}: {lamp.words()}\nrelit in {1000 * self.seconds:.3g} ms"
            )

    def _take(self, subject):
        super()._take(subject)
        self._draw_lamps()

    def _draw_lamps(self):
        """Spheres for lamps that have a place; area lights shine by themselves, too."""
        super()._draw_lamps()
        for index in range(max(len(self.lamps), self._spheres)):
            place = self.lamps[index].place if index < len(self.lamps) else None
            if place is None:
                self.plotter.remove_actor(f"lamp {index}", render=False)
                if index in self.handles:
                    self.handles.pop(index).Off()
                continue
            radius = _RADIUS * self.extent * (_CHOSEN if index == self.chosen else 1.0)
            draw = self._draw_sphere if self._held is None else self._draw_handle
            draw(index, place - self.subject.origin(), radius, tuple(self.lamps[index].color))
        self._spheres = len(self.lamps)

    def _draw_sphere(self, index, center, radius, color):
        import pyvista

        self.draw(f"lamp {index}", pyvista.Sphere(radius=radius, center=center), color=color)

    def _draw_handle(self, index, center, radius, color):
        if index not in self.handles:
            dragged, dropped = self._held
            handle = self.plotter.add_sphere_widget(
                lambda _: dragged(index, self._under_mouse()),
                center=center,
                radius=radius,
                interaction_event="always",
                test_callback=False,
            )
            handle.ScaleOff()
            handle.AddObserver("StartInteractionEvent", lambda *_: self._grab(index))
            handle.AddObserver("EndInteractionEvent", lambda *_: dropped(index))
            handle.GetSphereProperty().LightingOff()
            handle.GetSelectedSphereProperty().LightingOff()
            self.handles[index] = handle
        handle = self.handles[index]
        handle.SetCenter(*center)
        handle.SetRadius(radius)
        handle.GetSphereProperty().SetColor(color)
        handle.GetSelectedSphereProperty().SetColor(color)

    def _grab(self, index):
        """Keeps where the mouse took hold of a sphere, which stays below it."""
        renderer, center = self.plotter.renderer, np.array(self.handles[index].GetCenter())
        renderer.SetWorldPoint(*center, 1.0)
        renderer.WorldToDisplay()
        self._grip = center, np.subtract(renderer.GetDisplayPoint()[:2], self.plotter.iren.get_event_position())

    def _under_mouse(self):
        """Where the sphere belongs that is held: at the depth that it had. (VTK would take that of the focal point.)"""
        center, offset = self._grip
        start, direction = sight_ray(self.plotter.renderer, *np.add(self.plotter.iren.get_event_position(), offset))
        forward = np.array(self.plotter.camera.direction)
        return start + direction * ((center - start) @ forward / (direction @ forward))
