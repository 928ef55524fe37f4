"""Probes and integrates a mesh of cells with VTK, as an oracle that shares no code with Lode.

probe_oracle.py MESH POINTS  for each line X,Y,Z of POINTS a line: the array's value there, or
                             "outside"; then "integral" with volume and integral of the array
"""
import sys

from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkFiltersCore import vtkProbeFilter
from vtkmodules.vtkFiltersParallel import vtkIntegrateAttributes
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader


def main(mesh_path, points_path):
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(mesh_path)
    reader.Update()
    mesh = reader.GetOutput()
    name = mesh.GetPointData().GetArray(0).GetName()
    points = vtkPoints()
    points.SetDataTypeToDouble()
    with open(points_path) as lines:
        for line in lines:
            points.InsertNextPoint(*(float(x) for x in line.split(",")))
    places = vtkPolyData()
    places.SetPoints(points)
    probe = vtkProbeFilter()
    probe.SetInputData(places)
    probe.SetSourceData(mesh)
    probe.Update()
    found = probe.GetOutput().GetPointData()
    for i in range(points.GetNumberOfPoints()):
        is_inside = found.GetArray("vtkValidPointMask").GetTuple1(i) != 0
        print(repr(found.GetArray(name).GetTuple1(i)) if is_inside else "outside")
    integrate = vtkIntegrateAttributes()
    integrate.SetInputData(mesh)
    integrate.Update()
    sums = integrate.GetOutput()
    print("integral", sums.GetCellData().GetArray("Volume").GetTuple1(0),
          sums.GetPointData().GetArray(name).GetTuple1(0))


if __name__ == "__main__":
    main(*sys.argv[1:])
