#!/usr/bin/env python3
"""Writes the Zarr version 2 fixtures of the tests with zarr-python (Debian: python3-zarr).

Usage: make_v2_fixtures.py DIR. See README.md beside this file.
"""

import itertools
import os
import sys

import numcodecs
import numpy as np
import zarr

SMALL = {"shape": (3, 7, 10), "chunks": (2, 4, 5)}
# Blosc stores fewer than 128 bytes as they are.
LARGE = {"shape": (8, 24, 30), "chunks": (8, 16, 20)}


def samples(shape, dtype):
    """The formula that zarr_fixtures.h repeats."""
    weights = (5003, 1009, 101, 13, 1)[5 - len(shape):]
    k = sum(w * i for w, i in zip(weights, np.indices(shape, dtype=np.int64)))
    dtype = np.dtype(dtype)
    if dtype.kind == "f":
        return ((k % 200 - 100) * 0.75).astype(dtype)
    ones = int("01" * dtype.itemsize, 16)
    if dtype.kind == "u":
        return ((k % 200).astype(np.uint64) * np.uint64(ones)).astype(dtype)
    return ((k % 200 - 100) * np.int64(ones)).astype(dtype)


def write(root, name, dtype="<i2", shape=(3, 7, 10), chunks=(2, 4, 5), missing=(), **options):
    options.setdefault("compressor", numcodecs.Zlib(6))
    array = zarr.open_array(f"{root}/{name}", mode="w", shape=shape, chunks=chunks, dtype=dtype,
                            **options)
    array[...] = samples(shape, dtype)
    for chunk in missing:
        os.remove(f"{root}/{name}/{chunk}")
    return array


def write_types(root):
    for kind, size in itertools.product("iu", (1, 2, 4, 8)):
        for order, name in ("|", "native") if size == 1 else ("<", "little"), (">", "big"):
            if size > 1 or order == "|":
                write(root, f"type_{kind}{size}_{name}", f"{order}{kind}{size}")
    for size, (order, name) in itertools.product((4, 8), (("<", "little"), (">", "big"))):
        write(root, f"type_f{size}_{name}", f"{order}f{size}")


def write_compressors(root):
    for name, compressor in (("raw", None), ("gzip", numcodecs.GZip(6)),
                             ("zlib", numcodecs.Zlib(6)), ("zstd", numcodecs.Zstd(3))):
        write(root, f"codec_{name}", **LARGE, compressor=compressor)
    shuffles = (("none", 0), ("bytes", 1), ("bits", 2))
    for codec, (name, shuffle) in itertools.product(
            ("blosclz", "lz4", "lz4hc", "snappy", "zlib", "zstd"), shuffles):
        write(root, f"codec_blosc_{codec}_{name}", **LARGE,
              compressor=numcodecs.Blosc(codec, 5, shuffle))


def write_shapes(root):
    shapes = {2: ((7, 10), (4, 5)), 3: ((3, 7, 10), (2, 4, 5)),
              4: ((3, 2, 7, 10), (2, 2, 4, 5)), 5: ((2, 3, 2, 7, 10), (1, 2, 2, 4, 5))}
    for rank, (shape, chunks) in shapes.items():
        for order in "CF":
            write(root, f"rank{rank}_{order}", shape=shape, chunks=chunks, order=order)
    write(root, "slashes", dimension_separator="/", order="F", compressor=None)
    write(root, "one_chunk", chunks=(8, 8, 16))
    write(root, "thin", shape=(1, 1, 3, 7, 10), chunks=(1, 1, 2, 4, 5))


def write_fills(root):
    write(root, "fill_42", fill_value=42, missing=("0.0.1", "1.1.1"))
    write(root, "fill_null", fill_value=None, missing=("0.0.1",))
    write(root, "fill_largest", "<u8", fill_value=2**64 - 1, missing=("0.0.1",))
    write(root, "fill_nan", "<f4", fill_value=np.nan, missing=("0.0.1",))
    write(root, "fill_infinity", ">f8", fill_value=-np.inf, missing=("0.0.1",))


def write_groups(root):
    group = zarr.open_group(f"{root}/group_two", mode="w")
    write(root, "group_two/heat", "<f4")
    write(root, "group_two/speed", "|u1")
    zarr.open_group(f"{root}/group_one", mode="w")
    write(root, "group_one/density", "<u2")
    group = zarr.open_group(f"{root}/group_of_groups", mode="w")
    group.create_group("inner")
    zarr.open_group(f"{root}/group_empty", mode="w")


def multiscale(name, path, scale, translation):
    axes = [{"name": name, "type": "space", "unit": "nanometer"} for name in "zyx"]
    transformations = [{"type": "scale", "scale": scale},
                       {"type": "translation", "translation": translation}]
    datasets = [{"path": path, "coordinateTransformations": transformations},
                {"path": "1", "coordinateTransformations": transformations[:1]}]
    return {"version": "0.4", "name": name, "axes": axes, "datasets": datasets}


def write_images(root):
    fine = multiscale("fine", "0", [4, 0.5, 0.25], [1, -2, 3])
    rough = multiscale("rough", "other/0", [8, 8, 8], [0, 0, 0])
    for name, multiscales in ("image", [fine]), ("images", [fine, rough]):
        group = zarr.open_group(f"{root}/{name}", mode="w")
        group.attrs.put({"multiscales": multiscales})
        write(root, f"{name}/0", dimension_separator="/")
        write(root, f"{name}/1", shape=(3, 3, 5), dimension_separator="/")
    write(root, "images/other/0", "<f4", dimension_separator="/")


def main():
    root = sys.argv[1]
    write_types(root)
    write_compressors(root)
    write_shapes(root)
    write_fills(root)
    write_groups(root)
    write_images(root)


main()
