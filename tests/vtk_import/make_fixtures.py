"""Makes the small files that tests of lode-vtk-import read, one of each format.

make_fixtures.py FOLDER NAME...  writes those of blocks.e (by VTK), elements.e, ensight.case, foam, plot3d.xyz
                                 (with .q) and blocks.cgns (out of blocks.cgns.gz, see make_cgns.c),
                                 and for any other name, by VTK, lz4.vtu, lzma.vts, parts.pvtu,
                                 parts.pvts and blocks.vtm

All fill [0, 4] x [0, 2] x [0, 2] with 4 x 2 x 2 hexahedra, in two blocks that meet at x = 2 (foam,
lz4.vtu, lzma.vts: one), with f = x + 2 y + 4 z + 100 step at points (foam: p = f at cells' centres).
"""
import gzip
import os
import struct
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
SIDES = ((0, 3, 3, 3), (2, 3, 3, 3))  # where a block begins in x, and its points an axis


def value(p, step=0):
    return p[0] + 2 * p[1] + 4 * p[2] + 100 * step


def points_of(block):
    first, n_x, n_y, n_z = block
    return [(float(first + x), float(y), float(z))
            for z in range(n_z) for y in range(n_y) for x in range(n_x)]


def hexahedra_of(block):
    _, n_x, n_y, n_z = block
    cells = []
    for z in range(n_z - 1):
        for y in range(n_y - 1):
            for x in range(n_x - 1):
                a = (z * n_y + y) * n_x + x
                below = [a, a + 1, a + n_x + 1, a + n_x]
                cells.append(below + [i + n_x * n_y for i in below])
    return cells


def write(path, text):
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "w", encoding="ascii") as file:
        file.write(text)


def write_ensight(folder):
    """Two steps; the second part of three is a surface."""
    write(os.path.join(folder, "ensight.case"), """FORMAT
type: ensight gold
GEOMETRY
model: ensight.geo
VARIABLE
scalar per node: f ensight.f**
scalar per element: g ensight.g
TIME
time set: 1
number of steps: 2
filename start number: 0
filename increment: 1
time values: 0.0 0.5
""")
    number = "{:10d}\n".format
    real = "{:12.5e}\n".format
    geometry = "two blocks\nand a wall\nnode id assign\nelement id assign\n"
    fields = ["f\n", "f\n"]
    cells = "g\n"
    parts = [("inlet", SIDES[0]), ("wall", (0, 3, 3, 1)), ("outlet", SIDES[1])]
    for i, (name, block) in enumerate(parts):
        points = points_of(block)
        is_wall = block[3] == 1
        hexahedra = [[0, 1, 4, 3], [1, 2, 5, 4]] if is_wall else hexahedra_of(block)
        kind = "quad4" if is_wall else "hexa8"
        part = "part\n" + number(i + 1)
        geometry += part + name + "\ncoordinates\n" + number(len(points))
        for axis in range(3):
            geometry += "".join(real(p[axis]) for p in points)
        geometry += kind + "\n" + number(len(hexahedra))
        geometry += "".join("".join(f"{c + 1:10d}" for c in cell) + "\n" for cell in hexahedra)
        for step in range(2):
            fields[step] += part + "coordinates\n" + "".join(real(value(p, step)) for p in points)
        cells += part + kind + "\n" + "".join(real(i + 1) for _ in hexahedra)
    write(os.path.join(folder, "ensight.geo"), geometry)
    write(os.path.join(folder, "ensight.g"), cells)
    for step in range(2):
        write(os.path.join(folder, f"ensight.f{step:02d}"), fields[step])


def foam_file(kind, name, body):
    return ("FoamFile\n{\n    version 2.0;\n    format ascii;\n"
            f"    class {kind};\n    object {name};\n}}\n{body}\n")


def foam_list(items):
    return f"{len(items)}\n(\n" + "\n".join(items) + "\n)"


def foam_faces(block):
    """Faces inside first, by owner and neighbour, then those of the boundary: corners, cells. That
    between the first two cells is two triangles, so that these are polyhedra."""
    sides = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (3, 7, 6, 2), (0, 4, 7, 3), (1, 2, 6, 5)]
    found = {}
    for i, cell in enumerate(hexahedra_of(block)):
        for side in sides:
            corners = [cell[k] for k in side]
            found.setdefault(tuple(sorted(corners)), []).append((i, corners))
    faces = [(cells[0][1], [owner for owner, _ in cells]) for cells in found.values()]
    (a, b, c, d), pair = next(face for face in faces if face[1] == [0, 1])
    faces.remove(([a, b, c, d], pair))
    faces += [([a, b, c], pair), ([a, c, d], pair)]
    return (sorted((f for f in faces if len(f[1]) == 2), key=lambda f: f[1]),
            sorted((f for f in faces if len(f[1]) == 1), key=lambda f: f[1]))


def write_foam(folder):
    """A case of two times."""
    case = os.path.join(folder, "foam")
    block = (0, 5, 3, 3)
    mesh = os.path.join(case, "constant", "polyMesh")
    inner, outer = foam_faces(block)
    write(os.path.join(case, "system", "controlDict"), foam_file("dictionary", "controlDict", """
application icoFoam;
startFrom startTime;
startTime 0;
stopAt endTime;
endTime 1;
deltaT 1;
writeControl timeStep;
writeInterval 1;
"""))
    write(os.path.join(mesh, "points"), foam_file("vectorField", "points", foam_list(
        ["({} {} {})".format(*p) for p in points_of(block)])))
    write(os.path.join(mesh, "faces"), foam_file("faceList", "faces", foam_list(
        ["{}({})".format(len(corners), " ".join(map(str, corners)))
         for corners, _ in inner + outer])))
    write(os.path.join(mesh, "owner"), foam_file("labelList", "owner", foam_list(
        [str(cells[0]) for _, cells in inner + outer])))
    write(os.path.join(mesh, "neighbour"), foam_file("labelList", "neighbour", foam_list(
        [str(cells[1]) for _, cells in inner])))
    write(os.path.join(mesh, "boundary"), foam_file("polyBoundaryMesh", "boundary", f"""1
(
walls
{{
    type wall;
    nFaces {len(outer)};
    startFace {len(inner)};
}}
)"""))
    points = points_of(block)
    centres = [[sum(points[c][k] for c in cell) / 8 for k in range(3)]
               for cell in hexahedra_of(block)]
    for step in range(2):
        values = [str(value(centre, step)) for centre in centres]
        write(os.path.join(case, str(step), "p"), foam_file("volScalarField", "p", f"""
dimensions [0 2 -2 0 0 0 0];
internalField nonuniform List<scalar> {foam_list(values)};
boundaryField {{ walls {{ type zeroGradient; }} }}"""))


def write_plot3d(folder):
    """Binary, several blocks, blanking: the last point of the second block is blanked. f is the
    density."""
    grid = struct.pack("<i", 2)
    solution = struct.pack("<i", 2)
    for block in SIDES:
        grid += struct.pack("<3i", *block[1:])
        solution += struct.pack("<3i", *block[1:])
    for i, block in enumerate(SIDES):
        points = points_of(block)
        n = len(points)
        for axis in range(3):
            grid += struct.pack(f"<{n}f", *(p[axis] for p in points))
        grid += struct.pack(f"<{n}i", *([1] * (n - 1) + [1 - i]))
        solution += struct.pack("<4f", 0.5, 0, 1000, 0)
        solution += struct.pack(f"<{n}f", *(value(p) + 1 for p in points))
        for _ in range(4):
            solution += struct.pack(f"<{n}f", *(1.0 for _ in points))
    for name, data in (("plot3d.xyz", grid), ("plot3d.q", solution)):
        with open(os.path.join(folder, name), "wb") as file:
            file.write(data)


def netcdf_text(text):
    """As classic netCDF has names: a length, then bytes to a multiple of 4."""
    data = text.encode("ascii")
    return struct.pack(">i", len(data)) + data + bytes(-len(data) % 4)


def write_elements(folder):
    """Exodus II of one block of two elements TETRA14, as far as that is told without nodes."""
    dimensions = (("num_el_blk", 1), ("num_el_in_blk1", 2), ("num_nod_per_el1", 14))
    head = b"CDF\x01" + struct.pack(">3i", 0, 10, len(dimensions))
    for name, length in dimensions:
        head += netcdf_text(name) + struct.pack(">i", length)
    head += struct.pack(">4i", 0, 0, 11, 1) + netcdf_text("connect1") + struct.pack(">3i", 2, 1, 2)
    head += struct.pack(">2i", 12, 1) + netcdf_text("elem_type") + struct.pack(">i", 2)
    head += netcdf_text("TETRA14") + struct.pack(">2i", 4, 4 * 28)
    with open(os.path.join(folder, "elements.e"), "wb") as file:
        file.write(head + struct.pack(">i", len(head) + 4))
        file.write(struct.pack(">28i", *range(1, 29)))


def write_exodus(folder):
    """Two blocks of ids 10 and 20 that share points, two steps; VTK writes it."""
    from vtkmodules.util.vtkAlgorithm import VTKPythonAlgorithmBase
    from vtkmodules.vtkCommonCore import vtkDoubleArray, vtkIntArray, vtkPoints
    from vtkmodules.vtkCommonDataModel import VTK_HEXAHEDRON, vtkDataObject, vtkUnstructuredGrid
    from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
    from vtkmodules.vtkIOExodus import vtkExodusIIWriter

    class Steps(VTKPythonAlgorithmBase):
        def __init__(self):
            super().__init__(nInputPorts=0, outputType="vtkUnstructuredGrid")

        def RequestInformation(self, request, inputs, outputs):
            about = outputs.GetInformationObject(0)
            key = vtkStreamingDemandDrivenPipeline
            about.Set(key.TIME_STEPS(), [0.0, 0.5], 2)
            about.Set(key.TIME_RANGE(), [0.0, 0.5], 2)
            return 1

        def RequestData(self, request, inputs, outputs):
            about = outputs.GetInformationObject(0)
            key = vtkStreamingDemandDrivenPipeline.UPDATE_TIME_STEP()
            time = about.Get(key) if about.Has(key) else 0.0
            grid = vtkUnstructuredGrid.GetData(outputs, 0)
            block = (0, 5, 3, 3)
            points = vtkPoints()
            points.SetDataTypeToDouble()
            field = vtkDoubleArray()
            field.SetName("f")
            for p in points_of(block):
                points.InsertNextPoint(p)
                field.InsertNextValue(value(p, 1 if time == 0.5 else 0))
            grid.Allocate(16)
            grid.SetPoints(points)
            grid.GetPointData().AddArray(field)
            ids = vtkIntArray()
            ids.SetName("ElementBlockIds")
            for cell in hexahedra_of(block):
                grid.InsertNextCell(VTK_HEXAHEDRON, 8, cell)
                ids.InsertNextValue(10 if points.GetPoint(cell[0])[0] < 2 else 20)
            grid.GetCellData().AddArray(ids)
            grid.GetInformation().Set(vtkDataObject.DATA_TIME_STEP(), time)
            return 1

    source = Steps()
    writer = vtkExodusIIWriter()
    writer.SetInputConnection(source.GetOutputPort())
    writer.SetFileName(os.path.join(folder, "blocks.e"))
    writer.SetBlockIdArrayName("ElementBlockIds")
    writer.WriteAllTimeStepsOn()
    writer.WriteOutBlockIdArrayOff()
    writer.WriteOutGlobalElementIdArrayOff()
    writer.WriteOutGlobalNodeIdArrayOff()
    writer.Write()


def xml_grid(block, grid):
    """An unstructured or curvilinear grid, with f and MaterialId."""
    from vtkmodules.vtkCommonCore import vtkDoubleArray, vtkIntArray, vtkPoints
    from vtkmodules.vtkCommonDataModel import VTK_HEXAHEDRON
    points = vtkPoints()
    field = vtkDoubleArray()
    field.SetName("f")
    for p in points_of(block):
        points.InsertNextPoint(p)
        field.InsertNextValue(value(p))
    grid.SetPoints(points)
    grid.GetPointData().AddArray(field)
    material = vtkIntArray()
    material.SetName("MaterialId")
    for cell in hexahedra_of(block):
        if grid.IsA("vtkUnstructuredGrid"):
            grid.InsertNextCell(VTK_HEXAHEDRON, 8, cell)
        material.InsertNextValue(10 if points.GetPoint(cell[0])[0] < 2 else 20)
    grid.GetCellData().AddArray(material)
    return grid


def curvilinear(first, n_x):
    from vtkmodules.vtkCommonDataModel import vtkStructuredGrid
    grid = vtkStructuredGrid()
    grid.SetExtent(first, first + n_x - 1, 0, 2, 0, 2)
    return xml_grid((first, n_x, 3, 3), grid)


def write_xml(folder):
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import (VTK_QUAD, vtkCompositeDataSet, vtkMultiBlockDataSet,
                                               vtkPolyData, vtkUnstructuredGrid)
    from vtkmodules.vtkIOXML import (vtkXMLMultiBlockDataWriter, vtkXMLStructuredGridWriter,
                                     vtkXMLUnstructuredGridWriter)

    def put(writer, name, data):
        writer.SetFileName(os.path.join(folder, name))
        writer.SetInputData(data)
        writer.Write()

    packed = vtkXMLUnstructuredGridWriter()
    packed.SetCompressorTypeToLZ4()
    put(packed, "lz4.vtu", xml_grid((0, 5, 3, 3), vtkUnstructuredGrid()))
    packed = vtkXMLStructuredGridWriter()
    packed.SetCompressorTypeToLZMA()
    put(packed, "lzma.vts", curvilinear(0, 5))
    blocks = vtkMultiBlockDataSet()
    for i, block in enumerate(SIDES):
        part = xml_grid(block, vtkUnstructuredGrid())
        put(vtkXMLUnstructuredGridWriter(), f"part{i}.vtu", part)
        put(vtkXMLStructuredGridWriter(), f"part{i}.vts", curvilinear(block[0], 3))
        part = xml_grid(block, vtkUnstructuredGrid())
        part.GetCellData().RemoveArray("MaterialId")
        blocks.SetBlock(i, part)
        blocks.GetMetaData(i).Set(vtkCompositeDataSet.NAME(), ("left", "right")[i])
    wall = vtkPolyData()
    points = vtkPoints()
    for p in ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)):
        points.InsertNextPoint(p)
    wall.SetPoints(points)
    wall.Allocate(1)
    wall.InsertNextCell(VTK_QUAD, 4, (0, 1, 2, 3))
    blocks.SetBlock(2, wall)
    blocks.GetMetaData(2).Set(vtkCompositeDataSet.NAME(), "wall")
    put(vtkXMLMultiBlockDataWriter(), "blocks.vtm", blocks)
    arrays = """<PPoints><PDataArray type="Float32" NumberOfComponents="3"/></PPoints>
<PPointData><PDataArray type="Float64" Name="f"/></PPointData>
<PCellData><PDataArray type="Int32" Name="MaterialId"/></PCellData>
"""
    for name, kind, whole, extents in (
            ("parts.pvtu", "PUnstructuredGrid", "", ("", "")),
            ("parts.pvts", "PStructuredGrid", 'WholeExtent="0 4 0 2 0 2"',
             ('Extent="0 2 0 2 0 2"', 'Extent="2 4 0 2 0 2"'))):
        pieces = "".join(f'<Piece Source="part{i}.{name[7:]}" {extents[i]}/>\n' for i in range(2))
        write(os.path.join(folder, name), f"""<?xml version="1.0"?>
<VTKFile type="{kind}" version="0.1" byte_order="LittleEndian">
<{kind} GhostLevel="0" {whole}>
{arrays}{pieces}</{kind}>
</VTKFile>
""")


def write_cgns(folder):
    with gzip.open(os.path.join(HERE, "blocks.cgns.gz")) as packed:
        with open(os.path.join(folder, "blocks.cgns"), "wb") as file:
            file.write(packed.read())


WRITERS = {"blocks.e": write_exodus, "elements.e": write_elements, "ensight.case": write_ensight, "foam": write_foam,
           "plot3d.xyz": write_plot3d, "blocks.cgns": write_cgns}

if __name__ == "__main__":
    for writer in {WRITERS.get(name, write_xml) for name in sys.argv[2:]}:
        writer(sys.argv[1])
