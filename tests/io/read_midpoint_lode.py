"""Reads a tetra_mt_midpoint file, splits all vertices, and compares the mesh of full resolution with
the mesh that was read: section 7 written from docs/format.md alone, the mesh by VTK.

read_midpoint_lode.py FILE.lode [MESH.vtu]

Shares no code with Lode, and with the reader of tetra_mt files what section 7 says of both: coded
bits and columns. Splits vertices in an order of its own, each when those beside it have smaller
labels; facts are nested along splits. Prints numbers of vertices, cells and nodes.

One file, although long: it stands for a reader that somebody wrote from the document.

Exit status: 0, 1 for a bad file, 2 where numpy, VTK or libzstd is absent.
"""

import collections
import math
import pathlib
import struct
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import read_tetra_lode as tetra  # noqa: E402
from read_tetra_lode import BadFile, Bits, Cursor, container, expect, np, parts, unzigzag  # noqa: E402

TABLE, ROOTS, BASE_CELLS, PAGES, FIELD_ROOTS, FIELD_PAGES, COINCIDENT, WORLD_ERRORS = range(1, 9)
LEAF, NEAR, FAR = range(3)


def read_metadata(raw):
    c = Cursor(None, raw)
    m = {}
    expect(c.take("I") == 6, "unknown layout")
    m["V"], m["P"], m["B"], m["R"] = c.take("4I")
    m["n_reference"], m["n_base"], m["T"] = c.take("3Q")
    m["box"], m["deviation"] = c.take("6d"), c.take("d")
    m["n_coincident"] = c.take("I")
    m["regions"] = tetra.read_regions(c)
    m["patches"] = [(c.take("q"), c.take_bytes(c.take("I"))) for _ in range(c.take("I"))]
    m["record"] = tetra.read_record(c)
    m["steps"] = [c.take("iq") for _ in range(3)]
    m["D"] = c.take("d")
    m["fields"] = [read_field(c) for _ in range(c.take("I"))]
    expect(m["fields"], "no field")
    c.end()
    return m


def read_field(c):
    f = {"name": c.take_bytes(c.take("I")).decode("utf-8")}
    f["type"], has_time, time = c.take("B"), c.take("B"), c.take("d")
    expect(has_time == 1 or (has_time, time) == (0, 0), "a time of nothing")
    f["base_error"], f["min"], f["max"] = c.take("3d")
    f["step"], f["E"], f["knots"] = c.take("iq"), c.take("d"), c.take("64d")
    expect(list(f["knots"]) == sorted(f["knots"]), "knots are not ascending")
    expect((f["min"], f["max"]) == (f["knots"][0], f["knots"][-1]), "other knots")
    f["in_space"] = tetra.read_base_world_error(c)
    return f


def facts_of(word):
    """Error, low, high and radius."""
    return word & 255, word >> 8 & 63, word >> 14 & 63, word >> 20


class File:
    def __init__(self, path):
        self.library = container.load_zstd()
        data = pathlib.Path(path).read_bytes()
        header = container.read_header(data)
        model, metadata, blocks = container.read_directory(self.library, data, header)
        expect(model == "tetra_mt_midpoint", f"expected tetra_mt_midpoint, got {model}")
        self.m = read_metadata(metadata)
        self.blocks = {}
        for _, block, raw in container.read_blocks(self.library, data, header, blocks):
            expect(block["codec"] == 0, "a wrong block")
            self.blocks[block["kind"], block["x"], block["level"]] = raw
        self.has_marks = len(self.m["regions"]) > 1 or len(self.m["patches"]) > 0
        self.read_table()
        self.read_roots()
        self.read_cells()
        self.coincident = []
        for part, n in enumerate(parts(self.m["n_coincident"], 65536)):
            c = Cursor(self.library, self.take(COINCIDENT, part))
            self.coincident += c.differences(n, 4).astype(int).tolist()
            c.end()

    def take(self, kind, x, level=0):
        expect((kind, x, level) in self.blocks, f"no block {kind} {x} {level}")
        return self.blocks.pop((kind, x, level))

    def read_table(self):
        """By page and place the number of a node, and by page its first leaf."""
        groups, n_leaves = [], []
        for part, n in enumerate(parts(self.m["P"], 4096)):
            c, first = Bits(self.take(TABLE, part)), 0
            for _ in range(n):
                n_leaves.append(c.number("leaves"))
                of_page, epoch = [], 0
                for g in range(c.count(6, "groups")):
                    if g == 0:
                        first = epoch = first + unzigzag(c.wide("first"))
                    else:
                        epoch += 1 + c.count(2, "gap")
                    of_page.append((epoch, 1 + c.count(6, "nodes", min(g, 15))))
                expect(1 <= sum(size for _, size in of_page) <= 256, "too many nodes in a page")
                groups.append(of_page)
            c.end()
        self.nodes = [[] for _ in groups]
        everything = sorted((epoch, -p, size) for p, of in enumerate(groups) for epoch, size in of)
        number = 0
        for _, p, size in everything:
            self.nodes[-p] += range(number, number + size)
            number += size
        self.n = number
        self.leaves, begin = [], self.m["B"]
        for n in n_leaves:
            self.leaves.append(range(begin, begin + n))
            begin += n
        expect(begin == self.m["V"], f"{begin} leaves, expected {self.m['V']}")

    def read_roots(self):
        self.roots, self.codes, self.facts, self.offsets = [], {}, {}, {}
        for part, n in enumerate(parts(self.m["R"], 65536)):
            c = Cursor(self.library, self.take(ROOTS, part))
            labels = c.differences(n, 4).astype(int).tolist()
            axes = [c.differences(n, 4).astype(int).tolist() for _ in range(4)]
            words = c.differences(n, 4).astype(int).tolist()
            off = c.bytes(n).tolist()
            count = sum(off)
            numbers = [c.floats(count, False).tolist() for _ in range(4)]
            c.end()
            self.roots += labels
            for i, label in enumerate(labels):
                self.codes[label] = [axis[i] for axis in axes]
                if label >= self.m["V"]:
                    self.facts[label - self.m["V"]] = words[i]
            for k, i in enumerate(i for i in range(n) if off[i]):
                self.offsets[labels[i]] = [numbers[axis][k] for axis in range(4)]
        expect(self.roots[: self.m["B"]] == list(range(self.m["B"])), "other leaves in the base")

    def read_cells(self):
        self.cells = []
        names = self.roots + [self.m["V"] + self.n]
        walk = tetra.BaseWalk({**self.m, "B": len(self.roots), "N": 0}, Bits(self.take(BASE_CELLS, 0)))
        walk.read()
        for corners, mark in zip(walk.cells, walk.marks):
            self.cells.append((tuple(names[v] for v in corners), mark))

    def steps(self):
        """Of positions, and values of the first field."""
        return [*self.m["steps"], self.m["fields"][0]["step"]]

    def read_pages(self):
        self.ends, self.parents, self.splits, self.marks = {}, {}, {}, {}
        for page in range(self.m["P"]):
            PageReader(self, page).read()
        self.further = [FurtherField(self, k) for k in range(1, len(self.m["fields"]))]


class FurtherField:
    """What the base and pages have of a field but the first: values by leaf, found here."""

    def __init__(self, file, number):
        self.f, self.number, self.m = file, number, file.m["fields"][number]
        self.codes, self.facts, self.offsets, self.splits = {}, {}, {}, {}
        roots = iter(file.roots)
        for part, n in enumerate(parts(file.m["R"], 65536)):
            c = Cursor(file.library, file.take(FIELD_ROOTS, part, number))
            codes = c.differences(n, 4).astype(int).tolist()
            words = c.differences(n, 4).astype(int).tolist()
            off = c.bytes(n).tolist()
            numbers = iter(c.floats(sum(off), False).tolist())
            c.end()
            for code, word, is_off in zip(codes, words, off):
                label = next(roots)
                self.codes[label] = code
                if label >= file.m["V"]:
                    self.facts[label - file.m["V"]] = word
                if is_off:
                    self.offsets[label] = next(numbers)
        for page in range(file.m["P"]):
            self.read_page(page)
        self.split_all()

    def read_page(self, page):
        f, V = self.f, self.f.m["V"]
        c, nodes = Bits(f.take(FIELD_PAGES, page, self.number)), f.nodes[page]
        here = set(nodes)
        for node in reversed(nodes):
            where, _, steps, _ = f.splits[node]
            whose = c.symbol(2, "whose", where)
            expect(whose <= 2, "no place")
            n_leaves = sum(v < V for v in f.ends[node])
            d, _ = read_step(c, "value", n_leaves, abs(steps[2]).bit_length() // 4)
            self.splits[node] = (whose, d)
        last = [0, 0, 0]
        for node in reversed(nodes):
            ends = [v - V for v in f.ends[node] if v >= V]
            parent = f.parents[node]
            is_near = parent is not None and parent - V in here
            own = facts_of(self.facts[node])[:3] if is_near else None
            role = 1 if len(ends) == 2 else 0
            for k, end in enumerate(ends):
                if own is None:
                    four = [last[i] + c.signed("beside", k, i) for i in range(3)]
                else:
                    four = read_below(c, (own[0], 63 - own[1], own[2]), role)
                for number, limit in zip(four, (256, 64, 64)):
                    expect(0 <= number < limit, "facts beyond their bounds")
                last = four
                self.facts[end] = four[0] | (63 - four[1]) << 8 | four[2] << 14
                role = 3 if own is not None and four[0] == own[0] else 2
        if c.bit("is off"):
            for leaf in f.leaves[page]:
                if c.bit("is off"):
                    self.offsets[leaf] = read_offset(c, "value", self.m["step"][0])
        c.end()

    def split_all(self):
        V = self.f.m["V"]
        for node in range(self.f.n - 1, -1, -1):
            whose, d = self.splits[node]
            first, second = self.f.ends[node]
            code = self.codes.pop(V + node)
            begin = (code - (d >> 1), code, code - d)[whose]
            self.codes[first], self.codes[second] = begin, begin + d
            for end in (first, second):
                expect(0 <= self.codes[end] < 1 << 31, "codes beyond 31 bits")
                if end >= V:
                    mine, theirs = facts_of(self.facts[node]), facts_of(self.facts[end - V])
                    nested = mine[0] >= theirs[0] and mine[1] <= theirs[1]
                    expect(nested and mine[2] >= theirs[2], f"node {node}: facts are not nested")

    def values(self):
        exponent, first = self.m["step"]
        return [added(math.ldexp(float(first + self.codes[leaf]), exponent),
                      self.offsets.get(leaf, 0.0)) for leaf in range(self.f.m["V"])]


def read_step(c, axis, n_leaves, view):
    """The number, and how many bits it has."""
    bits = c.symbol(5, "bits", axis, view)
    number = 0
    if bits:
        zeros = c.symbol(4, "zeros", axis, n_leaves)
        expect(zeros < bits, "too many zeros")
        if zeros < 15 and bits - zeros > 1:
            number = 2 * read_tail(c, axis, bits, bits - zeros - 2) + 1
        else:
            number = read_tail(c, axis, bits, bits - zeros - 1)
        number <<= zeros
        if c.bit("negative", axis):
            number = -number
    return number, bits


def read_tail(c, axis, bits, k):
    """Models are those of the axis and bits, whatever is left of these."""
    i = 1
    for _ in range(min(k, 3)):
        i = 2 * i + c.bit("tail", axis, bits, i)
    return i << max(0, k - 3) | c.plain(max(0, k - 3))


def read_below(c, mine, role):
    found = []
    for which, most in enumerate(mine):
        less = 0
        if c.bit("less", role, which):
            less = 1 + c.number("less", role, which)
        found.append(most - less)
    return found


def read_offset(c, axis, exponent):
    if not c.bit("axis", axis):
        return 0.0
    halvings = unzigzag(c.number("halvings", axis))
    size = c.wide("offset", axis)
    sign = -1.0 if c.bit("sign", axis) else 1.0
    return sign * math.ldexp(float(size), exponent - halvings)


class PageReader:
    def __init__(self, file, page):
        self.f, self.m, self.page = file, file.m, page
        self.c = Bits(file.take(PAGES, page))
        self.nodes = file.nodes[page]
        self.next_leaf = iter(file.leaves[page])
        self.recent = {"parent": [], "end": []}
        self.last_new = {"parent": page, "end": page}

    def read(self):
        self.read_trees()
        for node in self.order:
            self.read_split(node)
        self.last = [0, 0, 0, 0]
        for node in self.order:
            self.read_facts(node)
        self.read_offsets()
        if self.f.has_marks:
            last = 0
            for node in self.nodes:
                marks = []
                for _ in range(self.c.count(5, "marks")):
                    if self.c.bit("other mark"):
                        last = self.c.wide("mark")
                    marks.append(last)
                self.f.marks[node] = marks
        expect(next(self.next_leaf, None) is None, "leaves left over")
        self.c.end()

    def read_trees(self):
        c, n, sizes = self.c, len(self.nodes), []
        while sum(sizes) < n:
            sizes.append(1 + c.count(4, "size", min(len(sizes), 3)))
        expect(sum(sizes) == n, "levels of more nodes than there are")
        self.next_place = [sum(sizes[:k]) for k in range(len(sizes))]
        self.end_place = [sum(sizes[: k + 1]) for k in range(len(sizes))]
        self.order, self.here = [], set()
        level = 0
        while len(self.order) < n:
            level += c.number("root level")
            node = self.take_place(level)
            self.f.parents[node] = None if c.bit("is base") else self.read_far("parent")
            self.read_ends(node, level, len(sizes))

    def take_place(self, level):
        expect(level < len(self.next_place), "a level beyond the last")
        place = self.next_place[level]
        expect(place < self.end_place[level], "more nodes than a level has")
        self.next_place[level] += 1
        self.order.append(self.nodes[place])
        self.here.add(self.nodes[place])
        return self.nodes[place]

    def read_ends(self, root, root_level, n_levels):
        """Of a root and of all near nodes below it."""
        c, pending = self.c, [(None, None, root, root_level)]
        while pending:
            parent, end, node, level = pending.pop()
            if parent is not None:
                gap = 1 + c.number("below", 8 * level // n_levels)
                expect(gap <= level, "a level below the first")
                level -= gap
                node = self.take_place(level)
                self.f.ends[parent][end] = self.m["V"] + node
                self.f.parents[node] = self.m["V"] + parent
            kinds = divmod(c.symbol(4, "kinds", 8 * level // n_levels), 3)
            expect(kinds[0] <= FAR and (kinds[0] != LEAF or kinds[1] == LEAF), "no such ends")
            self.f.ends[node] = [None, None]
            for end in (1, 0):
                if kinds[end] == LEAF:
                    self.f.ends[node][end] = next(self.next_leaf)
                elif kinds[end] == FAR:
                    self.f.ends[node][end] = self.read_far("end")
            pending += [(node, end, None, level) for end in (0, 1) if kinds[end] == NEAR]

    def read_far(self, kind):
        recent = self.recent[kind]
        rank = self.c.number("rank", kind)
        expect(rank <= len(recent), "a page that was not linked to")
        if rank == len(recent):
            page = self.last_new[kind] + unzigzag(self.c.wide("page", kind))
            expect(0 <= page < self.m["P"] and page != self.page, "no other page")
            self.last_new[kind] = page
        else:
            page = recent.pop(rank)
        recent.insert(0, page)
        nodes = self.f.nodes[page]
        return self.m["V"] + nodes[self.c.below(len(nodes))]

    def read_split(self, node):
        c = self.c
        n_leaves = sum(v < self.m["V"] for v in self.f.ends[node])
        where = c.symbol(2, "where")
        whose = c.symbol(2, "whose", where)
        expect(max(where, whose) <= 2, "no place")
        difference, before = [], n_leaves
        for axis in range(4):
            number, bits = read_step(c, axis, n_leaves, before)
            difference.append(number)
            before = bits // 4
        mask, seen = 0, ()
        size = c.symbol(6, "mask size")
        expect(size <= 60, "a mask of too many bits")
        for i in range(size - 1):
            bit = c.bit("mask", seen)
            mask |= bit << i
            seen = (*seen, bit)[-3:]
        if size:
            mask |= 1 << (size - 1)
        self.f.splits[node] = (where, whose, difference, mask)

    def read_facts(self, node):
        c, V = self.c, self.m["V"]
        ends = [v - V for v in self.f.ends[node] if v >= V]
        parent = self.f.parents[node]
        own = None
        if parent is not None and parent - V in self.here:
            own = self.f.facts[node]
        role = 1 if len(ends) == 2 else 0
        for k, end in enumerate(ends):
            if own is None:
                four = [self.last[which] + c.signed("beside", k, which) for which in range(4)]
            else:
                mine = facts_of(own)
                four = read_below(c, (mine[0], 63 - mine[1], mine[2], mine[3]), role)
            for number, limit in zip(four, (256, 64, 64, 4096)):
                expect(0 <= number < limit, "facts beyond their bounds")
            self.last = four
            error, low, high, radius = four[0], 63 - four[1], four[2], four[3]
            knots = self.m["fields"][0]["knots"]
            expect(knots[low] <= knots[high], "no range")
            self.f.facts[end] = error | low << 8 | high << 14 | radius << 20
            role = 3 if own is not None and error == facts_of(own)[0] else 2

    def read_offsets(self):
        c = self.c
        if not c.bit("is off"):
            return
        for leaf in self.f.leaves[self.page]:
            if not c.bit("is off"):
                continue
            self.f.offsets[leaf] = [read_offset(c, axis, step[0])
                                    for axis, step in enumerate(self.f.steps())]


def split_all(file):
    """Splits all vertices; gives the tetrahedra as (corners, mark)."""
    V, outside = file.m["V"], file.m["V"] + file.n
    cells, around = {}, collections.defaultdict(set)

    def put(number, corners, mark):
        cells[number] = (corners, mark)
        for v in corners:
            around[v].add(number)

    for number, (corners, mark) in enumerate(file.cells):
        put(number, corners, mark)
    n_inner = sum(outside not in corners for corners, _ in cells.values())
    expect(n_inner == file.m["n_base"], f"{n_inner} cells of the base")
    # Nothing is above the largest label.
    for node in range(file.n - 1, -1, -1):
        split(file, node, cells, around, put)
    return list(cells.values())


def split(file, node, cells, around, put):
    V, outside = file.m["V"], file.m["V"] + file.n
    label = V + node
    expect(label in file.codes, f"vertex {label} is not there")
    where, whose, difference, mask = file.splits[node]
    first, second = file.ends[node]
    expect(second < first < label, f"vertex {label}: labels do not fall")
    ends = [[], []]
    for axis, d in enumerate(difference):
        place, code = where if axis < 3 else whose, file.codes[label][axis]
        begin = (code - (d >> 1), code, code - d)[place]
        ends[0].append(begin)
        ends[1].append(begin + d)
    expect(all(0 <= code < 1 << 31 for of in ends for code in of), "codes beyond 31 bits")
    del file.codes[label]
    file.codes[first], file.codes[second] = ends
    star = sorted((sorted(v for v in cells[i][0] if v != label), i) for i in around.pop(label))
    expect(all(v == outside or v < label for face, _ in star for v in face), "a larger label")
    sides, common = collections.defaultdict(list), {}
    for i, (face, number) in enumerate(star):
        end = second if mask >> i & 1 else first
        corners, mark = cells[number]
        for v in corners:
            around[v].discard(number)
        put(number, tuple(end if v == label else v for v in corners), mark)
        common[outside in face] = mark
        for left_out in range(3):
            sides[tuple(face[:left_out] + face[left_out + 1 :])].append(end)
    outline = sorted(edge for edge, of in sides.items() if sorted(of) == [second, first])
    marks = file.marks.get(node, [])
    expect(not marks or len(marks) == len(outline), f"node {node}: number of marks")
    for k, edge in enumerate(outline):
        put(len(cells), (*edge, first, second), marks[k] if marks else common[outside in edge])
    for end in (first, second):
        if end >= V:
            expect(file.parents[end - V] == label, f"vertex {end} has another parent")
            mine, theirs = facts_of(file.facts[node]), facts_of(file.facts[end - V])
            nested = mine[0] >= theirs[0] and mine[1] <= theirs[1] and mine[2] >= theirs[2]
            expect(nested and mine[3] >= theirs[3], f"node {node}: facts are not nested")


def added(coded, offset):
    return offset if offset == 0 and math.copysign(1, offset) < 0 else coded + offset


def vertices_of(file):
    """By leaf: position and values."""
    further = [field.values() for field in file.further]
    found = []
    for leaf in range(file.m["V"]):
        numbers = []
        for axis, (exponent, first) in enumerate(file.steps()):
            coded = math.ldexp(float(first + file.codes[leaf][axis]), exponent)
            numbers.append(added(coded, file.offsets.get(leaf, [0.0] * 4)[axis]))
        found.append((*numbers, *(values[leaf] for values in further)))
    return found


def check_coincident(file):
    """That those told apart are those that lie where others do, by the bits of their places."""
    places = [struct.unpack("3Q", struct.pack("3d", *at[:3])) for at in vertices_of(file)]
    times = collections.Counter(places)
    wanted = [leaf for leaf, place in enumerate(places) if times[place] > 1]
    expect(sorted(file.coincident) == wanted, "other leaves lie where others do")
    listed = [places[leaf] for leaf in file.coincident]
    expect(listed == sorted(listed), "leaves at one place are not together")


def compare(file, cells, path):
    """Tetrahedra, and faces of patches, by what is at their corners, with their marks."""
    mesh, to_numpy = tetra.load_mesh(path)
    points = to_numpy(mesh.GetPoints().GetData()).astype(float)
    values = [to_numpy(mesh.GetPointData().GetArray(field["name"])).astype(float).tolist()
              for field in file.m["fields"]]
    theirs = [(*p, *v) for p, *v in zip(points.tolist(), *values)]
    mine = vertices_of(file)
    corners = to_numpy(mesh.GetCells().GetConnectivityArray())
    begins = to_numpy(mesh.GetCells().GetOffsetsArray())
    outside = file.m["V"] + file.n
    for size, name, ids in ((4, "RegionId", file.m["regions"] or [0]),
                            (3, "PatchId", [0] + [i for i, _ in file.m["patches"]])):
        given = mesh.GetCellData().GetArray(name)
        wanted, found = collections.Counter(), collections.Counter()
        for i, begin in enumerate(begins[:-1]):
            mark = int(given.GetTuple1(i)) if given else ids[0]
            if begins[i + 1] - begin == size and (size == 4 or mark != 0):
                at = corners[begin : begins[i + 1]].tolist()
                wanted[tuple(sorted(theirs[v] for v in at)), mark] += 1
        for cell, mark in cells:
            inner = [v for v in cell if v != outside]
            if len(inner) == size and (size == 4 or mark != 0):
                found[tuple(sorted(mine[v] for v in inner)), ids[mark]] += 1
        expect(wanted == found, "tetrahedra are others" if size == 4 else "faces are others")


def check_world_errors(file):
    """Codes are nested along splits; the base's is the largest of a root."""
    V = file.m["V"]
    for i, field in enumerate(file.m["fields"]):
        if field["in_space"] is None:
            continue
        codes = {}
        for page in range(file.m["P"]):
            c = Cursor(file.library, file.take(WORLD_ERRORS, page, i))
            codes.update(zip(file.nodes[page], c.bytes(len(file.nodes[page])).tolist()))
            c.end()
        for node, code in codes.items():
            for end in file.ends[node]:
                expect(end < V or codes[end - V] <= code, f"node {node}: world error is not nested")
        largest = max((codes[root - V] for root in file.roots if root >= V), default=0)
        box = file.m["box"]
        expect(field["in_space"] == tetra.world_error(largest, box[:3], box[3:]),
               "the base's world error is another")


def main():
    file = File(sys.argv[1])
    file.read_pages()
    check_world_errors(file)
    left_over = [key for key in file.blocks if key[0] != 0]
    expect(not left_over, f"blocks left over: {left_over[:5]}")
    cells = split_all(file)
    inner = [cell for cell, _ in cells if file.m["V"] + file.n not in cell]
    expect(len(inner) == file.m["n_reference"], f"got {len(inner)} cells")
    check_coincident(file)
    if len(sys.argv) > 2:
        compare(file, cells, sys.argv[2])
    print(f"vertices {file.m['V']} cells {len(inner)} nodes {file.n}")


if __name__ == "__main__":
    try:
        main()
    except (BadFile, struct.error) as error:
        print(error)
        sys.exit(1)
