"""Reads a tetra_mt file, rebuilds the mesh of full resolution, and compares it with the mesh that
was read: section 7 written from docs/format.md alone, the mesh by VTK.

read_tetra_lode.py FILE.lode [MESH.vtu]

Shares no code with Lode. Checks blocks and their numbers, applies all nodes in an order of their
own, each after its parents, and compares tetrahedra, positions, values and regions with the mesh's;
errors, ranges and boxes are nested along discovery. Prints numbers of vertices, cells and nodes.

Exit status: 0, 1 for a bad file, 2 where numpy, VTK or libzstd is absent.
"""

import collections
import math
import pathlib
import struct
import sys

try:
    import numpy as np
except ImportError:
    print("expected numpy (package python3-numpy), found none")
    sys.exit(2)

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "store"))
import independent_reader as container  # noqa: E402
from independent_reader import BadFile, expect  # noqa: E402

NONE = 0xFFFFFFFF
PAGE, PART = 512, 65536
BASE_VERTICES, BASE_CELLS, ROOTS, LINKS, FIELD, GRADIENTS, BASE_VALUES, ORIGINS = range(1, 9)


class Cursor:
    """Numbers of metadata or of a block's columns, from front to back."""

    def __init__(self, library, raw):
        self.library, self.raw, self.at = library, raw, 0

    def take(self, fmt):
        values = struct.unpack_from("<" + fmt, self.raw, self.at)
        self.at += struct.calcsize("<" + fmt)
        return values[0] if len(values) == 1 else values

    def take_bytes(self, n):
        expect(self.at + n <= len(self.raw), "bytes missing")
        self.at += n
        return self.raw[self.at - n : self.at]

    def column(self, n):
        size = shift = 0
        while True:
            byte = self.take_bytes(1)[0]
            size |= (byte & 127) << shift
            shift += 7
            if byte < 128:
                break
        if size == 0:
            return bytes(n)
        stored = self.take_bytes(size)
        return stored if size == n else container.unzstd(self.library, stored, n)

    def numbers(self, n, width):
        out = np.zeros((n, width), np.uint8)
        for b in range(width):
            out[:, b] = np.frombuffer(self.column(n), np.uint8)
        return out.reshape(-1).view(f"<u{width}")

    def differences(self, n, width):
        codes = self.numbers(n, width).astype(np.uint64)
        steps = (codes >> np.uint64(1)) ^ (np.uint64(0) - (codes & np.uint64(1)))
        return np.cumsum(steps, dtype=np.uint64).astype(f"<u{width}")

    def floats(self, n, narrow):
        numbers = self.differences(n, 4 if narrow else 8)
        return numbers.view("<f4" if narrow else "<f8").astype(float)

    def bytes(self, n):
        return self.numbers(n, 1).astype(int)

    def end(self):
        expect(self.at == len(self.raw), f"{len(self.raw) - self.at} bytes left over")


def read_metadata(raw):
    c = Cursor(None, raw)
    m = {}
    expect(c.take("I") == 3, "unknown layout")
    m["B"], m["N"], m["narrow"] = c.take("IIB")
    m["n_reference"], m["n_base"], m["T"], m["R"] = c.take("4Q")
    m["box"] = c.take("6d")
    m["deviation"] = c.take("d")
    m["regions"] = [c.take("q") for _ in range(c.take("I"))]
    m["fields"] = []
    for _ in range(c.take("I")):
        f = {"name": c.take_bytes(c.take("I")).decode("utf-8")}
        f["type"], f["narrow"], f["everywhere"], f["has_time"], f["time"] = c.take("BBBBd")
        f["base_error"], f["min"], f["max"] = c.take("3d")
        m["fields"].append(f)
    c.end()
    return m


def parts(n, size):
    """How many each has, where n are cut in parts of `size`, the last of what is left."""
    return [min(size, n - i) for i in range(0, n, size)]


class File:
    """Base, links and fields, as lists by node and arrays by vertex (the base's first)."""

    def __init__(self, path):
        self.library = container.load_zstd()
        data = pathlib.Path(path).read_bytes()
        header = container.read_header(data)
        model, metadata, blocks = container.read_directory(self.library, data, header)
        expect(model == "tetra_mt", f"expected tetra_mt, got {model}")
        self.m = read_metadata(metadata)
        self.blocks = {}
        for _, block, raw in container.read_blocks(self.library, data, header, blocks):
            expect(block["codec"] == 0 and block["y"] == block["z"] == 0, "a wrong block")
            self.blocks[block["kind"], block["level"], block["x"]] = raw
        self.n_pages = -(-self.m["N"] // PAGE)
        self.n_page_vertices = parts(self.m["N"], PAGE) + parts(self.m["B"], PAGE)

    def open(self, kind, x, level=0):
        expect((kind, level, x) in self.blocks, f"no block {kind} {level} {x}")
        return Cursor(self.library, self.blocks.pop((kind, level, x)))

    def read_base(self):
        m = self.m
        positions = [np.zeros((0, 3))]
        for part, n in enumerate(parts(m["B"], PART)):
            c = self.open(BASE_VERTICES, part)
            positions.append(np.stack([c.floats(n, m["narrow"]) for _ in range(3)], axis=1))
            c.end()
        corners, waiting, regions = [], [], []
        for part, n in enumerate(parts(m["T"], PART)):
            c = self.open(BASE_CELLS, part)
            corners.append(np.stack([c.differences(n, 4) for _ in range(4)], axis=1))
            waiting.append(c.differences(n, 4))
            regions.append(c.differences(n, 4) if len(m["regions"]) > 1 else np.zeros(n, int))
            c.end()
        roots = [np.zeros(0, int)]
        for part, n in enumerate(parts(m["R"], PART)):
            c = self.open(ROOTS, part)
            roots.append(c.differences(n, 4).astype(int))
            c.end()
        self.base_positions = np.concatenate(positions)
        self.corners = np.concatenate(corners).astype(int).tolist()
        self.waiting = np.concatenate(waiting).astype(int).tolist()
        self.cell_regions = np.concatenate(regions).astype(int).tolist()
        self.roots = np.concatenate(roots).tolist()

    def read_links(self):
        m = self.m
        self.target, self.children, self.discovered = [], [], []
        self.far_parents, self.makers, self.new_regions = [], [], []
        self.boxes, positions = [], []
        for page in range(self.n_pages):
            self.read_links_of(page, self.n_page_vertices[page], positions)
        self.positions = np.concatenate([self.base_positions] + positions)
        self.parents = [[] for _ in range(m["N"])]
        for k, children in enumerate(self.children):
            for child in children:
                expect(child < m["N"] and child != k, "a bad child")
                self.parents[child].append(k)
        for k, far in enumerate(self.far_parents):
            here = [p for p in self.parents[k] if p // PAGE == k // PAGE]
            expect(sorted(self.parents[k]) == sorted(here + far), f"parents of node {k}")

    def read_links_of(self, page, n, positions):
        c = self.open(LINKS, page)
        positions.append(np.stack([c.floats(n, self.m["narrow"]) for _ in range(3)], axis=1))
        exponents = c.bytes(n)
        self.boxes += zip(exponents.tolist(), *(c.bytes(n).tolist() for _ in range(3)))
        pages = c.numbers(int(c.numbers(1, 2)[0]), 4).astype(int).tolist()
        n_children, n_discovered, n_far, n_makers = (c.bytes(n).tolist() for _ in range(4))
        at = (page, pages)
        targets = self.read_lists(c, [1] * n, at, vertices=True)
        self.target += [t[0] for t in targets]
        children = self.read_lists(c, n_children, at)
        self.children += children
        self.discovered += [kids[:d] for kids, d in zip(children, n_discovered)]
        self.far_parents += self.read_lists(c, n_far, at)
        makers = c.bytes(sum(n_makers)).tolist()
        n_regions, regions = [0] * n, []
        if len(self.m["regions"]) > 1:
            n_regions = c.bytes(n).tolist()
            regions = c.numbers(sum(n_regions), 4).astype(int).tolist()
        for k in range(n):
            self.makers.append([makers.pop(0) for _ in range(n_makers[k])])
            self.new_regions.append([regions.pop(0) for _ in range(n_regions[k])])
        c.end()

    def read_lists(self, c, sizes, at, vertices=False):
        page, pages = at
        n = sum(sizes)
        which = c.numbers(n, 2).astype(int).tolist()
        here = c.numbers(which.count(0), 2).astype(int).tolist()
        there = c.numbers(n - len(here), 2).astype(int).tolist()
        lists, i = [], 0
        here, there = iter(here), iter(there)
        for k, size in enumerate(sizes):
            entries, before = [], None
            for code in which[i : i + size]:
                place = next(there) if code else next(here)
                p = pages[code - 1] if code else page
                if before is not None and before[0] == p:
                    place = (place + before[1]) % PAGE
                elif code == 0 and before is None:
                    place = (place + k) % PAGE
                before = (p, place)
                entries.append(self.number_of(p, place, vertices))
            lists.append(entries)
            i += size
        return lists

    def number_of(self, page, place, vertices):
        if page < self.n_pages:
            return PAGE * page + place + (self.m["B"] if vertices else 0)
        expect(vertices, "a node in a page of the base")
        return PAGE * (page - self.n_pages) + place

    def read_origins(self):
        pages = []
        for page, n in enumerate(self.n_page_vertices):
            c = self.open(ORIGINS, page)
            pages.append(c.differences(n, 4).astype(int))
            c.end()
        nodes, base = pages[: self.n_pages], pages[self.n_pages :]
        self.origins = np.concatenate(base + nodes)
        expect(len(set(self.origins.tolist())) == len(self.origins), "an origin twice")

    def read_field(self, i):
        f = self.m["fields"][i]
        c = self.open(BASE_VALUES, 0, i)
        f["knots"] = c.floats(256, False)
        base = []
        for part, n in enumerate(parts(self.m["B"], PART) or [0]):
            c = c if part == 0 else self.open(BASE_VALUES, part, i)
            base.append(c.floats(n, f["narrow"]))
            c.end()
        values, facts = [], []
        for page in range(self.n_pages):
            n = self.n_page_vertices[page]
            c = self.open(FIELD, page, i)
            values.append(c.floats(n, f["narrow"]))
            facts.append(np.stack([c.numbers(n, 2).astype(int) for _ in range(3)], axis=1))
            c.end()
        for page, n in enumerate(self.n_page_vertices):
            c = self.open(GRADIENTS, page, i)
            c.numbers(n, 4)
            c.end()
        f["values"] = np.concatenate(base + values)
        f["facts"] = np.concatenate(facts) if facts else np.zeros((0, 3), int)


def replay(file):
    """Applies all nodes; gives the tetrahedra as (corners in stored order, region)."""
    m = file.m
    round_vertex = collections.defaultdict(set)
    cells = {}

    def add(corners, waits_for, region):
        cells[len(cells) + add.n_gone] = (corners, waits_for, region)
        for v in corners:
            round_vertex[v].add(len(cells) + add.n_gone - 1)

    def remove(number):
        for v in cells[number][0]:
            round_vertex[v].discard(number)
        del cells[number]
        add.n_gone += 1

    add.n_gone = 0
    for corners, waits_for, region in zip(file.corners, file.waiting, file.cell_regions):
        expect(max(corners) <= m["B"] + m["N"], "a corner beyond all vertices")
        expect(waits_for == NONE or waits_for < m["N"], "a node beyond all")
        add(tuple(corners), waits_for, region)
    n_inner = sum(m["B"] + m["N"] not in corners for corners, _, _ in cells.values())
    expect(n_inner == m["n_base"], f"expected {m['n_base']} cells of the base, got {n_inner}")

    n_parents = [len(parents) for parents in file.parents]
    ready = [k for k, n in enumerate(n_parents) if n == 0]
    expect(ready == file.roots, "nodes without parents are not those that the file says")
    n_applied = 0
    while ready:
        k = ready.pop()
        apply_node(file, k, round_vertex, cells, add, remove)
        n_applied += 1
        for child in file.children[k]:
            n_parents[child] -= 1
            if n_parents[child] == 0:
                ready.append(child)
    expect(n_applied == m["N"], f"only {n_applied} of {m['N']} nodes could be applied")
    return [(corners, region) for corners, waits_for, region in cells.values()]


def apply_node(file, k, round_vertex, cells, add, remove):
    target, vertex = file.target[k], file.m["B"] + k
    star = [cells[i] for i in round_vertex[target] if cells[i][1] == k]
    expect(len(star) > 0, f"nothing waits for node {k}")
    around = {v for cell in star for v in cell[0]} - {file.m["B"] + file.m["N"]}
    p = file.positions[list(around)]
    is_inside = (file.lower[k] <= p).all() and (p <= file.upper[k]).all()
    expect(is_inside, f"node {k} replaces what its box does not hold")
    edges = collections.defaultdict(list)
    for corners, _, region in star:
        face = sorted(set(corners) - {target})
        expect(len(face) == 3, f"node {k}: a tetrahedron with a corner twice")
        for left_out in range(3):
            edges[tuple(face[:left_out] + face[left_out + 1 :])].append(region)
    for i in [i for i in round_vertex[target] if cells[i][1] == k]:
        remove(i)

    def others(cell):
        return sorted(set(cell[0]) - {target, vertex})

    moved = [(tuple(vertex if v == target else v for v in c[0]), c[2]) for c in star]
    outline = [((a, b, vertex, target), r[0]) for (a, b), r in edges.items() if len(r) == 1]
    moved.sort(key=others)
    outline.sort(key=others)
    if file.new_regions[k]:
        expect(len(file.new_regions[k]) == len(outline), f"node {k}: number of regions")
        outline = [(c[0], r) for c, r in zip(outline, file.new_regions[k])]
    brought = moved + outline
    children, makers = file.children[k], file.makers[k]
    expect(len(makers) == (len(brought) if children else 0), f"node {k}: number of makers")
    for i, (corners, region) in enumerate(brought):
        place = makers[i] if children else 0
        expect(place <= len(children), f"node {k}: a maker that is no child")
        add(corners, children[place] if place < len(children) else NONE, region)


def error_of(code, knots):
    if code == 0:
        return 0.0
    if code == 4095:
        return math.inf
    width = knots[-1] - knots[0]
    e = 0
    if width > 0:
        e = math.frexp(width)[1]
        e = min(max(e, -90), 126)
    c = int(code) - 1
    return math.ldexp(1 + (c % 128) / 128, e - 31 + c // 128)


def check_nesting(file):
    """All that a node states covers what each states that it discovers; once each is discovered."""
    n_found = [0] * file.m["N"]
    for k, found in enumerate(file.discovered):
        for child in found:
            n_found[child] += 1
            expect((file.lower[k] <= file.lower[child]).all(), f"node {k}: box is not nested")
            expect((file.upper[k] >= file.upper[child]).all(), f"node {k}: box is not nested")
            for f in file.m["fields"]:
                error, low, width = f["facts"][k]
                error_of_child, low_of_child, width_of_child = f["facts"][child]
                expect(error >= error_of_child, f"node {k}: error is not nested")
                expect(low <= low_of_child, f"node {k}: low is not nested")
                high, high_of_child = low + width, low_of_child + width_of_child
                expect(high >= high_of_child, f"node {k}: high is not nested")
    for k, n in enumerate(n_found):
        expect(n == (1 if file.parents[k] else 0), f"node {k} is discovered {n} times")


def find_boxes(file):
    """Of each node its box's lower and upper corner."""
    low, high = file.positions.min(axis=0), file.positions.max(axis=0)
    expect((np.concatenate([low, high]) == file.m["box"]).all(), "the vertices' box is another")
    w = 2.0 ** math.frexp((high - low).max())[1]
    l = np.floor(low / (w * 2.0**-15)) * (w * 2.0**-15)
    boxes = np.array(file.boxes).reshape(-1, 4)
    step = w * 0.5 ** boxes[:, :1]
    line = np.floor((file.positions[file.m["B"] :] - l) / step)
    return l + step * (line - boxes[:, 1:] % 8), l + step * (line + boxes[:, 1:] // 8)


def check_values(file):
    for f in file.m["fields"]:
        knots, values, facts = f["knots"], f["values"], f["facts"]
        expect((np.diff(knots) >= 0).all(), "knots are not ascending")
        expect(values.min() == f["min"] == knots[0], "the smallest value is another")
        expect(values.max() == f["max"] == knots[-1], "the largest value is another")
        if len(facts) == 0:
            continue
        expect(facts[:, 0].max() <= 4095, "an unknown error")
        expect((facts[:, 1] + facts[:, 2]).max() <= 4080, "an unknown value")

        def value_of(codes):
            k, s = codes // 16, codes % 16
            upper = np.minimum(k + 1, 255)
            return knots[k] + (knots[upper] - knots[k]) * (s / 16)

        slack = 1e-6 * max(abs(f["min"]), abs(f["max"]))
        mine = values[file.m["B"] :]
        expect((value_of(facts[:, 1]) <= mine + slack).all(), "a low above the node's value")
        high = value_of(facts[:, 1] + facts[:, 2])
        expect((high >= mine - slack).all(), "a high below the node's value")
        waiting = set(file.waiting) - {NONE}
        bound = max((error_of(facts[k][0], knots) for k in waiting), default=0.0)
        stated = f["base_error"]
        largest = max(stated * (1 + 1 / 128), error_of(1, knots) if stated > 0 else 0)
        expect(stated <= bound <= largest, f"base's error {stated}, nodes' {bound}")


def load_mesh(path):
    """VTK's mesh, and its way from arrays to numpy's."""
    try:
        import vtk
        from vtk.util.numpy_support import vtk_to_numpy
    except ImportError:
        print("expected VTK (package python3-vtk9), found none")
        sys.exit(2)
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(path)
    reader.Update()
    mesh = reader.GetOutput()
    return mesh, vtk_to_numpy


def compare(file, cells, path):
    """All tetrahedra, positions, values and regions, by numbers of the mesh's points."""
    mesh, to_numpy = load_mesh(path)
    origins = file.origins
    points = to_numpy(mesh.GetPoints().GetData()).astype(float)
    expect((points[origins] == file.positions).all(), "positions are others")
    for f in file.m["fields"]:
        name, _, axis = f["name"].partition(":")
        values = to_numpy(mesh.GetPointData().GetArray(name)).astype(float)
        if axis:
            values = values[:, int(axis)]
        expect(values.ndim == 1, f"{name} is no scalar")
        expect((values[origins] == f["values"]).all(), f"{name}: other values")
    given = to_numpy(mesh.GetCells().GetConnectivityArray()).reshape(-1, 4)
    ids = mesh.GetCellData().GetArray("RegionId")
    regions = file.m["regions"] or [0]
    ids = to_numpy(ids).tolist() if ids else [regions[0]] * len(given)
    mine = [(tuple(sorted(origins[list(c)].tolist())), regions[r]) for c, r in cells]
    theirs = list(zip(map(tuple, np.sort(given, axis=1).tolist()), ids))
    expect(collections.Counter(mine) == collections.Counter(theirs), "tetrahedra are others")


def main():
    file = File(sys.argv[1])
    file.read_base()
    file.read_links()
    file.read_origins()
    for i in range(len(file.m["fields"])):
        file.read_field(i)
    left_over = [key for key in file.blocks if key[0] != 0]
    expect(not left_over, f"blocks left over: {left_over[:5]}")
    file.lower, file.upper = find_boxes(file)
    check_nesting(file)
    check_values(file)
    cells = replay(file)
    inner = [(c, r) for c, r in cells if file.m["B"] + file.m["N"] not in c]
    expect(len(inner) == file.m["n_reference"], f"got {len(inner)} cells")
    if len(sys.argv) > 2:
        compare(file, inner, sys.argv[2])
    print(f"vertices {len(file.positions)} cells {len(inner)} nodes {file.m['N']}")


if __name__ == "__main__":
    try:
        main()
    except (BadFile, struct.error) as error:
        print(error)
        sys.exit(1)
