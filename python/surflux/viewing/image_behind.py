"""A picture that fills a window, behind all else in it."""


class ImageBehind:
    """An actor of a plotter; nothing is seen of it before `show`.

    Args:
        plotter: pyvista.Plotter.
        name: of the actor.
    """

    def __init__(self, plotter, name):
        from vtkmodules.vtkCommonDataModel import vtkImageData
        from vtkmodules.vtkRenderingCore import vtkActor2D, vtkImageMapper

        self._plotter, self._name = plotter, name
        self._image, mapper, self._actor = vtkImageData(), vtkImageMapper(), vtkActor2D()
        mapper.SetInputData(self._image)
        mapper.SetColorWindow(255.0)
        mapper.SetColorLevel(127.5)
        self._actor.SetMapper(mapper)
        self._actor.GetProperty().SetDisplayLocationToBackground()

    def put(self, picture):
        """Takes another picture, (h, w, 3) uint8, as large as the window."""
        from vtkmodules.util.numpy_support import numpy_to_vtk

        height, width, _ = picture.shape
        self._image.SetDimensions(width, height, 1)
        # VTK counts rows from below.
        self._image.GetPointData().SetScalars(numpy_to_vtk(picture[::-1].reshape(-1, 3), deep=True))
        self._image.Modified()

    def show(self):
        self._plotter.add_actor(self._actor, name=self._name, reset_camera=False, pickable=False)

    def hide(self):
        self._plotter.remove_actor(self._name, render=False)
