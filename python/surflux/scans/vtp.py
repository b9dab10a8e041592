"""VTK PolyData files (.vtp), for ParaView."""

from surflux._base.files import write_whole


def write_polydata(path, data):
    """Writes a pyvista.PolyData whole or not at all: VTK's writer says nothing where a disk is full, so that it writes
    to memory.

    Raises FileError.
    """
    from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter

    data._store_metadata()  # as save of pyvista does: which arrays are bool
    writer = vtkXMLPolyDataWriter()
    writer.SetInputData(data)
    writer.WriteToOutputStringOn()
    writer.Write()
    write_whole(path, writer.GetOutputString().encode())
