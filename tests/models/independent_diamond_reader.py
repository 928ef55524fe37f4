"""Reads a diamond2d or diamond3d file: section 7 written from docs/format.md alone.

Shares no code with Lode. Checks that the file has the blocks that its metadata ask for, in order;
that samples beyond the data equal the nearest ones; and that range, holes, removed cells and largest
errors are what the metadata says. Prints the model, dims, the summary and the XXH64 of the data's
samples in their storage type, x fastest.

Exit status: 0, 1 for a bad file, 2 where libzstd (package libzstd1) is absent.
"""

import itertools
import math
import pathlib
import struct
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "store"))
import independent_reader as container  # noqa: E402
from independent_reader import expect  # noqa: E402

# The struct letter of the storage type, by sample type from 1.
STORAGE = " BhHhddddfd"
INDEX, SAMPLES, ERRORS, MINIMA, MAXIMA, WORLD_ERRORS = 0, 1, 2, 3, 4, 5


def ceil_div(a, b):
    return -(-a // b)


def read_metadata(raw):
    fixed = "<3i15dBBBdI"
    values = struct.unpack_from(fixed, raw, 0)
    at = struct.calcsize(fixed) + values[-1]
    metadata = {"dims": values[:3], "type": values[19]}
    metadata["nodata"] = values[21] if values[20] else None
    names = ("min", "max", "n_holes", "n_removed_cells", "base_error")
    metadata.update(zip(names, struct.unpack_from("<2d2Qd", raw, at)))
    at += 40
    n_levels = 1
    while any(2**n_levels < n - 1 for n in metadata["dims"]):
        n_levels += 1
    metadata["max_errors"] = struct.unpack_from(f"<{n_levels}d", raw, at)
    at += 8 * n_levels
    metadata["errors_end"] = at
    for name in ("length_unit", "value_unit") if at < len(raw) else ():
        (n,) = struct.unpack_from("<I", raw, at)
        metadata[name] = raw[at + 4 : at + 4 + n].decode()
        at += 4 + n
    expect(at == len(raw), "bytes left over in the metadata")
    return metadata


def lattice_dims(model, dims):
    if model == "diamond3d":
        return dims
    expect(model == "diamond2d", f"unknown model {model}")
    axes = [i for i in range(3) if dims[i] > 1]
    axes += [i for i in range(3) if dims[i] == 1]
    return tuple(dims[i] for i in sorted(axes[:2]))


def morton(position):
    code = 0
    for bit, axis in itertools.product(range(20), range(len(position))):
        code |= (position[axis] >> bit & 1) << (bit * len(position) + axis)
    return code


def split(n_points):
    """Blocks along each axis: lists of (lower, upper)."""
    edge = 64 if len(n_points) == 3 else 512
    axes = []
    for n in n_points:
        n_blocks = max(1, ceil_div(n - 1, edge))
        lowers = [i * edge for i in range(n_blocks)]
        axes.append(list(zip(lowers, lowers[1:] + [n])))
    return axes


def box(ranges):
    """All points, x fastest."""
    for p in itertools.product(*(range(*r) for r in reversed(ranges))):
        yield p[::-1]


def level_blocks(dims, n_levels, level, chunk):
    """Those of one level that lie in a chunk; in all of them where it is None."""
    grid = [2 * ceil_div(n - 1, 2 ** (level + 1)) + 1 for n in dims] if level else dims
    axes = split(grid)
    positions = sorted(box([(0, len(a)) for a in axes]), key=morton)
    if chunk is not None:
        positions = [p for p in positions if tuple(x >> (2 - level) for x in p) == chunk]
    of_level = [(SAMPLES, p) for p in positions]
    if level > 0:
        of_level += [(k, p) for p in positions for k in (ERRORS, MINIMA, MAXIMA, WORLD_ERRORS)]
    for kind, position in of_level:
        points = box([a[i] for a, i in zip(axes, position)])
        if kind != SAMPLES or level < n_levels - 1:
            points = (q for q in points if any(x % 2 for x in q))
        points = list(points)
        if points:
            yield kind, level, position + (0,) * (3 - len(dims)), points


def expected_blocks(dims, n_levels):
    """(kind, level, position, points) of each block, in the order of the file."""
    edge = 256 if len(dims) == 3 else 2048
    chunks = [max(1, ceil_div(n - 1, edge)) for n in dims]
    for chunk in box([(0, n) for n in chunks]):
        for level in reversed(range(min(3, n_levels))):
            yield from level_blocks(dims, n_levels, level, chunk)
    for level in range(3, n_levels):
        yield from level_blocks(dims, n_levels, level, None)


def read_arrays(blocks, dims, metadata):
    """Raw samples by lattice point, and error codes by level and grid point."""
    samples, errors = {}, {}
    letter = STORAGE[metadata["type"]]
    sizes = {SAMPLES: struct.calcsize(letter), ERRORS: 2, WORLD_ERRORS: 1}
    sizes[MINIMA] = sizes[MAXIMA] = struct.calcsize(letter) if letter in "BhH" else 4
    expected = expected_blocks(dims, len(metadata["max_errors"]))
    for (_, block, raw), want in itertools.zip_longest(blocks, expected, fillvalue=(None,) * 4):
        kind, level, position, points = want
        expect(block is not None and kind is not None, f"expected block {want[:3]}, got {block}")
        key = tuple(block[name] for name in ("kind", "level", "x", "y", "z"))
        expect(key == (kind, level) + position, f"expected block {want[:3]}, got {key}")
        size = sizes[kind]
        expect(block["element_size"] == size and len(raw) == size * len(points), f"size of {key}")
        for i, q in enumerate(points):
            value = raw[i * size : (i + 1) * size]
            if kind == SAMPLES:
                samples[tuple(x << level for x in q)] = value
            elif kind == ERRORS:
                errors[level, q] = struct.unpack("<f", b"\0\0" + value)[0]
    return samples, errors


def check_samples(samples, dims, metadata):
    """The data's samples, x fastest; those beyond must equal the nearest."""
    n_beyond = 0
    for p, value in samples.items():
        nearest = tuple(min(x, n - 1) for x, n in zip(p, dims))
        expect(value == samples[nearest], f"expected the nearest sample at {p}")
        n_beyond += p != nearest
    letter = "<" + STORAGE[metadata["type"]]
    points = list(box([(0, n) for n in dims]))
    values = {p: struct.unpack(letter, samples[p])[0] for p in points}
    holes = {p for p, v in values.items() if not math.isfinite(v) or v == metadata["nodata"]}
    present = [v for p, v in values.items() if p not in holes] or [0]
    cells = box([(0, n - 1) for n in dims])
    corners = list(itertools.product((0, 1), repeat=len(dims)))
    n_removed = 0
    for cell in cells if holes else ():
        n_removed += any(tuple(a + b for a, b in zip(cell, c)) in holes for c in corners)
    found = (min(present), max(present), len(holes), n_removed)
    names = ("min", "max", "n_holes", "n_removed_cells")
    said = tuple(metadata[name] for name in names)
    expect(found == said, f"expected {said}, as the metadata says, got {found}")
    return b"".join(samples[p] for p in points), n_beyond


def check_errors(errors, dims, metadata):
    """Level 0 is in no block: its errors follow from the samples."""
    for level, said in list(enumerate(metadata["max_errors"]))[1:]:
        found = max((e for (k, _), e in errors.items() if k == level), default=0)
        expect(found == said, f"largest error of level {level}: expected {said}, got {found}")
    top = len(metadata["max_errors"]) - 1
    base = 0
    if min(dims) > 1:
        base = errors[top, (1,) * len(dims)] if top > 0 else metadata["max_errors"][0]
    expect(base == metadata["base_error"], f"base error: expected {metadata['base_error']}")


def main():
    library = container.load_zstd()
    with open(sys.argv[1], "rb") as file:
        data = file.read()
    header = container.read_header(data)
    model, raw_metadata, entries = container.read_directory(library, data, header)
    metadata = read_metadata(raw_metadata)
    dims = lattice_dims(model, metadata["dims"])
    blocks = container.read_blocks(library, data, header, entries)
    blocks = (b for b in blocks if b[1]["kind"] != INDEX)
    n_errors = 1 + len(metadata["max_errors"])
    end = metadata["errors_end"]
    unknown = struct.pack("<d", math.inf) * n_errors
    early = raw_metadata[: end - 8 * n_errors] + unknown + raw_metadata[end:]
    if any(e["kind"] == INDEX for e in entries):
        for index in container.check_indexes(library, data, entries):
            expect(index == (model, early), "an index of other metadata")
    samples, errors = read_arrays(blocks, dims, metadata)
    dense, n_beyond = check_samples(samples, dims, metadata)
    check_errors(errors, dims, metadata)
    print("model", model)
    print("dims", *metadata["dims"])
    print("holes", metadata["n_holes"], metadata["n_removed_cells"])
    print("beyond", n_beyond)
    print("samples", f"{container.xxh64(dense):016x}")


if __name__ == "__main__":
    try:
        main()
    except (container.BadFile, struct.error, KeyError) as error:
        print(error)
        sys.exit(1)
