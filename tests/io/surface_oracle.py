"""Reads and writes surfaces with VTK, as an oracle that shares no code with Lode.

surface_oracle.py read FILE...  prints a line for each file: points, cells, six bounds, and the
                                range of the point array "isovalue" (nan nan without it)
surface_oracle.py write DIR     writes one sphere in many forms to DIR and prints a line for each:
                                file, points, cells, six bounds
"""
import math
import os
import sys

from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkFiltersCore import vtkAppendPolyData
from vtkmodules.vtkFiltersSources import vtkSphereSource
from vtkmodules.vtkIOGeometry import (vtkGLTFReader, vtkOBJReader, vtkOBJWriter, vtkSTLReader,
                                      vtkSTLWriter)
from vtkmodules.vtkIOPLY import vtkPLYReader, vtkPLYWriter
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader, vtkXMLPolyDataWriter


def read(path):
    readers = {
        ".ply": vtkPLYReader,
        ".stl": vtkSTLReader,
        ".obj": vtkOBJReader,
        ".vtp": vtkXMLPolyDataReader,
        ".glb": vtkGLTFReader,
    }
    reader = readers[os.path.splitext(path)[1]]()
    reader.SetFileName(path)
    reader.Update()
    output = reader.GetOutputDataObject(0)
    if not output.IsA("vtkMultiBlockDataSet"):
        return output
    append = vtkAppendPolyData()
    append.AddInputData(vtkPolyData())
    iterator = output.NewIterator()
    while not iterator.IsDoneWithTraversal():
        append.AddInputData(iterator.GetCurrentDataObject())
        iterator.GoToNextItem()
    append.Update()
    return append.GetOutput()


def describe(surface):
    counts = [surface.GetNumberOfPoints(), surface.GetNumberOfCells()]
    bounds = surface.GetBounds() if counts[0] else (0.0,) * 6
    return " ".join(map(repr, counts + list(bounds)))


def describe_isovalues(surface):
    array = surface.GetPointData().GetArray("isovalue")
    return " ".join(map(repr, array.GetRange() if array else (math.nan, math.nan)))


def write(writer, path, surface):
    writer.SetInputData(surface)
    writer.SetFileName(path)
    writer.Write()
    print(path, describe(surface))


def write_all(directory):
    sphere = vtkSphereSource()
    sphere.SetThetaResolution(40)
    sphere.SetPhiResolution(30)
    sphere.SetCenter(1.5, 2.25, -3)
    sphere.Update()
    surface = sphere.GetOutput()
    for name, make in (("ply", vtkPLYWriter), ("stl", vtkSTLWriter)):
        for form in ("ASCII", "Binary"):
            writer = make()
            getattr(writer, "SetFileTypeTo" + form)()
            write(writer, f"{directory}{form}.{name}", surface)
    write(vtkOBJWriter(), f"{directory}x.obj", surface)
    for mode in ("Ascii", "Binary", "Appended"):
        for compressor in ("None", "ZLib"):
            for encode in (0, 1):
                for header in (32, 64):
                    writer = vtkXMLPolyDataWriter()
                    getattr(writer, f"SetDataModeTo{mode}")()
                    getattr(writer, f"SetCompressorTypeTo{compressor}")()
                    writer.SetBlockSize(4096)
                    writer.SetEncodeAppendedData(encode)
                    writer.SetHeaderType(header)
                    if header == 64:
                        writer.SetByteOrderToBigEndian()
                    name = f"{directory}{mode}{compressor}{encode}{header}.vtp"
                    write(writer, name, surface)


if __name__ == "__main__":
    if sys.argv[1] == "write":
        write_all(sys.argv[2])
    else:
        for name in sys.argv[2:]:
            polydata = read(name)
            print(describe(polydata), describe_isovalues(polydata))
