"""Reads .vtu and .vtp files with VTK, as an oracle that shares no code with Lode.

mesh_oracle.py FILE...  prints a JSON object a line: points, cells, cell types, bounds, volume (of
                        tetrahedra) or area, the smallest of a cell, and of each array its type,
                        number of tuples and range
"""
import json
import os
import sys

from vtkmodules.vtkCommonCore import vtkMath
from vtkmodules.vtkCommonDataModel import vtkTetra, vtkTriangle
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader, vtkXMLUnstructuredGridReader


def read(path):
    is_mesh = os.path.splitext(path)[1] == ".vtu"
    reader = vtkXMLUnstructuredGridReader() if is_mesh else vtkXMLPolyDataReader()
    reader.SetFileName(path)
    reader.Update()
    return reader.GetOutput()


def describe_arrays(data):
    arrays = {}
    for i in range(data.GetNumberOfArrays()):
        array = data.GetArray(i)
        arrays[array.GetName()] = {
            "type": array.GetDataTypeAsString(),
            "tuples": array.GetNumberOfTuples(),
            "range": array.GetRange(),
        }
    return arrays


def measure(mesh):
    """Signed sizes of all cells: VTK's own formulas."""
    sizes = []
    for i in range(mesh.GetNumberOfCells()):
        cell = mesh.GetCell(i)
        points = [cell.GetPoints().GetPoint(k) for k in range(cell.GetNumberOfPoints())]
        if len(points) == 4:
            sizes.append(vtkTetra.ComputeVolume(*points))
        elif len(points) == 3:
            sizes.append(vtkTriangle.TriangleArea(*points))
        else:
            sizes.append(vtkMath.Distance2BetweenPoints(*points) ** 0.5)
    return sizes


def time_of(mesh):
    time = mesh.GetFieldData().GetArray("TimeValue")
    return None if time is None else time.GetTuple1(0)


def describe(path):
    mesh = read(path)
    sizes = measure(mesh)
    return {
        "points": mesh.GetNumberOfPoints(),
        "cells": mesh.GetNumberOfCells(),
        "types": sorted({mesh.GetCellType(i) for i in range(mesh.GetNumberOfCells())}),
        "bounds": mesh.GetBounds() if mesh.GetNumberOfPoints() else [0] * 6,
        "size": sum(sizes),
        "smallest": min(sizes, default=0),
        "time": time_of(mesh),
        "point_data": describe_arrays(mesh.GetPointData()),
        "cell_data": describe_arrays(mesh.GetCellData()),
        "scalars": mesh.GetPointData().GetScalars().GetName()
        if mesh.GetPointData().GetScalars() else "",
    }


if __name__ == "__main__":
    for name in sys.argv[1:]:
        print(json.dumps(describe(name)))
