"""Reads a delaunay_pyramid, ternary_triangulation or implicit_delaunay_pyramid file, inserts its vertices again, and holds
the meshes of its levels against the raster: the model's part of section 7 written from docs/format.md alone. Of a raster
with lines, whose file is of points, samples lie at every k-th node, and fixed edges are edges of every level.

read_insertions_lode.py FILE.lode RASTER.asc

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

PART = 65536
X, Y, HEIGHT, CORNERS, STEPS, ERROR, LINES, BOXES, COUNTS, NODES, MADE = range(1, 12)
HEIGHT_TYPES = {1: "h", 2: "f", 3: "d"}


class Cursor:
    def __init__(self, raw):
        self.raw, self.at = raw, 0

    def take(self, fmt):
        values = struct.unpack_from("<" + fmt, self.raw, self.at)
        self.at += struct.calcsize("<" + fmt)
        return values[0] if len(values) == 1 else values

    def text(self):
        n = self.take("I")
        self.at += n
        return self.raw[self.at - n : self.at].decode()


def read_metadata(raw):
    cursor = Cursor(raw)
    expect(cursor.take("I") == 4, "another layout")
    kind = cursor.take("B")
    expect(kind in (0, 1), "neither of a raster nor of points")
    m = {"is_of_points": kind == 1, "size": cursor.take("2i"), "world": cursor.take("6d")}
    m["crs"], m["unit"], m["type"] = cursor.text(), cursor.text(), cursor.text()
    m["has_place"] = cursor.take("B")
    m["range"] = cursor.take("2d")
    m["n_samples"], m["n_missing"], m["n_left_out"] = cursor.take("3Q")
    m["finest"] = cursor.take("d")
    m["b"], m["n_base"], m["n"], m["T"], m["height_type"] = cursor.take("4IB")
    n_levels = cursor.take("I")
    m["levels"] = struct.unpack_from(f"<{n_levels}d", raw, cursor.at)
    cursor.at += 8 * n_levels
    n_ends = cursor.take("I")
    m["ends"] = struct.unpack_from(f"<{n_ends}I", raw, cursor.at)
    cursor.at += 4 * n_ends
    m["facts"] = [cursor.take("d2I2d") for _ in range(n_levels + n_ends)]
    m["n_lines"], m["n_steps"], n_bands = cursor.take("3I")
    m["bands"] = [cursor.take("2I") for _ in range(n_bands)]
    ends = [0] + [end for end, _ in m["bands"]]
    expect(all(a < b for a, b in zip(ends, ends[1:])) and ends[-1] == m["n"], "wrong bands")
    expect(m["is_of_points"] or m["n_lines"] == 0, "lines in a raster")
    expect(cursor.at == len(raw), "bytes left over")
    return m


class File:
    def __init__(self, path):
        library = container.load_zstd()
        data = pathlib.Path(path).read_bytes()
        header = container.read_header(data)
        model, metadata, blocks = container.read_directory(library, data, header)
        models = "delaunay_pyramid", "ternary_triangulation", "implicit_delaunay_pyramid"
        expect(model in models, f"expected one of {models}, got {model}")
        self.is_split = model == models[1]
        self.m = read_metadata(metadata)
        self.blocks = {}
        for _, block, raw in container.read_blocks(library, data, header, blocks):
            expect(block["level"] == block["y"] == block["z"] == 0, "a wrong block")
            self.blocks[block["kind"], block["x"]] = raw

    def column(self, kind, n, code):
        numbers = array.array(code)
        for part in range(-(-n // PART)):
            numbers.frombytes(self.blocks.pop((kind, part)))
        expect(len(numbers) == n, f"kind {kind}: {len(numbers)} numbers, expected {n}")
        return numbers


class Bits:
    """Numbers of few bits, the lowest first."""

    def __init__(self, raw):
        self.number, self.n, self.at = int.from_bytes(raw, "little"), 8 * len(raw), 0

    def take(self, n):
        self.at += n
        expect(self.at <= self.n, "a page that is too short")
        return (self.number >> (self.at - n)) & ((1 << n) - 1)

    def rice(self, k):
        high = 0
        while self.take(1):
            high += 1
        return high << k | self.take(k)

    def rising(self, n, begin):
        k, numbers = self.take(5), []
        for _ in range(n):
            numbers.append(begin + self.rice(k))
            begin = numbers[-1] + 1
        return numbers


def to_float(half):
    return struct.unpack("<f", struct.pack("<I", half << 16))[0]


def to_height(key, code):
    if code == "h":
        return key - 32768
    n = 8 * struct.calcsize("<" + code)
    bits = key ^ (1 << (n - 1)) if key >> (n - 1) else key ^ ((1 << n) - 1)
    return struct.unpack("<" + code, bits.to_bytes(n // 8, "little"))[0]


def read_page(bits, box, n, n_made, band, code):
    """Of each node its number, place, height, how many triangles it makes, and whether removing
    begins with the later one."""
    numbers = bits.rising(n, band[0])
    expect(numbers[-1] < band[1], "a node of another band")
    w, h = ((box[k + 2] - box[k]).bit_length() for k in (0, 1))
    places = [(box[0] + bits.take(w), box[1] + bits.take(h)) for _ in range(n)]
    expect(all(x <= box[2] and y <= box[3] for x, y in places), "a node beside its page")
    lowest, shift, m = bits.take(64), bits.take(7), bits.take(7)
    heights = [to_height(lowest + (bits.take(m) << shift), code) for _ in range(n)]
    middle, k = bits.take(16), bits.take(5)
    codes = [bits.rice(k) for _ in range(n)]
    made = [middle + (c // 2 if c % 2 == 0 else -(c + 1) // 2) for c in codes]
    expect(min(made) > 0 and sum(made) == n_made, "another number of triangles in a page")
    later = set(bits.rising(bits.take(17), 0))
    expect(-(-bits.at // 8) * 8 == bits.n, "bytes left over in a page")
    return [(numbers[i], places[i], heights[i], made[i], i in later) for i in range(n)]


def area(a, b, c):
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def in_circle(a, b, c, p):
    rows = [(q[0] - p[0], q[1] - p[1]) for q in (a, b, c)]
    lifts = [x * x + y * y for x, y in rows]
    cross = [
        rows[i][0] * rows[(i + 1) % 3][1] - rows[i][1] * rows[(i + 1) % 3][0] for i in range(3)
    ]
    return lifts[0] * cross[1] + lifts[1] * cross[2] + lifts[2] * cross[0] > 0


class Insertions:
    """Triangles as they are made, and of the mesh of now who has an edge."""

    def __init__(self, file):
        self.m = m = file.m
        self.is_split = file.is_split
        code = HEIGHT_TYPES[m["height_type"]]
        self.places = list(zip(file.column(X, m["b"], "i"), file.column(Y, m["b"], "i")))
        self.heights = list(file.column(HEIGHT, m["b"], code))
        corners = file.column(CORNERS, 3 * m["n_base"], "I")
        self.errors = [to_float(e) for e in file.column(ERROR, m["n_base"], "H")]
        steps = file.column(STEPS, 4 * m["n_steps"], "I")
        self.steps = [tuple(steps[k :: m["n_steps"]]) for k in range(m["n_steps"])]
        nodes = self.read_pages(file, code)
        ends = file.column(LINES, 2 * m["n_lines"], "I")
        expect(not file.blocks, "blocks left over")
        self.lines = [tuple(ends[i : i + 2]) for i in range(0, len(ends), 2)]
        expect(all(a < b for a, b in self.lines), "a fixed edge that is turned round")
        expect(self.lines == sorted(set(self.lines)), "fixed edges out of order")
        # Split triangles keep their edges anyhow.
        self.fixed = set() if self.is_split else set(self.lines)
        self.triangles, self.deaths, self.of_edge = [], [], {}
        self.removed, self.made = [], []
        for t in range(m["n_base"]):
            self.make(tuple(corners[3 * t : 3 * t + 3]))
        for a, b in self.lines:
            expect((a, b) in self.of_edge and (b, a) in self.of_edge, "a fixed edge of one side")
        for node in range(m["n"]):
            place, height, n_made, is_later, errors = nodes[node]
            self.places.append(place)
            self.heights.append(height)
            self.errors += errors
            self.insert(node, is_later)
            expect(len(self.made[node]) == n_made, f"node {node} makes another number of triangles")
        expect(len(self.triangles) == m["T"], "another number of triangles")

    def read_pages(self, file, code):
        """By node: place, height, number of triangles, whether it begins later, and errors."""
        n_pages = sum(n for _, n in self.m["bands"])
        boxes = file.column(BOXES, 4 * n_pages, "i")
        counts = file.column(COUNTS, 2 * n_pages, "I")
        nodes, first, begin = {}, 0, 0
        for end, n in self.m["bands"]:
            for page in range(first, first + n):
                n_nodes, n_made = counts[page::n_pages]
                errors = array.array("H")
                errors.frombytes(file.blocks.pop((MADE, page)))
                expect(len(errors) == n_made, "another number of errors in a page")
                bits, box = Bits(file.blocks.pop((NODES, page))), boxes[page::n_pages]
                at = 0
                for node, *rest in read_page(bits, box, n_nodes, n_made, (begin, end), code):
                    expect(node not in nodes, "a node twice")
                    own = [to_float(e) for e in errors[at : at + rest[2]]]
                    nodes[node] = *rest, own
                    at += rest[2]
            first, begin = first + n, end
        expect(len(nodes) == self.m["n"], "a node that is in no page")
        return nodes

    def holds(self, t, place):
        c = [self.places[v] for v in self.triangles[t]]
        return all(area(c[i], c[(i + 1) % 3], place) >= 0 for i in range(3))

    def find(self, place):
        """The triangles that hold a place: down from those of the base."""
        found, ahead, seen = [], list(range(self.m["n_base"])), set()
        while ahead:
            t = ahead.pop()
            if t in seen or not self.holds(t, place):
                continue
            seen.add(t)
            if self.deaths[t] is None:
                found.append(t)
            else:
                ahead += self.made[self.deaths[t]]
        return sorted(found)

    def make(self, corner):
        expect(area(*(self.places[v] for v in corner)) > 0, "a triangle that does not turn left")
        t = len(self.triangles)
        self.triangles.append(corner)
        self.deaths.append(None)
        for i in range(3):
            edge = corner[i], corner[(i + 1) % 3]
            expect(edge not in self.of_edge, "an edge twice")
            self.of_edge[edge] = t, i

    def insert(self, node, is_later):
        p = self.m["b"] + node
        place = self.places[p]
        found = self.find(place)
        expect(1 <= len(found) <= 2, "a vertex in no triangle, or at a corner")
        seed = found[-1 if is_later else 0]
        expect(place not in [self.places[v] for v in self.triangles[seed]], "a vertex at a corner")
        sides = [self.cavity(seed, place)]
        across = sides[0][2]
        if across is not None and self.is_fixed(*across):
            sides.append(self.cavity(self.of_edge[across[1], across[0]][0], place))
            self.fixed.remove((min(across), max(across)))
            self.fixed |= {(min(v, p), max(v, p)) for v in across}
        removed = [t for side in sides for t in side[0]]
        for t in removed:
            self.deaths[t] = node
            for i in range(3):
                c = self.triangles[t]
                del self.of_edge[c[i], c[(i + 1) % 3]]
        self.removed.append(removed)
        heads = [edge for gone, border, _ in sides for edge in border[: len(gone)]]
        tails = [edge for gone, border, _ in sides for edge in border[len(gone) :]]
        first = len(self.triangles)
        for a, b in heads + tails:
            self.make((a, b, p))
        self.made.append(range(first, len(self.triangles)))

    def is_fixed(self, a, b):
        return (min(a, b), max(a, b)) in self.fixed

    def cavity(self, seed, place):
        """What goes, the border's edges that make triangles, and the one that the place lies on."""
        corner = self.triangles[seed]
        removed, border = [seed], []
        stack = [(corner[i], corner[(i + 1) % 3]) for i in (2, 1, 0)]
        while stack:
            a, b = stack.pop()
            behind = None if self.is_fixed(a, b) else self.of_edge.get((b, a))
            if behind is not None:
                other = self.triangles[behind[0]]
                if self.is_split:
                    goes_on = area(self.places[a], self.places[b], place) == 0
                else:
                    goes_on = in_circle(*(self.places[v] for v in other), place)
                if goes_on:
                    removed.append(behind[0])
                    apex = other[(behind[1] + 2) % 3]
                    stack += [(apex, b), (a, apex)]
                    continue
            border.append((a, b, behind is None))
        expect(len(border) == len(removed) + 2, "no disk")
        edges = [edge[:2] for edge in border]
        on = [
            i
            for i, (a, b, is_outline) in enumerate(border)
            if is_outline and area(self.places[a], self.places[b], place) == 0
        ]
        if not on:
            return removed, edges, None
        return removed, edges[on[0] + 1 :] + edges[: on[0]], edges[on[0]]

    def mesh_within(self, tolerance):
        time = self.m["n"]
        for node, removed in enumerate(self.removed):
            if all(self.errors[t] <= tolerance for t in removed):
                time = node
                break
        return self.mesh_at(time)

    def mesh_at(self, time):
        alive = []
        for t, death in enumerate(self.deaths):
            born = self.triangles[t][2] - self.m["b"] if t >= self.m["n_base"] else -1
            if born < time and (death is None or death >= time):
                alive.append(t)
        return alive


def crosses(a, b, c, d):
    """Whether each of two ways crosses the other, and does not only touch it."""

    def sign(x):
        return (x > 0) - (x < 0)

    return (
        sign(area(a, b, c)) * sign(area(a, b, d)) < 0
        and sign(area(c, d, a)) * sign(area(c, d, b)) < 0
    )


def check_deaths(made, every):
    """Which node removes a triangle follows from where vertices lie: of every so many triangles."""
    base = [made.triangles[t] for t in range(made.m["n_base"])]
    edges = {(c[i], c[(i + 1) % 3]) for c in base for i in range(3)}
    fixed = [e for e in edges if e[::-1] not in edges] + made.lines
    thrice = [(3 * x, 3 * y) for x, y in made.places]
    for t in range(0, len(made.triangles), every):
        corner = made.triangles[t]
        a, b, c = (made.places[v] for v in corner)
        middle = tuple(a[k] + b[k] + c[k] for k in (0, 1))
        death = None
        for node in range(corner[2] - made.m["b"] + 1 if t >= len(base) else 0, made.m["n"]):
            v = made.m["b"] + node
            p = made.places[v]
            if made.is_split:
                removes = made.holds(t, p) and p not in (a, b, c)
            else:
                removes = in_circle(a, b, c, p) and not any(
                    crosses(middle, thrice[v], thrice[i], thrice[k]) for i, k in fixed
                )
            if removes:
                death = node
                break
        expect(death == made.deaths[t], f"triangle {t} is removed by {made.deaths[t]}, not {death}")


def check_steps(made):
    """One of each error that a node is the first to fall to, and one after all nodes."""
    steps, n_now, finest = [], made.m["n_base"], None
    for node, removed in enumerate(made.removed):
        worst = max(made.errors[t] for t in removed)
        if not made.m["ends"] and (finest is None or worst < finest):
            steps.append((worst, node, n_now))
            finest = worst
        n_now += len(made.made[node]) - len(removed)
    said = [(to_float(error), time, n) for error, time, n, _ in made.steps]
    expect(said[:-1] == steps, "other steps")
    expect(said[-1][1:] == (made.m["n"], n_now), "another last step")
    for _, time, _, largest in made.steps[:: max(1, len(made.steps) // 8)] + made.steps[-1:]:
        worst = max(made.errors[t] for t in made.mesh_at(time))
        expect(to_float(largest) == worst, f"another largest error at {time}")
    expect(made.steps[-1][0] == made.steps[-1][3], "another last error")


def read_raster(path, code="d"):
    """Heights by column and row, and how many of these there are. `code`: the type of the heights."""
    words = pathlib.Path(path).read_text().split()
    header = {words[i].lower(): float(words[i + 1]) for i in range(0, 12, 2)}
    size = int(header["ncols"]), int(header["nrows"])
    values = array.array(code, map(float, words[12:]))
    nodata = header["nodata_value"]
    raster = {(i % size[0], i // size[0]): z for i, z in enumerate(values) if z != nodata}
    return raster, size


def read_samples(path, made):
    """Heights by node, and how many nodes a cell has."""
    raster, size = read_raster(path, "f" if made.m["type"] == "float32" else "d")
    step = (made.m["size"][0] - 1) // (size[0] - 1)
    nodes = tuple(step * (n - 1) + 1 for n in size)
    expect(made.m["size"] == nodes, f"a lattice of {made.m['size']} nodes, expected {nodes}")
    # The file's first row is the northernmost.
    last = nodes[1] - 1 if made.m["world"][5] > 0 else 0
    return {(step * x, abs(last - step * y)): z for (x, y), z in raster.items()}, step


def check_vertices(made, raster):
    for v, (place, z) in enumerate(zip(made.places, made.heights)):
        # Lines have vertices of their own, in the base.
        is_of_line = made.lines and v < made.m["b"] and place not in raster
        expect(is_of_line or raster[place] == z, f"node {place} has another height")


def check_lines(made, triangles):
    """Each is a chain of edges of a mesh, through the nodes on it."""
    of_edge = {}
    for t in triangles:
        c = made.triangles[t]
        for i in range(3):
            of_edge.setdefault(c[i], set()).add(c[(i + 1) % 3])
    for a, b in made.lines:
        at = a
        while at != b:
            ahead = [
                v
                for v in of_edge.get(at, ())
                if area(made.places[a], made.places[b], made.places[v]) == 0
                and sum(
                    (made.places[v][k] - made.places[at][k])
                    * (made.places[b][k] - made.places[a][k])
                    for k in (0, 1)
                )
                > 0
            ]
            expect(len(ahead) == 1, f"the line from {made.places[a]} ends at {made.places[at]}")
            at = ahead[0]


def check_errors(made, triangles, samples, bound_of):
    raster, step = samples
    for t in triangles:
        corner = made.triangles[t]
        a, b, c = (made.places[v] for v in corner)
        z = [fractions.Fraction(made.heights[v]) for v in corner]
        low = [-(-min(a[k], b[k], c[k]) // step) * step for k in (0, 1)]
        high = [max(a[k], b[k], c[k]) + 1 for k in (0, 1)]
        for y in range(low[1], high[1], step):
            for x in range(low[0], high[0], step):
                w = area(b, c, (x, y)), area(c, a, (x, y)), area(a, b, (x, y))
                if min(w) < 0:
                    continue
                plane = sum(wi * zi for wi, zi in zip(w, z)) / sum(w)
                error = abs(plane - fractions.Fraction(raster[x, y]))
                expect(error <= bound_of(t), f"node {x}, {y} errs by {float(error)}")


def main():
    made = Insertions(File(sys.argv[1]))
    samples = read_samples(sys.argv[2], made)
    check_vertices(made, samples[0])
    check_errors(
        made, range(len(made.triangles)), samples, lambda t: fractions.Fraction(made.errors[t])
    )
    check_deaths(made, 97)
    check_steps(made)
    counts = []
    for level in made.m["levels"]:
        mesh = made.mesh_within(level)
        expect(made.m["facts"][len(counts)][0] == level, "figures of another level")
        check_errors(made, mesh, samples, lambda t, level=level: fractions.Fraction(level))
        check_lines(made, mesh)
        counts.append(len(mesh))
    for end in made.m["ends"]:
        mesh = made.mesh_at(end)
        worst = max(fractions.Fraction(made.errors[t]) for t in mesh)
        check_errors(made, mesh, samples, lambda t, worst=worst: worst)
        check_lines(made, mesh)
        counts.append(len(mesh))
    expect([facts[1] for facts in made.m["facts"]] == counts, "other numbers of triangles")
    print(f"vertices {len(made.places)} triangles {len(made.triangles)} levels {counts}")


if __name__ == "__main__":
    try:
        main()
    except BadFile as error:
        print(error)
        sys.exit(1)
