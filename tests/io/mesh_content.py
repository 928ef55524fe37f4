"""Reads meshes that Lode writes, as an oracle that shares no code with it: .vtk and Exodus II with
VTK, .msh by the few lines below, after Gmsh's own description of the format.

mesh_content.py FILE  prints a JSON object: points, values by name, and cells as [corners, error,
                      RegionId or null, name of the block or group or null]; errors of further
                      fields, by name and cell; faces of patches as corners by name, or by number
                      where a format has no names; how the file is titled, and the time that it
                      says
"""
import json
import os
import struct
import sys


def vtk_cells(grid):
    ids = []
    for i in range(grid.GetNumberOfCells()):
        cell = grid.GetCell(i)
        ids.append([cell.GetPointId(k) for k in range(cell.GetNumberOfPoints())])
    return ids


def column(data, name, n):
    """Of the first n."""
    array = data.GetArray(name)
    return [None] * n if array is None else [array.GetTuple1(i) for i in range(n)]


def content_of_grid(grid, name):
    patches = take_patches(grid)
    n = grid.GetNumberOfCells() - sum(len(faces) for faces in patches.values())
    points = [grid.GetPoint(i) for i in range(grid.GetNumberOfPoints())]
    fields = grid.GetPointData()
    values = {}
    for i in range(fields.GetNumberOfArrays()):
        array = fields.GetArray(i)
        is_scalar = array.GetNumberOfComponents() == 1
        values[array.GetName()] = [array.GetTuple1(k) if is_scalar else array.GetTuple(k)
                                   for k in range(len(points))]
    cells = [[corners, error, region, name]
             for corners, error, region in zip(vtk_cells(grid)[:n], column(grid.GetCellData(), "error", n),
                                               column(grid.GetCellData(), "RegionId", n))]
    names = [grid.GetCellData().GetArrayName(i) for i in range(grid.GetCellData().GetNumberOfArrays())]
    errors = {name: column(grid.GetCellData(), name, n) for name in names if name.startswith("error_")}
    time = grid.GetFieldData().GetArray("TimeValue")
    return {"points": points, "values": values, "cells": cells, "errors": errors,
            "patches": patches, "time": None if time is None else time.GetTuple1(0)}


def take_patches(grid):
    """Triangles behind the other cells."""
    ids = grid.GetCellData().GetArray("PatchId")
    if ids is None:
        return {}
    fields = grid.GetFieldData()
    numbers, strings = fields.GetArray("PatchIds"), fields.GetAbstractArray("PatchNames")
    names = {} if strings is None else {
        int(numbers.GetTuple1(i)): strings.GetValue(i) for i in range(strings.GetNumberOfValues())}
    patches = {}
    for i, corners in enumerate(vtk_cells(grid)):
        patch = int(ids.GetTuple1(i))
        if patch == 0:
            if patches:
                raise ValueError("expected faces of patches behind all other cells")
            continue
        patches.setdefault(names.get(patch, str(patch)), []).append(corners)
    return patches


def read_legacy(path):
    from vtkmodules.vtkIOLegacy import vtkUnstructuredGridReader
    reader = vtkUnstructuredGridReader()
    reader.SetFileName(path)
    reader.ReadAllFieldsOn()
    reader.ReadAllScalarsOn()
    reader.Update()
    content = content_of_grid(reader.GetOutput(), None)
    content["title"] = reader.GetHeader()
    return content


def read_exodus(path):
    from vtkmodules.vtkCommonDataModel import vtkCompositeDataSet
    from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
    from vtkmodules.vtkIOExodus import vtkExodusIIReader
    reader = vtkExodusIIReader()
    reader.SetFileName(path)
    reader.UpdateInformation()
    times = reader.GetOutputInformation(0).Get(vtkStreamingDemandDrivenPipeline.TIME_STEPS())
    reader.SetSqueezePoints(False)
    reader.SetAllArrayStatus(reader.NODAL, 1)
    reader.SetAllArrayStatus(reader.ELEM_BLOCK, 1)
    for i in range(reader.GetNumberOfSideSetArrays()):
        reader.SetSideSetArrayStatus(reader.GetSideSetArrayName(i), 1)
    reader.Update()
    blocks = reader.GetOutput().GetBlock(0)
    content = {"points": [], "values": {}, "cells": [], "title": reader.GetTitle(), "ids": [],
               "errors": {}}
    for i in range(blocks.GetNumberOfBlocks()):
        name = blocks.GetMetaData(i).Get(vtkCompositeDataSet.NAME())
        block = content_of_grid(blocks.GetBlock(i), name)
        content["points"] = block["points"]
        content["values"] = block["values"]
        content["cells"] += block["cells"]
        for key, errors in block["errors"].items():
            content["errors"].setdefault(key, []).extend(errors)
        content["ids"].append(int(blocks.GetBlock(i).GetCellData().GetArray("ObjectId").GetTuple1(0)))
    content["patches"] = {}
    content["time"] = times[0]
    sets = reader.GetOutput().GetBlock(4)
    for i in range(sets.GetNumberOfBlocks()):
        name = sets.GetMetaData(i).Get(vtkCompositeDataSet.NAME())
        content["patches"][name] = vtk_cells(sets.GetBlock(i))
    return content


class GmshFile:
    """A binary .msh of version 4.1, read front to back."""

    def __init__(self, path):
        with open(path, "rb") as file:
            self.bytes = file.read()
        self.at = 0
        self.times = set()

    def numbers(self, form):
        made = struct.unpack_from("<" + form, self.bytes, self.at)
        self.at += struct.calcsize("<" + form)
        return made

    def line(self):
        end = self.bytes.index(b"\n", self.at)
        text = self.bytes[self.at:end].decode()
        self.at = end + 1
        return text

    def expect(self, text):
        line = self.line()
        if line != text:
            raise ValueError(f"expected {text}, got {line!r} before byte {self.at}")


def read_gmsh_entities(file):
    """Physical groups by dimension and entity, and boxes."""
    groups = {}
    boxes = {}
    counts = file.numbers("4Q")
    if counts[0] or counts[1]:
        raise ValueError("expected no points and curves")
    for dimension in (2, 3):
        for _ in range(counts[dimension]):
            tag, *box = file.numbers("i6d")
            (n_groups,) = file.numbers("Q")
            found = file.numbers(f"{n_groups}i")
            (n_bounding,) = file.numbers("Q")
            file.numbers(f"{n_bounding}i")
            groups[(dimension, tag)] = found[0] if found else None
            boxes[(dimension, tag)] = box
    return groups, boxes


def read_gmsh_data(file):
    names = [file.line() for _ in range(int(file.line()))]
    reals = [float(file.line()) for _ in range(int(file.line()))]
    step, n_components, n = [int(file.line()) for _ in range(int(file.line()))]
    if len(reals) != 1 or step != 0 or n_components != 1:
        raise ValueError("expected one step of one component")
    file.times.add(reals[0])
    return names[0].strip('"'), dict(file.numbers("id") for _ in range(n))


def read_gmsh(path):
    file = GmshFile(path)
    file.expect("$MeshFormat")
    file.expect("4.1 1 8")
    if file.numbers("i") != (1,):
        raise ValueError("expected little-endian numbers")
    names, groups, boxes, nodes, elements, data, title = {}, {}, {}, {}, {}, {}, ""
    file.expect("")
    file.expect("$EndMeshFormat")
    while file.at < len(file.bytes):
        section = file.line()
        if section == "$Comments":
            title = file.line()
        elif section == "$PhysicalNames":
            for _ in range(int(file.line())):
                dimension, tag, name = file.line().split(" ", 2)
                names[(int(dimension), int(tag))] = name.strip('"')
        elif section == "$Entities":
            groups, boxes = read_gmsh_entities(file)
        elif section == "$Nodes":
            n_blocks, n, least, most = file.numbers("4Q")
            for _ in range(n_blocks):
                dimension, entity, parametric = file.numbers("3i")
                if (dimension, entity) not in groups or parametric:
                    raise ValueError("expected nodes of an entity")
                (n_here,) = file.numbers("Q")
                tags = file.numbers(f"{n_here}Q")
                for tag in tags:
                    nodes[tag] = file.numbers("3d")
            if len(nodes) != n or (n and (least, most) != (min(nodes), max(nodes))):
                raise ValueError("expected as many nodes as are announced")
        elif section == "$Elements":
            n_blocks, n, least, most = file.numbers("4Q")
            for _ in range(n_blocks):
                dimension, entity, kind = file.numbers("3i")
                (n_here,) = file.numbers("Q")
                n_corners = {2: 3, 4: 4}[kind]
                for _ in range(n_here):
                    tag, *corners = file.numbers(f"{1 + n_corners}Q")
                    elements[tag] = (corners, (dimension, entity))
            if len(elements) != n or (n and (least, most) != (min(elements), max(elements))):
                raise ValueError("expected as many elements as are announced")
        elif section in ("$NodeData", "$ElementData"):
            name, values = read_gmsh_data(file)
            data[(section, name)] = values
        else:
            raise ValueError(f"unknown section {section}")
        if section[1:] not in ("Comments", "PhysicalNames"):
            file.expect("")
        file.expect("$End" + section[1:])
    for corners, entity in elements.values():
        box = boxes[entity]
        for corner in corners:
            if any(not box[k] <= nodes[corner][k] <= box[k + 3] for k in range(3)):
                raise ValueError("expected nodes in the box of their entity")
    order = {tag: i for i, tag in enumerate(sorted(nodes))}
    regions = data.get(("$ElementData", "RegionId"))
    cells, patches = [], {}
    is_solid = any(dimension == 3 for _, (dimension, _) in elements.values())
    for tag, (corners, entity) in elements.items():
        group = groups[entity]
        if is_solid and entity[0] == 2:
            patches.setdefault(names[(2, group)], []).append([order[c] for c in corners])
            continue
        region = regions[tag] if regions else group
        cells.append([[order[c] for c in corners], data[("$ElementData", "error")][tag], region,
                      names.get((entity[0], group))])
    values = {name: [found[tag] for tag in sorted(nodes)]
              for (section, name), found in data.items() if section == "$NodeData"}
    errors = {name: [found[tag] for tag in elements if tag in found]
              for (_, name), found in data.items() if name.startswith("error_")}
    return {"points": [nodes[tag] for tag in sorted(nodes)], "values": values, "cells": cells,
            "errors": errors, "patches": patches, "title": title,
            "time": file.times.pop() if len(file.times) == 1 else None}


def read_vtu(path):
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(path)
    reader.Update()
    return content_of_grid(reader.GetOutput(), None)


READERS = {".vtk": read_legacy, ".vtu": read_vtu, ".msh": read_gmsh, ".e": read_exodus, ".exo": read_exodus,
           ".ex2": read_exodus}

if __name__ == "__main__":
    print(json.dumps(READERS[os.path.splitext(sys.argv[1])[1]](sys.argv[1])))
