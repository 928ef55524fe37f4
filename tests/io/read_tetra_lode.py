"""Reads a tetra_mt file, rebuilds the mesh of full resolution, and compares it with the mesh that
was read: section 7 written from docs/format.md alone, the mesh by VTK.

read_tetra_lode.py FILE.lode [MESH.vtu]

Shares no code with Lode. Checks blocks and their numbers, applies all nodes in an order of their
own, each after its parents, and compares tetrahedra, positions, values, regions and patches with the mesh's;
errors, ranges, boxes and masks of regions are nested along discovery. Prints numbers of vertices, cells and nodes.

One file, although long: it stands for a reader that somebody wrote from the document, with nothing
else at hand.

Exit status: 0, 1 for a bad file, 2 where numpy, VTK or libzstd is absent.
"""

import bisect
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
BASE_VERTICES, BASE_CELLS, ROOTS, LINKS, FIELD, GRADIENTS, BASE_VALUES, ORIGINS, WORLD_ERRORS = range(1, 10)
FRONT, FRONT_FACTS = 10, 11


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


class Bits:
    """Coded bits of a block. Models are made when a key first asks for one that is not given."""

    def __init__(self, raw, models=None):
        self.raw, self.at, self.models = raw, 0, {} if models is None else models
        self.r, self.c = 0xFFFFFFFF, 0
        for _ in range(4):
            self.c = self.c << 8 | self.next_byte()

    def next_byte(self):
        self.at += 1
        return self.raw[self.at - 1] if self.at <= len(self.raw) else 0

    def refill(self):
        while self.r < 1 << 24:
            self.r <<= 8
            self.c = (self.c << 8 | self.next_byte()) & 0xFFFFFFFF

    def bit(self, *key):
        model = self.models.setdefault(key, [32768, 0])
        z, s = model
        b = (self.r >> 16) * z
        t = 655360 // (10 * s + 16)
        bit = int(self.c >= b)
        if bit:
            self.c, self.r = self.c - b, self.r - b
            model[0] = z - (z * t >> 16)
        else:
            self.r = b
            model[0] = z + ((65536 - z) * t >> 16)
        model[1] = min(s + 1, 60)
        self.refill()
        return bit

    def one_of(self, n):
        self.r //= n
        number = min(self.c // self.r, n - 1)
        self.c -= self.r * number
        self.refill()
        return number

    def plain(self, k):
        number = 0
        while k > 0:
            step = min(k, 16)
            number, k = number << step | self.one_of(1 << step), k - step
        return number

    def below(self, n):
        k = max(0, (n - 1).bit_length() - 16)
        return self.one_of(((n - 1) >> k) + 1) << k | self.plain(k)

    def symbol(self, k, *key):
        i = 1
        for _ in range(k):
            i = 2 * i + self.bit(*key, "symbol", i)
        return i - (1 << k)

    def tail(self, k, *key):
        i = 1
        for _ in range(min(k, 3)):
            i = 2 * i + self.bit(*key, "tail", k, i)
        return i << max(0, k - 3) | self.plain(max(0, k - 3))

    def number(self, *key):
        return self.tail(min(self.symbol(5, *key), 16), *key) - 1

    def wide(self, *key):
        k = self.symbol(7, *key)
        return self.tail(min(k - 1, 63), *key) if k else 0

    def count(self, k, *key):
        few = self.symbol(k, *key)
        return few if few < (1 << k) - 1 else few + self.number(*key, "many")

    def signed(self, *key):
        return unzigzag(self.number(*key))

    def end(self):
        expect(0 <= self.at - len(self.raw) <= 4, "bytes left over, or missing")


def read_primed(n, read):
    """read(page, models) of all pages: primers teach the models with which the others begin."""
    def softened():
        return {key: [z, min(s, 14)] for key, (z, s) in models.items()}

    models, out = {}, {}
    for page in sorted({(2 * k + 1) * n // 6 for k in range(3)}) if n else []:
        models = softened()
        out[page] = read(page, models)
    for page in range(n):
        if page not in out:
            out[page] = read(page, softened())
    return [out[page] for page in range(n)]


def unzigzag(code):
    return code // 2 if code % 2 == 0 else -(code + 1) // 2


def ordered(number, narrow):
    """Bits of a float as a number that is larger for a larger one."""
    number = 0.0 * -1 if number == 0 else number
    width, fmt = (32, "<fI") if narrow else (64, "<dQ")
    bits = struct.unpack("<" + fmt[2], struct.pack(fmt[:2], number))[0]
    return bits ^ ((1 << width) - 1 if bits >> (width - 1) else 1 << (width - 1))


def unordered(number, narrow):
    width, fmt = (32, "<fI") if narrow else (64, "<dQ")
    expect(0 <= number < 1 << width, "no bits of a float")
    bits = number ^ (1 << (width - 1) if number >> (width - 1) else (1 << width) - 1)
    found = struct.unpack(fmt[:2], struct.pack("<" + fmt[2], bits))[0]
    expect(math.isfinite(found), "no finite number")
    return found


def read_coordinates(c, n, narrow):
    tables = []
    for axis in range(3):
        size = c.plain(10)
        table = [c.wide("first coordinate")] if size else []
        while len(table) < size:
            table.append(table[-1] + 1 + c.wide("gap", axis))
        tables.append(table)
    at, rows = [0, 0, 0], []
    for _ in range(n):
        odd = tuple(at[a] % 2 if tables[a] else 0 for a in range(3))
        steps, row = 0, [0.0, 0.0, 0.0]
        for axis in (2, 1, 0):
            if not tables[axis]:
                difference = unzigzag(c.wide("difference", axis))
                at[axis] = (at[axis] + difference) % (1 << 64)
                row[axis] = unordered(at[axis], narrow)
                continue
            case = ("step", axis, odd, steps)
            step = 0
            while step < 3 and c.bit(*case, step):
                step += 1
            if step == 3:
                is_back = c.bit("is back", axis)
                by = c.number("far step", axis) + 2
                at[axis] += -by if is_back else by
            else:
                at[axis] += (0, 1, -1)[step]
            steps = 4 * steps + step
            expect(0 <= at[axis] < len(tables[axis]), "no coordinate of the table")
            row[axis] = unordered(tables[axis][at[axis]], narrow)
        rows.append(row)
    return np.array(rows).reshape(-1, 3)


class PageReader:
    """Links of the nodes of a page; vertices are numbered with the base's first."""

    def __init__(self, file, page, c):
        self.c, self.m, self.page = c, file.m, page
        self.n = file.n_page_vertices[page]
        self.n_pages, self.sizes = file.n_pages, file.n_page_vertices
        self.first = self.m["B"] + PAGE * page

    def read(self):
        c, n = self.c, self.n
        self.positions = read_coordinates(c, n, self.m["narrow"])
        self.read_counts()
        self.read_far_vertices()
        self.children = [self.read_children(i, 0, self.discovered[i]) for i in range(n)]
        places = [[v - self.first for v in kids] for kids in self.children]
        self.tree = [[p for p in of if 0 <= p < n] for of in places]
        self.order = tree_order(self.tree)
        self.is_whole = [False] * n
        for i in self.order:
            self.read_others(i)
        self.boxes = [None] * n
        for i in self.order:
            self.boxes[i] = self.read_box(i)
        self.far_parents = [
            [self.read_far("parent", k) for k in range(self.n_far[i])] for i in range(n)
        ]
        parents = [list(far) for far in self.far_parents]
        for i, kids in enumerate(self.children):
            for v in kids:
                if 0 <= v - self.first < n:
                    parents[v - self.first].append(self.first + i)
        self.parents = [sorted(of) for of in parents]
        self.targets = []
        for i in range(n):
            self.targets.append(self.read_target(i))
        self.makers = [self.read_makers(i) for i in range(n)]
        self.regions = self.read_regions()
        self.masks = self.read_masks()
        c.end()

    def is_near(self, vertex):
        return 0 <= vertex - self.first < self.n

    def read_counts(self):
        c = self.c
        self.n_children, self.discovered, self.n_far, self.n_makers = [], [], [], []
        children = far = 0
        for _ in range(self.n):
            children = c.count(4, "children", min(children // 2, 4))
            self.n_children.append(children)
            self.discovered.append(c.count(4, "discovered", min(children, 12)))
            far = c.count(4, "far parents", min(far, 6))
            self.n_far.append(far)
            makers = 0
            if children:
                makers = c.bit("odd makers")
                makers += 2 * c.count(5, "makers", min(children, 10))
            self.n_makers.append(makers)
            expect(makers >= children, "fewer makers than children")

    def read_far_vertices(self):
        c = self.c
        self.far = []
        page = -1
        for _ in range(c.number("pages")):
            page += c.wide("page") + 1
            expect(page < len(self.sizes) and page != self.page, "no other page")
            begin = PAGE * page + self.m["B"]
            if page >= self.n_pages:
                begin = PAGE * (page - self.n_pages)
            m = c.number("far vertices") + 1
            place, vertices = -1, []
            for _ in range(m):
                place += c.number("far vertex", m.bit_length()) + 1
                expect(place < self.sizes[page], "a place beyond a page")
                vertices.append(begin + place)
            self.far.append([vertices, 0])

    def read_far(self, kind, o):
        rank = self.c.number("far page", kind, min(o, 2))
        expect(rank < len(self.far), "a page that is not linked to")
        entry = self.far.pop(rank)
        self.far.insert(0, entry)
        vertices, last = entry
        if len(vertices) > 1:
            last += self.c.signed("far place", kind, len(vertices).bit_length())
        expect(0 <= last < len(vertices), "a far vertex beyond those of its page")
        entry[1] = last
        expect(kind == "target" or vertices[last] >= self.m["B"], "a link to no node")
        return vertices[last]

    def read_children(self, i, which, n):
        c, out, before, last, n_far = self.c, [], 0, None, 0
        for _ in range(n):
            if not c.bit("is near", which, before, min(self.n_children[i], 6)):
                out.append(self.read_far("child", n_far))
                before, n_far = 2, n_far + 1
                continue
            before = 1
            if last is None:
                step = c.signed("first near", which)
                last = i + (step + 1 if step >= 0 else step)
            else:
                others = [p for p in range(self.n) if p > last and p != i]
                skip = c.number("next near", which)
                expect(skip < len(others), "a near child beyond the page")
                last = others[skip]
            expect(0 <= last < self.n, "a near child beyond the page")
            out.append(self.first + last)
        return out

    def read_others(self, i):
        """Children that i does not discover: first of those that its children have, then others."""
        kids, left = self.children[i], self.n_children[i] - self.discovered[i]
        waiting, seen, shared = {}, {self.first + i, *kids}, []

        def wait_for_children_of(v):
            if self.is_near(v) and self.is_whole[v - self.first]:
                for w in self.children[v - self.first]:
                    if w not in seen:
                        waiting[w] = waiting.get(w, 0) + 1

        for v in kids:
            wait_for_children_of(v)
        while len(shared) < left and waiting:
            v = min(waiting)
            times = waiting.pop(v)
            seen.add(v)
            if self.c.bit("shared", self.is_near(v), min(times, 4), min(left - len(shared), 4)):
                shared.append(v)
                wait_for_children_of(v)
        shared += self.read_children(i, 1, left - len(shared))
        self.children[i] = kids + sorted(shared)
        self.is_whole[i] = True
        expect(len(set(self.children[i])) == self.n_children[i], "a child twice")

    def role(self, i, child):
        if not self.is_near(child):
            return "far"
        target = self.targets[child - self.first]
        return "own" if target == self.first + i else "target" if target == self.targets[i] else "other"

    def read_box(self, i):
        c, d = self.c, self.discovered[i]
        least = min((self.boxes[k][0] for k in self.tree[i]), default=17 if d else 16)
        exponent = c.symbol(4, "exponent", least, min(d, 2))
        steps = []
        for k in range(6):
            size = 2 if k < 2 else int(max(steps) > 3)
            before = steps[-1] if steps else 8
            steps.append(c.symbol(3, "box", k, d > 0, before, size))
        return (exponent, *steps)

    def read_target(self, i):
        c, parents, own = self.c, self.parents[i], self.first + i
        n = len(parents)
        if n and c.bit("is parent", min(n, 6)):
            for k, v in enumerate(parents[:-1]):
                if c.bit("which parent", min(n, 6), min(k, 6), self.is_near(v)):
                    return v
            return parents[-1]
        asked = []
        for v in parents + self.children[i]:
            if not 0 <= v - self.first < i:
                continue
            shared = self.targets[v - self.first]
            if shared in asked or shared in parents or shared == own:
                continue
            if c.bit("is shared", min(len(asked), 6)):
                return shared
            asked.append(shared)
        if c.bit("is near target"):
            found = own + c.signed("near target")
            expect(self.is_near(found) and found != own, "a target beyond the page")
            return found
        return self.read_far("target", 0)

    def read_makers(self, i):
        c, n, n_makers = self.c, self.n_children[i], self.n_makers[i]
        if n == 0:
            return []
        d = n + (c.bit("has others", min(n, 6)) if n_makers > n else 0)
        roles = [self.role(i, child) for child in self.children[i]] + ["reference"]
        seen, unseen, out = [], list(range(d)), []
        for k in range(n_makers):
            s, u = len(seen), len(unseen)
            found = None
            if n_makers - k > u:
                for place in range(s - 1 if u == 0 else s):
                    uses = min(out.count(seen[place]), 4)
                    early = k < n_makers // 3
                    case = min(s, 6), min(u, 3), early, min(place, 5), uses, roles[seen[place]]
                    if c.bit("seen", *case):
                        found = seen[place]
                        break
                if found is None and u == 0:
                    found = seen[-1]
            if found is None:
                found = unseen[-1]
                for place in range(u - 1):
                    if c.bit("not seen", min(u, 6), min(place, 6), roles[unseen[place]]):
                        found = unseen[place]
                        break
            (seen if found in seen else unseen).remove(found)
            seen.insert(0, found)
            out.append(found)
        return out

    def read_regions(self):
        if n_labels(self.m) < 2:
            return [[] for _ in range(self.n)]
        out, last = [], 0
        for _ in range(self.n):
            out.append([])
            for _ in range(self.c.count(5, "regions")):
                if self.c.bit("other region"):
                    last = self.c.wide("region")
                out[-1].append(last)
        return out


    def read_masks(self):
        c, regions = self.c, len(self.m["regions"])
        if regions < 2:
            return [None] * self.n
        table = [c.wide("mask") for _ in range(c.number("masks") + 1)]
        expect(len(set(table)) == len(table) <= self.n, "a mask twice")
        expect(all(0 < mask < 1 << min(regions, 64) for mask in table), "a mask of no region")
        masks, last = [table[0]] * self.n, table[0]
        if len(table) == 1:
            return masks
        for i in self.order:
            expected = 0 if self.tree[i] else last
            for k in self.tree[i]:
                expected |= masks[k]
            if not c.bit("expected mask", len(self.tree[i]) > 0):
                place = c.number("mask place")
                expect(place < len(table), "a mask beyond those of the page")
                expected = table[place]
            masks[i] = last = expected
        return masks


def tree_order(found):
    """All nodes of a page, those that each discovers before it."""
    discoverer, waiting = {}, [len(of) for of in found]
    for i, of in enumerate(found):
        for k in of:
            expect(k not in discoverer, "a node is discovered twice")
            discoverer[k] = i
    order = [i for i, n in enumerate(waiting) if n == 0]
    for k in order:
        i = discoverer.get(k)
        if i is not None:
            waiting[i] -= 1
            if waiting[i] == 0:
                order.append(i)
    expect(len(order) == len(found), "nodes that discover each other")
    return order


def read_values(c, n, knots, narrow):
    """Values of a page's nodes, and their places."""
    levels = [ordered(k, narrow) for k in knots]
    values, places, place = [], [], 32768
    for _ in range(n):
        place += c.signed("value")
        k, j = divmod(place, 256)
        expect(0 <= k < 256, "a place beyond the knots")
        number = levels[k]
        if k == 255:
            number += c.bit("above the last knot")
        else:
            w = levels[k + 1] - number
            expect(w > 0, "a place between knots that are alike")
            q = max(0, w.bit_length() - 40)
            v = ((w - 1) >> q) + 1
            begin, end = (min(w, (i * v + 255) // 256 << q) for i in (j, j + 1))
            expect(begin < end, "a place of no values")
            number += begin + c.below(end - begin)
        values.append(unordered(number, narrow))
        places.append(place)
    return values, places


def read_facts(c, places, tree, order, discovered):
    facts = [None] * len(places)
    for i in order:
        a, found = min(places[i] // 16, 4080), tree[i]
        others = discovered[i] > len(found)
        if not found:
            o = c.symbol(5, "error", others)
            error = o << 7 | c.symbol(2, "quarter", o) << 5
            error |= c.plain(5)
            low = (a + c.signed("low", others, max(0, o - 20))) % 4096
            high = (a + c.signed("high", others, max(1, a - low).bit_length())) % 4096
        else:
            case = others, min(discovered[i], 4)
            error, low, high = facts[found[0]]
            for k in found[1:]:
                error = max(error, facts[k][0])
                low, high = min(low, facts[k][1]), max(high, facts[k][2])
            error = (error + read_more(c, 0, *case, False)) % 4096
            lower = (min(low, a) - read_more(c, 1, *case, a < low)) % 4096
            high = (max(high, a) + read_more(c, 2, *case, a > high)) % 4096
            low = lower
        facts[i] = (error, low, high)
    return [(error, low, high - low) for error, low, high in facts]


def read_more(c, *case):
    return 1 + c.number("by how much", *case) if c.bit("is more", *case) else 0


def read_regions(c):
    """Their numbers; their names are checked to be labels."""
    numbers = []
    for _ in range(c.take("I")):
        numbers.append(c.take("q"))
        name = c.take_bytes(c.take("I"))
        expect(len(name) <= 4096 and name.decode("utf-8").isprintable(), "a name that is none")
    expect(numbers == sorted(set(numbers)), "regions do not ascend")
    return numbers


def read_metadata(raw):
    c = Cursor(None, raw)
    m = {}
    expect(c.take("I") == 11, "unknown layout")
    m["B"], m["N"], m["narrow"] = c.take("IIB")
    m["n_reference"], m["n_base"], m["T"], m["R"] = c.take("4Q")
    m["box"] = c.take("6d")
    m["deviation"] = c.take("d")
    m["regions"] = read_regions(c)
    m["patches"] = [(c.take("q"), c.take_bytes(c.take("I")).decode("utf-8")) for _ in range(c.take("I"))]
    m["record"] = read_record(c)
    m["fields"] = []
    for _ in range(c.take("I")):
        f = {"name": c.take_bytes(c.take("I")).decode("utf-8")}
        f["type"], f["narrow"], f["everywhere"], f["has_time"], f["time"] = c.take("BBBBd")
        f["base_error"], f["min"], f["max"] = c.take("3d")
        f["in_space"] = read_base_world_error(c)
        m["fields"].append(f)
    c.end()
    return m


def read_record(c):
    """How the file was built."""

    def text():
        return c.take_bytes(c.take("I")).decode("utf-8")

    order, keeps_extrema, tolerance, volume = c.take("BBdd")
    expect(order < 3 and keeps_extrema < 2 and tolerance >= 0, "a wrong record")
    refusals = [(text(), c.take("Q")) for _ in range(c.take("I"))]
    reading = [(text(), c.take("Q")) for _ in range(c.take("I"))]
    notes = [(text(), text()) for _ in range(c.take("I"))]
    return {"order": order, "tolerance": tolerance, "volume": volume, "refusals": refusals,
            "reading": reading, "notes": notes}


def read_base_world_error(c):
    """None where the field has none."""
    has, error = c.take("B"), c.take("d")
    expect(has < 2 and error >= 0 and (has == 1 or error == 0), "a world error of nothing")
    return error if has else None


def world_error(code, lower, upper):
    """Rounded up to single precision."""
    if code in (0, 255):
        return 0.0 if code == 0 else math.inf
    diagonal = float(np.sqrt(((np.array(upper) - np.array(lower)) ** 2).sum()))
    exponent = min(max(math.frexp(diagonal)[1], -90), 126) if diagonal > 0 else 0
    octave, step = divmod(code - 1, 8)
    return float(np.float32(math.ldexp(1 + step / 8, exponent - 31 + octave)))


def n_labels(m):
    return max(len(m["regions"]), len(m["patches"]) + 1 if m["patches"] else 0)


def parts(n, size):
    """How many each has, where n are cut in parts of `size`, the last of what is left."""
    return [min(size, n - i) for i in range(0, n, size)]


class BaseWalk:
    """Cells of the base, each across a face of one before it or begun anew."""

    def __init__(self, m, c):
        self.m, self.c, self.outside = m, c, m["B"] + m["N"]
        self.cells, self.makers, self.marks, self.across = [], [], [], []
        self.gates, self.open, self.last_vertex, self.last_maker = [], {}, 0, 0
        self.last_mark = [0, 0]

    def read(self):
        c, n, gate, came = self.c, self.m["T"], 0, 1
        while len(self.cells) < n:
            if gate == len(self.gates):
                self.add([self.vertex(self.last_vertex) for _ in range(4)], range(4))
                self.data([], 0, None)
                continue
            t, place = self.gates[gate]
            gate += 1
            if self.across[t][place] is None:
                came = c.bit("comes", came)
                if came:
                    self.attach(t, place)
        c.end()

    def face(self, t, place):
        at = ((1, 2, 3), (0, 3, 2), (0, 1, 3), (0, 2, 1))[place]
        return [self.cells[t][k] for k in at]

    def attach(self, t, place):
        face = self.face(t, place)
        last, is_known = None, 0
        for k, (v, edges, steps) in enumerate(self.candidates(t, place, face)):
            if self.c.bit("candidate", edges, min(steps, 3), k):
                last, is_known = v, 1
                break
        if last is None:
            last = self.vertex(face[0])
        del self.open[tuple(sorted(face))]
        new = len(self.cells)
        self.add(face + [last], range(3))
        self.across[new][3], self.across[t][place] = t, new
        beside = [self.makers[self.across[new][k]] for k in (3, 0, 1, 2) if self.across[new][k] is not None]
        self.data(list(dict.fromkeys(beside)), is_known, t)

    def vertex(self, base):
        if self.c.bit("outside"):
            return self.outside
        base = self.last_vertex if base == self.outside else base
        self.last_vertex = base + unzigzag(self.c.wide("vertex"))
        expect(0 <= self.last_vertex < self.m["B"], "a vertex beyond the base's")
        return self.last_vertex

    def candidates(self, t, place, face):
        found = []
        for e in range(3):
            edge, third, at = {face[e], face[(e + 1) % 3]}, face[(e + 2) % 3], t
            for step in range(64):
                corners = self.cells[at]
                other = next(v for v in corners if v not in edge and v != third)
                beyond = self.across[at][corners.index(third)]
                if beyond is None:
                    if other not in face:
                        same = next((f for f in found if f[0] == other), None)
                        if same:
                            same[1], same[2] = same[1] + 1, max(same[2], step)
                        else:
                            found.append([other, 1, step])
                    break
                at, third = beyond, other
        return sorted(found, key=lambda f: -f[1])

    def add(self, corners, places):
        expect(len(set(corners)) == 4, "a cell of fewer than four vertices")
        self.cells.append(corners)
        self.makers.append(NONE)
        self.marks.append(0)
        self.across.append([None] * 4)
        new = len(self.cells) - 1
        for place in places:
            key = tuple(sorted(self.face(new, place)))
            if key in self.open:
                t, other = self.open.pop(key)
                self.across[new][place], self.across[t][other] = t, new
            else:
                self.open[key] = new, place
                self.gates.append((new, place))

    def data(self, beside, is_known, last):
        c, new = self.c, len(self.cells) - 1
        for k, maker in enumerate(beside):
            if c.bit("beside", k, is_known):
                self.makers[new] = maker
                break
        else:
            if not c.bit("none"):
                self.last_maker += unzigzag(c.wide("maker"))
                expect(0 <= self.last_maker < self.m["N"], "a cell that waits for no node")
                self.makers[new] = self.last_maker
        if n_labels(self.m) < 2:
            return
        side = int(self.outside in self.cells[new])
        expected = self.last_mark[side]
        if last is not None and int(self.outside in self.cells[last]) == side:
            expected = self.marks[last]
        self.last_mark[side] = expected if c.bit("mark", side) else c.wide("mark")
        limit = len(self.m["patches"]) + 1 if side else max(1, len(self.m["regions"]))
        expect(self.last_mark[side] < limit, "a mark of nothing")
        self.marks[new] = self.last_mark[side]


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

    def take(self, kind, x, level=0):
        expect((kind, level, x) in self.blocks, f"no block {kind} {level} {x}")
        return self.blocks.pop((kind, level, x))

    def open(self, kind, x, level=0):
        return Cursor(self.library, self.take(kind, x, level))

    def read_base(self):
        m = self.m
        positions = [np.zeros((0, 3))]
        for part, n in enumerate(parts(m["B"], PART)):
            c = self.open(BASE_VERTICES, part)
            positions.append(np.stack([c.floats(n, m["narrow"]) for _ in range(3)], axis=1))
            c.end()
        walk = BaseWalk(m, Bits(self.take(BASE_CELLS, 0)))
        walk.read()
        roots = [np.zeros(0, int)]
        for part, n in enumerate(parts(m["R"], PART)):
            c = self.open(ROOTS, part)
            roots.append(c.differences(n, 4).astype(int))
            c.end()
        self.base_positions = np.concatenate(positions)
        self.corners = [list(corners) for corners in walk.cells]
        self.waiting, self.cell_regions = walk.makers, walk.marks
        self.roots = np.concatenate(roots).tolist()
        self.read_front()

    def read_front(self):
        """Boxes and masks of the nodes that cells of the base wait for."""
        c = Bits(self.take(FRONT, 0))
        self.front = sorted({k for k in self.waiting if k != NONE})
        place = {k: i for i, k in enumerate(self.front)}
        self.front_cells = [[] for _ in self.front]
        for corners, k, mark in zip(self.corners, self.waiting, self.cell_regions):
            if k != NONE:
                self.front_cells[place[k]].append((corners, mark))
        self.front_boxes, exponent = [], 0
        for cells in self.front_cells:
            at = self.base_positions[[v for corners, _ in cells for v in corners if v < self.m["B"]]]
            exponent = c.symbol(4, "exponent", exponent)
            low, high = (self.grid(x, exponent) for x in (at.min(axis=0), at.max(axis=0)))
            lower, upper, last = [], [], 0
            for axis in range(3):
                step = c.signed("box", 0, min(last, 3))
                lower.append(math.floor(low[axis]) - step)
                last = step = abs(step)
                step = c.signed("box", 1, min(last, 3))
                upper.append(math.ceil(high[axis]) + step)
                last = abs(step)
            self.front_boxes.append((exponent, lower, upper))
        self.front_masks = []
        for cells in self.front_cells if len(self.m["regions"]) > 1 else []:
            guess = 0
            for corners, mark in cells:
                if max(corners) < self.m["B"]:
                    guess |= 1 << mark % 64
            self.front_masks.append(guess ^ c.wide("mask"))
        c.end()

    def grid(self, at, exponent):
        """Places on the grid of an exponent."""
        lower, upper = np.array(self.m["box"][:3]), np.array(self.m["box"][3:])
        width = 2.0 ** math.frexp(float((upper - lower).max()))[1]
        lower = np.floor(lower / (width / 32768)) * (width / 32768)
        return (at - lower) / width * 2.0**exponent

    def check_front(self):
        """It says what pages do."""
        for k, (exponent, lower, upper) in zip(self.front, self.front_boxes):
            own, *steps = self.boxes[k]
            middle = np.floor(self.grid(self.positions[self.m["B"] + k], exponent))
            expect(own == exponent, f"node {k}: another exponent with the base")
            expect(lower == [m - s % 8 for m, s in zip(middle, steps)], f"node {k}: another box")
            expect(upper == [m + s // 8 for m, s in zip(middle, steps)], f"node {k}: another box")
        for k, mask in zip(self.front, self.front_masks):
            expect(mask == self.masks[k], f"node {k}: another mask with the base")
        for f in self.m["fields"]:
            facts = [(error, low, low + width) for error, low, width in f["facts"][self.front].tolist()]
            expect(facts == f["front_facts"], "other facts with the base")
            if f["in_space"] is not None:
                codes = f["world_codes"][self.front].tolist()
                expect(codes == f["front_world_codes"], "other world errors with the base")

    def read_front_facts(self, i, values):
        f, c = self.m["fields"][i], Bits(self.take(FRONT_FACTS, 0, i))
        knots = f["knots"].tolist()
        scale = [knots[k // 16] + (knots[k // 16 + 1] - knots[k // 16]) * (k % 16 / 16) if k % 16
                 else knots[k // 16] for k in range(4081)]
        facts, o = [], 0
        for cells in self.front_cells:
            of_cells = [values[v] for corners, _ in cells for v in corners if v < self.m["B"]]
            o = c.symbol(5, "error", o)
            error = o << 7 | c.symbol(2, "quarter", o) << 5
            error |= c.plain(5)
            below = max(bisect.bisect_right(scale, min(of_cells)) - 1, 0)
            low = (below + c.signed("low", max(o, 20))) % 4096
            high = (bisect.bisect_left(scale, max(of_cells)) + c.signed("high", max(o, 20))) % 4096
            facts.append((error, low, high))
        f["front_facts"] = facts
        if f["in_space"] is not None:
            f["front_world_codes"] = [c.symbol(8, "world error") for _ in self.front]
        c.end()

    def read_links(self):
        m = self.m
        self.target, self.children, self.discovered = [], [], []
        self.far_parents, self.makers, self.new_regions = [], [], []
        self.boxes, self.masks, self.trees, positions = [], [], [], []
        for page in read_primed(self.n_pages, self.read_links_of):
            self.add_links(page, positions)
        self.positions = np.concatenate([self.base_positions] + positions)
        self.parents = [[] for _ in range(m["N"])]
        for k, children in enumerate(self.children):
            for child in children:
                expect(child < m["N"] and child != k, "a bad child")
                self.parents[child].append(k)
        for k, far in enumerate(self.far_parents):
            here = [p for p in self.parents[k] if p // PAGE == k // PAGE]
            expect(sorted(self.parents[k]) == sorted(here + far), f"parents of node {k}")

    def read_links_of(self, page, models):
        p = PageReader(self, page, Bits(self.take(LINKS, page), models))
        p.read()
        return p

    def add_links(self, p, positions):
        B = self.m["B"]
        positions.append(p.positions)
        self.boxes += [(b[0], *(b[k] + 8 * b[k + 1] for k in (1, 3, 5))) for b in p.boxes]
        self.target += p.targets
        children = [[v - B for v in of] for of in p.children]
        self.children += children
        self.discovered += [kids[:d] for kids, d in zip(children, p.discovered)]
        self.far_parents += [[v - B for v in of] for of in p.far_parents]
        self.makers += p.makers
        self.new_regions += p.regions
        self.masks += p.masks
        self.trees.append((p.tree, p.order, p.discovered))

    def is_lean(self):
        return not any(kind in (GRADIENTS, ORIGINS) for kind, _, _ in self.blocks)

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
        for found, of_nodes in read_primed(self.n_pages, lambda *p: self.read_field_of(i, *p)):
            values.append(np.array(found))
            facts.append(np.array(of_nodes).reshape(-1, 3))
        if not self.lean:
            pages = read_primed(len(self.n_page_vertices), lambda *p: self.read_gradients_of(i, *p))
            f["gradients"] = [code for page in pages for code in page]
        if f["in_space"] is not None:
            f["world_codes"] = np.concatenate(
                [self.read_world_codes(page, i) for page in range(self.n_pages)] or [np.zeros(0, int)])
        f["values"] = np.concatenate(base + values)
        self.read_front_facts(i, np.concatenate(base).tolist())
        f["facts"] = np.concatenate(facts) if facts else np.zeros((0, 3), int)

    def read_field_of(self, i, page, models):
        f, c = self.m["fields"][i], Bits(self.take(FIELD, page, i), models)
        n = self.n_page_vertices[page]
        values, places = read_values(c, n, f["knots"].tolist(), f["narrow"])
        facts = read_facts(c, places, *self.trees[page])
        c.end()
        return values, facts

    def read_gradients_of(self, i, page, models):
        c = Bits(self.take(GRADIENTS, page, i), models)
        codes, (l, u, v), (of_l, of_u, of_v) = [], (128, 1250, 1250), (0, 0, 0)
        for _ in range(self.n_page_vertices[page]):
            step = c.signed("length", of_l)
            l, of_l = l + step, min(abs(step).bit_length(), 8)
            step = c.signed("u", of_u)
            u, of_u = u + step, min(abs(step).bit_length(), 12)
            step = c.signed("v", (of_u + of_v) // 2)
            v, of_v = v + step, min(abs(step).bit_length(), 12)
            expect(0 <= l < 256 and 0 <= u <= 2500 and 0 <= v <= 2500, "no gradient")
            codes.append((u, v, l))
        c.end()
        return codes

    def read_world_codes(self, page, i):
        c = self.open(WORLD_ERRORS, page, i)
        codes = c.numbers(self.n_page_vertices[page], 1).astype(int)
        c.end()
        return codes


def check_world_errors(file):
    """Codes are nested; the base's is the largest that its cells wait for."""
    for f in file.m["fields"]:
        if f["in_space"] is None:
            continue
        codes = f["world_codes"]
        for k, found in enumerate(file.discovered):
            for child in found:
                expect(codes[k] >= codes[child], f"node {k}: world error is not nested")
        largest = max((codes[k] for k in file.waiting if k != NONE), default=0)
        box = np.array(file.m["box"])
        rounded = world_error(int(largest), box[:3], box[3:])
        most = max(1.13 * f["in_space"], world_error(1, box[:3], box[3:]) if f["in_space"] > 0 else 0)
        expect(f["in_space"] <= rounded <= most, "the base's world error is another")


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
    outside = file.m["B"] + file.m["N"]
    common = {outside in corners: region for corners, _, region in star}
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
    outline = [((a, b, vertex, target), common.get(outside in (a, b)))
               for (a, b), r in edges.items() if len(r) == 1]
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
    mask = 0
    for child in file.discovered[k]:
        mask |= file.masks[child] or 0
    for corners, region in brought:
        if outside not in corners and file.masks[k] is not None:
            mask |= 1 << region % 64
    expect(mask == (file.masks[k] or 0), f"node {k}: other regions than its mask says")


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
        from vtkmodules.util.numpy_support import vtk_to_numpy
        from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader
    except ImportError:
        print("expected VTK (package python3-vtk9), found none")
        sys.exit(2)
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(path)
    reader.Update()
    mesh = reader.GetOutput()
    return mesh, vtk_to_numpy


def compare(file, cells, path):
    """All tetrahedra, positions, values, regions and patches, by numbers of the mesh's points."""
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
    corners = to_numpy(mesh.GetCells().GetConnectivityArray())
    begins = to_numpy(mesh.GetCells().GetOffsetsArray())
    cell_data = mesh.GetCellData()
    outside = file.m["B"] + file.m["N"]
    for size, name, ids, what in ((4, "RegionId", file.m["regions"] or [0], "tetrahedra"),
                                  (3, "PatchId", [0] + [i for i, _ in file.m["patches"]], "faces")):
        theirs = collections.Counter()
        given = cell_data.GetArray(name)
        for i, begin in enumerate(begins[:-1]):
            label = int(given.GetTuple1(i)) if given else ids[0]
            if begins[i + 1] - begin == size and (size == 4 or label != 0):
                theirs[tuple(sorted(corners[begin : begins[i + 1]].tolist())), label] += 1
        mine = collections.Counter()
        for c, r in cells:
            inner = [v for v in c if v != outside]
            if len(inner) == size and (size == 4 or r != 0):
                mine[tuple(sorted(origins[inner].tolist())), ids[r]] += 1
        expect(mine == theirs, f"{what} are others")


def main():
    file = File(sys.argv[1])
    file.read_base()
    file.read_links()
    file.lean = file.is_lean()
    if not file.lean:
        file.read_origins()
    for i in range(len(file.m["fields"])):
        file.read_field(i)
    file.check_front()
    left_over = [key for key in file.blocks if key[0] != 0]
    expect(not left_over, f"blocks left over: {left_over[:5]}")
    file.lower, file.upper = find_boxes(file)
    check_nesting(file)
    check_values(file)
    check_world_errors(file)
    cells = replay(file)
    inner = [(c, r) for c, r in cells if file.m["B"] + file.m["N"] not in c]
    expect(len(inner) == file.m["n_reference"], f"got {len(inner)} cells")
    if len(sys.argv) > 2:
        compare(file, cells, sys.argv[2])
    print(f"{'lean ' if file.lean else ''}vertices {len(file.positions)} cells {len(inner)} nodes {file.m['N']}")


if __name__ == "__main__":
    try:
        main()
    except (BadFile, struct.error) as error:
        print(error)
        sys.exit(1)
