"""Reads an adaptive_triangulation or hierarchical_delaunay file and holds the meshes of its levels against the
raster or the points: the model's part of section 7 written from docs/format.md alone.

read_hierarchy_lode.py FILE.lode RASTER.asc|POINTS.xyz

Of points at one place the lowest counts. Shares no code with Lode. Tests are in Python's whole
numbers and fractions. Prints numbers of vertices and triangles, and of the triangles of each level.

Exit status: 0, 1 for a bad file, 2 where libzstd is absent.
"""

import array
import bisect
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
    kind = cursor.take("B")
    expect(kind in (0, 1), "neither of a raster nor of points")
    m = {"is_of_points": kind == 1, "size": cursor.take("2i"), "world": cursor.take("6d")}
    m["crs"], m["unit"], m["type"] = cursor.text(), cursor.text(), cursor.text()
    m["has_place"], m["range"], m["counts"] = cursor.take("B"), cursor.take("2d"), cursor.take("3Q")
    m["levels"] = [cursor.take("d") for _ in range(cursor.take("I"))]
    m["bits"], m["reach"], m["lines"] = cursor.take("I"), cursor.take("i"), cursor.take("I")
    m["crowded"] = cursor.take("I")
    expect(m["is_of_points"] or m["crowded"] == 0, "of a raster triangles with points beside them")
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
        self.crowded = set(self.column(CROWDED, m["crowded"], "I"))
        expect(self.crowded <= set(replaced), "points beside triangles that nothing replaces")
        expect(not self.blocks, "blocks left over")
        self.replaced_from, self.count = {}, {}
        first = m["t"][0]
        for triangle, count in zip(replaced, counts):
            self.replaced_from[triangle], self.count[triangle] = first, count
            first += count
        expect(first == t, "other triangles in refinements")

    def column(self, kind, n, code):
        numbers = array.array(code)
        for part in range(-(-n // PART)):
            numbers.frombytes(self.blocks.pop((kind, part)))
        expect(len(numbers) == n, f"kind {kind}: {len(numbers)} numbers, expected {n}")
        return numbers

    def below(self, t):
        """All that comes of a triangle."""
        if t in self.replaced_from:
            for child in range(self.replaced_from[t], self.replaced_from[t] + self.count[t]):
                yield child
                yield from self.below(child)

    def mesh(self, level):
        end = self.m["t"][level]
        return [t for t in range(end) if self.replaced_from.get(t, end) >= end]


def read_points(path, m):
    """Heights by node."""
    g = m["world"]
    points = {}
    for line in pathlib.Path(path).read_text().splitlines():
        x, y, z = map(float, line.split())
        node = round((x - g[0]) / g[1]), round((y - g[3]) / g[5])
        points[node] = min(z, points.get(node, z))
    return points


class Samples:
    """Heights by nodes, and which nodes are in a rectangle of the fine lattice: of a raster all,
    whether they have heights or not."""

    def __init__(self, by_node, scale, is_of_points):
        self.by_node = by_node
        self.scale = scale
        self.sorted = sorted(by_node) if is_of_points else None

    def near(self, places, more=0):
        s = self.scale
        x_low, x_high = min(p[0] for p in places) - more, max(p[0] for p in places) + more
        y_low, y_high = min(p[1] for p in places) - more, max(p[1] for p in places) + more
        if self.sorted is None:
            columns = range(-(-x_low // s), x_high // s + 1)
            return [(x, y) for y in range(-(-y_low // s), y_high // s + 1) for x in columns]
        first = bisect.bisect_left(self.sorted, (-(-x_low // s), -(1 << 40)))
        last = bisect.bisect_right(self.sorted, (x_high // s, 1 << 40))
        return [p for p in self.sorted[first:last] if y_low <= p[1] * s <= y_high]


def check_points(h, samples):
    """What vertices at points have, and what is said of points beside triangles."""
    scale = samples.scale
    for (x, y), z in zip(h.places, h.heights):
        if x % scale == 0 and y % scale == 0:
            node = x // scale, y // scale
            expect(samples.by_node.get(node, z) == z, "a vertex with another height than its point")
    for t in h.replaced_from:
        if t in h.crowded:
            continue
        places = [h.places[v] for v in h.triangles[t]]
        edges = list(zip(places, places[1:] + places[:1]))
        reach = 0
        for v in {v for below in h.below(t) for v in h.triangles[below]}:
            for k in (0, 1):
                bounds = [p[k] for p in places]
                reach = max(reach, min(bounds) - h.places[v][k], h.places[v][k] - max(bounds))
            for a, b in edges:
                step = abs(b[0] - a[0]) + abs(b[1] - a[1])
                reach = max(reach, -(area(a, b, h.places[v]) // step))
        for p in samples.near(places, reach):
            q = p[0] * scale, p[1] * scale
            sides = [area(a, b, q) for a, b in edges]
            is_near = all(
                side >= -reach * (abs(b[0] - a[0]) + abs(b[1] - a[1]))
                for side, (a, b) in zip(sides, edges)
            )
            expect(min(sides) >= 0 or not is_near, "a point beside a triangle that is not told")


def check_vertices(h, samples):
    scale = 1 << h.m["bits"]
    for (x, y), z in zip(h.places, h.heights):
        expect(x % scale == 0 or y % scale == 0, "a vertex off columns and rows")
        low = x // scale, y // scale
        high = -(-x // scale), -(-y // scale)
        share = (x % scale + y % scale) / scale
        linear = samples[low] * (1 - share) + samples[high] * share
        expect(abs(z - linear) <= 1e-12 * abs(z), "a vertex of another height")


def check_level(h, level, samples, whole_area):
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
        for x, y in samples.near((a, b, c)):
            p = x * scale, y * scale
            w = area(p, b, c), area(a, p, c), area(a, b, p)
            if min(w) < 0:
                continue
            covered.add((x, y))
            off = (w[0] * za + w[1] * zb + w[2] * zc) / whole - fractions.Fraction(
                samples.by_node[x, y]
            )
            expect(abs(off) <= most, "a sample that errs by more")
    expect(whole_area in (None, total), "another area than the raster's, or than of level 0")
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
        if (b, a) not in edges and not h.m["is_of_points"]:
            (x, y), (u, v) = h.places[a], h.places[b]
            is_straight = (x == u and x % scale == 0) or (y == v and y % scale == 0)
            expect(is_straight, "an edge of one triangle off columns and rows")
    return total


def main():
    h = Hierarchy(sys.argv[1])
    scale = 1 << h.m["bits"]
    if h.m["is_of_points"]:
        samples, whole_area = Samples(read_points(sys.argv[2], h.m), scale, True), None
        n_samples, _, n_left_out = h.m["counts"]
        expect(len(samples.by_node) == n_samples + n_left_out, "another number of points")
        check_points(h, samples)
    else:
        raster, _ = read_raster(sys.argv[2])
        n_cells = sum(
            all((x + i, y + j) in raster for i in (0, 1) for j in (0, 1)) for x, y in raster
        )
        samples, whole_area = Samples(raster, scale, False), 2 * n_cells * scale * scale
        check_vertices(h, raster)
    for level in range(len(h.m["levels"])):
        whole_area = check_level(h, level, samples, whole_area)
    counts = [len(h.mesh(level)) for level in range(len(h.m["levels"]))]
    print(f"vertices {len(h.places)} triangles {len(h.triangles)} levels {counts}")
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except (BadFile, KeyError, struct.error) as error:
        print(f"bad file: {error!r}", file=sys.stderr)
        sys.exit(1)
