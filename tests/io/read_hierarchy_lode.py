"""Reads an adaptive_triangulation or hierarchical_delaunay file and holds the meshes of its levels against the
raster: the model's part of section 7 written from docs/format.md alone.

read_hierarchy_lode.py FILE.lode RASTER.asc

Shares no code with Lode. Tests are in Python's whole numbers and fractions. Prints numbers of
vertices and triangles, and of the triangles of each level.

Exit status: 0, 1 for a bad file, 2 where libzstd is absent.
"""

import array
import fractions
import pathlib
import struct
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "store"))
import independent_reader as container  # noqa: E402
from independent_reader import BadFile, expect  # noqa: E402
from read_insertions_lode import PART, Cursor, area, read_raster  # noqa: E402

X, Y, HEIGHT, CORNERS, ERROR, REPLACED, COUNT, LINE, CROWDED = range(1, 10)


def read_metadata(raw):
    cursor = Cursor(raw)
    expect(cursor.take("I") == 4, "another layout")
    expect(cursor.take("B") == 0, "a file of points")
    m = {"size": cursor.take("2i"), "world": cursor.take("6d")}
    m["crs"], m["unit"], m["type"] = cursor.text(), cursor.text(), cursor.text()
    m["has_place"], m["range"], m["counts"] = cursor.take("B"), cursor.take("2d"), cursor.take("3Q")
    m["levels"] = [cursor.take("d") for _ in range(cursor.take("I"))]
    m["bits"], m["reach"], m["lines"] = cursor.take("I"), cursor.take("i"), cursor.take("I")
    expect(cursor.take("I") == 0, "triangles with points beside them")
    m["v"] = [cursor.take("I") for _ in m["levels"]]
    m["t"] = [cursor.take("I") for _ in m["levels"]]
    m["m"] = [cursor.take("I") for _ in m["levels"]]
    expect(cursor.at == len(raw), "bytes left over")
    return m


class Hierarchy:
    def __init__(self, path):
        library = container.load_zstd()
        data = pathlib.Path(path).read_bytes()
        header = container.read_header(data)
        model, metadata, blocks = container.read_directory(library, data, header)
        expect(model in ("adaptive_triangulation", "hierarchical_delaunay"), f"got {model}")
        self.m = m = read_metadata(metadata)
        self.blocks = {}
        for _, block, raw in container.read_blocks(library, data, header, blocks):
            expect(block["level"] == block["y"] == block["z"] == 0, "a wrong block")
            self.blocks[block["kind"], block["x"]] = raw
        v, t = m["v"][-1], m["t"][-1]
        self.places = list(zip(self.column(X, v, "i"), self.column(Y, v, "i")))
        self.heights = self.column(HEIGHT, v, "d")
        corners = self.column(CORNERS, 3 * t, "I")
        self.triangles = [tuple(corners[3 * i : 3 * i + 3]) for i in range(t)]
        self.errors = self.column(ERROR, t, "f")
        ends = self.column(LINE, 2 * m["lines"], "I")
        self.lines = [tuple(ends[2 * i : 2 * i + 2]) for i in range(m["lines"])]
        expect(all(max(line) < m["v"][0] and line[0] != line[1] for line in self.lines), "a line")
        replaced, counts = self.column(REPLACED, m["m"][-1], "I"), self.column(COUNT, m["m"][-1], "I")
        expect(not self.blocks, "blocks left over")
        self.replaced_from = {}
        first = m["t"][0]
        for triangle, count in zip(replaced, counts):
            self.replaced_from[triangle] = first
            first += count
        expect(first == t, "other triangles in refinements")

    def column(self, kind, n, code):
        numbers = array.array(code)
        for part in range(-(-n // PART)):
            numbers.frombytes(self.blocks.pop((kind, part)))
        expect(len(numbers) == n, f"kind {kind}: {len(numbers)} numbers, expected {n}")
        return numbers

    def mesh(self, level):
        end = self.m["t"][level]
        return [t for t in range(end) if self.replaced_from.get(t, end) >= end]


def check_vertices(h, samples):
    scale = 1 << h.m["bits"]
    for (x, y), z in zip(h.places, h.heights):
        expect(x % scale == 0 or y % scale == 0, "a vertex off columns and rows")
        low = x // scale, y // scale
        high = -(-x // scale), -(-y // scale)
        share = (x % scale + y % scale) / scale
        linear = samples[low] * (1 - share) + samples[high] * share
        expect(abs(z - linear) <= 1e-12 * abs(z), "a vertex of another height")


def check_level(h, level, samples, n_cells):
    scale = 1 << h.m["bits"]
    edges, covered, total = set(), set(), 0
    for t in h.mesh(level):
        v = h.triangles[t]
        a, b, c = (h.places[i] for i in v)
        za, zb, zc = (fractions.Fraction(h.heights[i]) for i in v)
        whole = area(a, b, c)
        expect(whole > 0, "a triangle that does not turn left")
        total += whole
        for edge in ((v[0], v[1]), (v[1], v[2]), (v[2], v[0])):
            expect(edge not in edges, "an edge twice")
            edges.add(edge)
        most = min(h.errors[t], h.m["levels"][level]) + 1e-9
        for y in range(-(-min(a[1], b[1], c[1]) // scale), max(a[1], b[1], c[1]) // scale + 1):
            for x in range(-(-min(a[0], b[0], c[0]) // scale), max(a[0], b[0], c[0]) // scale + 1):
                p = x * scale, y * scale
                w = area(p, b, c), area(a, p, c), area(a, b, p)
                if min(w) < 0:
                    continue
                covered.add((x, y))
                off = (w[0] * za + w[1] * zb + w[2] * zc) / whole - samples[x, y]
                expect(abs(off) <= most, "a sample that errs by more")
    expect(total == 2 * n_cells * scale * scale, "another area than the raster's")
    expect(len(covered) == h.m["counts"][0], "samples in no triangle")
    ends_at = {}
    for a, b in edges:
        ends_at.setdefault(a, set()).add(b)
        ends_at.setdefault(b, set()).add(a)
    for a, b in h.lines:
        while a != b:
            (x, y), (u, v) = h.places[a], h.places[b]
            on_way = [
                c
                for c in ends_at.get(a, ())
                if area(h.places[a], h.places[b], h.places[c]) == 0
                and (h.places[c][0] - x) * (u - x) + (h.places[c][1] - y) * (v - y) > 0
            ]
            expect(len(on_way) == 1, "a line that is no chain of edges")
            a = on_way[0]
    for a, b in edges:
        if (b, a) not in edges:
            (x, y), (u, v) = h.places[a], h.places[b]
            is_straight = (x == u and x % scale == 0) or (y == v and y % scale == 0)
            expect(is_straight, "an edge of one triangle off columns and rows")


def main():
    h = Hierarchy(sys.argv[1])
    samples, _ = read_raster(sys.argv[2])
    n_cells = sum(
        all((x + i, y + j) in samples for i in (0, 1) for j in (0, 1)) for x, y in samples
    )
    check_vertices(h, samples)
    for level in range(len(h.m["levels"])):
        check_level(h, level, samples, n_cells)
    counts = [len(h.mesh(level)) for level in range(len(h.m["levels"]))]
    print(f"vertices {len(h.places)} triangles {len(h.triangles)} levels {counts}")
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except (BadFile, KeyError, struct.error) as error:
        print(f"bad file: {error!r}", file=sys.stderr)
        sys.exit(1)
