"""Reads a complete_pyramid, triangle_lists or linked_triangle_lists file and holds the meshes of its levels, their
neighbours and links against the raster and each other: the model's part of section 7 written from docs/format.md alone.

read_pyramid_lode.py FILE.lode RASTER.asc

Shares no code with Lode. Tests are in Python's whole numbers and fractions. Prints numbers of vertices, of triangles that
are kept, of links, and of the triangles of each level.

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

X, Y, HEIGHT, CORNERS, ERROR, BEHIND, END, COUNT, LINK, FIRST, LINE = range(1, 12)
MODELS = ("complete_pyramid", "triangle_lists", "linked_triangle_lists")
NOTHING = 2**32 - 1


def read_metadata(raw):
    cursor = Cursor(raw)
    expect(cursor.take("I") == 1, "another layout")
    expect(cursor.take("B") == 0, "not of a raster")
    m = {"size": cursor.take("2i"), "world": cursor.take("6d")}
    m["crs"], m["unit"], m["type"] = cursor.text(), cursor.text(), cursor.text()
    m["has_place"], m["range"], m["counts"] = cursor.take("B"), cursor.take("2d"), cursor.take("3Q")
    m["finest"] = cursor.take("d")
    m["levels"] = [cursor.take("d") for _ in range(cursor.take("I"))]
    m["heights"] = {1: "h", 2: "f", 3: "d"}[cursor.take("B")]
    expect(cursor.take("I") == 0, "lines of a raster")
    for name, code in (("vertices", "I"), ("mesh", "I"), ("kept", "I"), ("links", "Q")):
        m[name] = [cursor.take(code) for _ in m["levels"]]
    m["facts"] = [cursor.take("3d") for _ in m["levels"]]
    expect(cursor.at == len(raw), "bytes left over")
    return m


def triples(numbers):
    return [tuple(numbers[3 * i : 3 * i + 3]) for i in range(len(numbers) // 3)]


class Level:
    """What is kept with a level."""

    def __init__(self, p, level):
        n = p.m["kept"][level]
        self.corners = triples(p.column(CORNERS, level, 3 * n, "I"))
        halves = p.column(ERROR, level, n, "H")
        self.errors = [struct.unpack("<f", struct.pack("<I", half << 16))[0] for half in halves]
        if not p.is_of_lists:
            self.behind = triples(p.column(BEHIND, level, 3 * n, "I"))
        self.ends = p.column(END, level, n, "H") if p.is_of_lists else None
        self.links = None
        if p.has_links:
            counts = p.column(COUNT, level, n, "I")
            links = p.column(LINK, level, p.m["links"][level], "I")
            firsts = p.column(FIRST, level, -(-n // PART), "Q")
            self.links, at = [], 0
            for t, count in enumerate(counts):
                if t % PART == 0:
                    expect(firsts[t // PART] == at, "links that begin elsewhere")
                self.links.append(list(links[at : at + count]))
                at += count
            expect(at == len(links), "links of no triangle")


class Pyramid:
    def __init__(self, path):
        library = container.load_zstd()
        data = pathlib.Path(path).read_bytes()
        header = container.read_header(data)
        model, metadata, blocks = container.read_directory(library, data, header)
        expect(model in MODELS, f"got {model}")
        self.is_of_lists, self.has_links = model != MODELS[0], model != MODELS[1]
        self.m = m = read_metadata(metadata)
        self.blocks = {}
        for _, block, raw in container.read_blocks(library, data, header, blocks):
            expect(block["y"] == block["z"] == 0, "a wrong block")
            self.blocks[block["kind"], block["level"], block["x"]] = raw
        self.places, self.heights, self.levels = [], [], []
        for level in range(len(m["levels"])):
            n = m["vertices"][level] - len(self.places)
            xs, ys = self.column(X, level, n, "i"), self.column(Y, level, n, "i")
            self.places += zip(xs, ys)
            self.heights += self.column(HEIGHT, level, n, m["heights"])
            self.levels.append(Level(self, level))
        expect(not self.blocks, "blocks left over")

    def column(self, kind, level, n, code):
        numbers = array.array(code)
        for part in range(-(-n // PART)):
            numbers.frombytes(self.blocks.pop((kind, level, part)))
        expect(len(numbers) == n, f"kind {kind}: {len(numbers)} numbers, expected {n}")
        return numbers

    def mesh(self, level):
        """The levels that triangles are kept with, and their numbers there."""
        if not self.is_of_lists:
            return [(level, t) for t in range(self.m["kept"][level])]
        return [
            (of, t)
            for of in range(level + 1)
            for t in range(self.m["kept"][of])
            if self.levels[of].ends[t] > level
        ]

    def corners(self, triangle):
        return [self.places[v] for v in self.levels[triangle[0]].corners[triangle[1]]]


def do_interiors_meet(a, b):
    for one, other in ((a, b), (b, a)):
        for i in range(3):
            if all(area(one[i], one[(i + 1) % 3], p) <= 0 for p in other):
                return False
    return True


def check_samples(p, triangle, level, samples, covered):
    places = p.corners(triangle)
    kept = p.levels[triangle[0]]
    za, zb, zc = (fractions.Fraction(p.heights[v]) for v in kept.corners[triangle[1]])
    a, b, c = places
    whole = area(a, b, c)
    expect(whole > 0, "a triangle that does not turn left")
    stated = kept.errors[triangle[1]]
    expect(0 <= stated <= p.m["facts"][level][0], "an error beyond the largest")
    most = min(stated, p.m["levels"][level]) + 1e-9
    for y in range(min(q[1] for q in places), max(q[1] for q in places) + 1):
        for x in range(min(q[0] for q in places), max(q[0] for q in places) + 1):
            w = area((x, y), b, c), area(a, (x, y), c), area(a, b, (x, y))
            if min(w) < 0:
                continue
            covered.add((x, y))
            off = (w[0] * za + w[1] * zb + w[2] * zc) / whole - fractions.Fraction(samples[x, y])
            expect(abs(off) <= most, "a sample that errs by more")
    return whole


def check_mesh(p, level, samples, whole_area):
    mesh = p.mesh(level)
    expect(len(mesh) == p.m["mesh"][level], "another number of triangles")
    covered, total, behind = set(), 0, {}
    for number, triangle in enumerate(mesh):
        total += check_samples(p, triangle, level, samples, covered)
        v = p.levels[triangle[0]].corners[triangle[1]]
        expect(max(v) < p.m["vertices"][level], "a vertex of a later level")
        for i in range(3):
            edge = v[i], v[(i + 1) % 3]
            expect(edge not in behind, "an edge twice")
            behind[edge] = 4 * number + i
    expect(total == whole_area, "another area than the raster's")
    expect(len(covered) == p.m["counts"][0], "samples in no triangle")
    expect(len({v for edge in behind for v in edge}) == p.m["vertices"][level], "unused vertices")
    largest = max(p.levels[of].errors[t] for of, t in mesh)
    expect(largest == p.m["facts"][level][0], "another largest error")
    for (a, b), half_edge in behind.items():
        other = behind.get((b, a), NOTHING)
        if not p.is_of_lists:
            number, i = half_edge // 4, half_edge % 4
            expect(p.levels[level].behind[number][i] == other, "another neighbour")
        if other == NOTHING:
            (x, y), (u, v) = p.places[a], p.places[b]
            expect(x == u or y == v, "an edge of one triangle off columns and rows")


def box_of(places):
    return [pick(q[k] for q in places) for k in (0, 1) for pick in (min, max)]


def do_boxes_meet(a, b):
    return a[0] < b[1] and b[0] < a[1] and a[2] < b[3] and b[2] < a[3]


def check_links(p):
    n_levels = len(p.m["levels"])
    boxes = [
        [box_of(p.corners((level, t))) for t in range(len(kept.links))]
        for level, kept in enumerate(p.levels)
    ]
    for level, kept in enumerate(p.levels):
        for t, links in enumerate(kept.links):
            to = kept.ends[t] if p.is_of_lists else level + 1
            wanted = []
            if to < n_levels:
                own = p.corners((level, t))
                for other in range(p.m["kept"][to]):
                    if not do_boxes_meet(boxes[level][t], boxes[to][other]):
                        continue
                    if do_interiors_meet(own, p.corners((to, other))):
                        wanted.append(other)
            expect(links == wanted, f"level {level}: triangle {t}: links to others")


def main():
    p = Pyramid(sys.argv[1])
    raster, _ = read_raster(sys.argv[2])
    n_cells = sum(
        all((x + i, y + j) in raster for i in (0, 1) for j in (0, 1)) for x, y in raster
    )
    for level in range(len(p.m["levels"])):
        check_mesh(p, level, raster, 2 * n_cells)
    if p.has_links:
        check_links(p)
    counts = [len(p.mesh(level)) for level in range(len(p.m["levels"]))]
    print(f"vertices {len(p.places)} kept {sum(p.m['kept'])} links {sum(p.m['links'])} levels {counts}")
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except (BadFile, KeyError, struct.error) as error:
        print(f"bad file: {error!r}", file=sys.stderr)
        sys.exit(1)
