"""Particles in the layout of VTK and PyVista, without needing either.

    arrays = vtk_arrays(run.frames[-1])
    cloud = pyvista.PolyData(arrays["points"])          # or to_pyvista(run.frames[-1])
    cloud.point_data.update(arrays["point_data"])
"""

import base64
import xml.etree.ElementTree as xml

import numpy as np

from mpmtools.errors import InputError
from mpmtools.files import whole_file
from mpmtools.frame import by_components

VTK_TYPES = {"f8": "Float64", "f4": "Float32", "i8": "Int64", "i4": "Int32", "u8": "UInt64", "u4": "UInt32", "u1": "UInt8", "i1": "Int8"}
NOT_DATA = {"vertex"}  # a frame's own list of cells, for frames.xdmf


def vtk_arrays(frame, whole=True):
    """The particles of a Frame as VTK wants them:

    points      (n, 3) float64, position, m
    vertices    (2 n,) int64: 1, 0, 1, 1, 1, 2, ...: one cell a particle, as PyVista's `verts` and VTK's legacy cell arrays have it
    point_data  {name: (n,) or (n, components)}, C-contiguous: every array of the frame besides the position, and speed_m_s

    whole: where half of a flow is computed, the other half is added (mirror planes x = 0 and y = 0).
    """
    read = frame.whole if whole else frame.__getitem__
    points = np.ascontiguousarray(read("position_m"), dtype=np.float64)
    data = {name: np.ascontiguousarray(by_components(array)) for name in frame
            if name not in NOT_DATA | {"position_m"} and len(array := read(name)) == len(points)}
    if "velocity_m_s" in data:
        data["speed_m_s"] = np.linalg.norm(data["velocity_m_s"], axis=1)
    vertices = np.empty(2 * len(points), np.int64)
    vertices[0::2], vertices[1::2] = 1, np.arange(len(points))
    return {"points": points, "vertices": vertices, "point_data": data}


def to_pyvista(frame, whole=True):
    """The particles of a Frame as pyvista.PolyData. Raises InputError where PyVista is not installed."""
    try:
        import pyvista
    except ImportError:
        raise InputError("PyVista is not installed (pip install pyvista); vtk_arrays and write_vtp work without it") from None
    arrays = vtk_arrays(frame, whole)
    cloud = pyvista.PolyData(arrays["points"], verts=arrays["vertices"])
    cloud.point_data.update(arrays["point_data"])
    return cloud


def write_vtp(frame, path, whole=True):
    """Writes the particles of a Frame as a VTK file (.vtp, binary) for ParaView, VisIt and VTK."""
    arrays = vtk_arrays(frame, whole)
    count = len(arrays["points"])
    file = xml.Element("VTKFile", type="PolyData", version="1.0", byte_order="LittleEndian", header_type="UInt64")
    piece = xml.SubElement(xml.SubElement(file, "PolyData"), "Piece", NumberOfPoints=str(count), NumberOfVerts=str(count))
    point_data = xml.SubElement(piece, "PointData")
    for name, array in arrays["point_data"].items():
        _add_array(point_data, name, array)
    _add_array(xml.SubElement(piece, "Points"), "position_m", arrays["points"])
    cells = xml.SubElement(piece, "Verts")
    _add_array(cells, "connectivity", np.arange(count, dtype=np.int64))
    _add_array(cells, "offsets", np.arange(1, count + 1, dtype=np.int64))
    with whole_file(path) as temporary:
        xml.ElementTree(file).write(temporary, encoding="utf-8", xml_declaration=True)


def _add_array(parent, name, array):
    """Inline binary: the number of bytes as UInt64, then the values, in base64."""
    values = np.ascontiguousarray(array)
    kind = VTK_TYPES[values.dtype.newbyteorder("=").str[1:]]
    data = values.astype(values.dtype.newbyteorder("<")).tobytes()
    element = xml.SubElement(parent, "DataArray", type=kind, Name=name, format="binary")
    if values.ndim == 2:
        element.set("NumberOfComponents", str(values.shape[1]))
    element.text = base64.b64encode(np.uint64(len(data)).tobytes() + data).decode()
