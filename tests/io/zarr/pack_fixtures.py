#!/usr/bin/env python3
"""Packs a directory into a .tar.gz whose bytes depend on names and contents alone.

Usage: pack_fixtures.py DIR OUT.tar.gz
"""

import gzip
import sys
import tarfile
from pathlib import Path


def main():
    root, out = Path(sys.argv[1]), sys.argv[2]
    with open(out, "wb") as raw, gzip.GzipFile("", "wb", 9, raw, mtime=0) as packed, \
            tarfile.open(fileobj=packed, mode="w", format=tarfile.USTAR_FORMAT) as tar:
        for path in sorted(root.rglob("*")):
            info = tarfile.TarInfo(path.relative_to(root).as_posix())
            if path.is_dir():
                info.type, info.mode = tarfile.DIRTYPE, 0o755
                tar.addfile(info)
            else:
                info.size, info.mode = path.stat().st_size, 0o644
                with open(path, "rb") as file:
                    tar.addfile(info, file)


main()
