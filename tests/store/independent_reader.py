"""Lists and decodes the blocks of a .lode file: written from docs/format.md alone.

Shares no code with Lode; needs only the standard library and libzstd. Prints the model, the
length of its metadata, and for each block

    kind level x y z offset stored_size raw_size codec element_size xxh64_of_the_raw_bytes

Exit status: 0, 1 for a bad file, 2 where libzstd (package libzstd1) is absent.
"""

import ctypes
import ctypes.util
import struct
import sys

MAGIC = b"\x8bLOD\r\n\x1a\n"
HEADER_BYTES = 128
INDEX_MARK = bytes.fromhex("8B 4C 4F 44 49 4E 44 45 58 D3 7E 51 A9 1C F6 08")
MASK = (1 << 64) - 1
PRIMES = (
    11400714785074694791,
    14029467366897019727,
    1609587929392839161,
    9650029242287828579,
    2870177450012600261,
)


class BadFile(Exception):
    """The file breaks a rule of the format."""


def expect(condition, message):
    if not condition:
        raise BadFile(message)


def rotate(value, bits):
    return ((value << bits) | (value >> (64 - bits))) & MASK


def xxh64_round(accumulator, lane):
    return rotate((accumulator + lane * PRIMES[1]) & MASK, 31) * PRIMES[0] & MASK


def xxh64(data):
    """XXH64 with seed 0, after its published specification."""
    at = 0
    if len(data) >= 32:
        lanes = [(PRIMES[0] + PRIMES[1]) & MASK, PRIMES[1], 0, (0 - PRIMES[0]) & MASK]
        while at + 32 <= len(data):
            for i, lane in enumerate(struct.unpack_from("<4Q", data, at)):
                lanes[i] = xxh64_round(lanes[i], lane)
            at += 32
        hashed = sum(rotate(lane, bits) for lane, bits in zip(lanes, (1, 7, 12, 18))) & MASK
        for lane in lanes:
            hashed = ((hashed ^ xxh64_round(0, lane)) * PRIMES[0] + PRIMES[3]) & MASK
    else:
        hashed = PRIMES[4]
    hashed = (hashed + len(data)) & MASK
    while at + 8 <= len(data):
        hashed ^= xxh64_round(0, struct.unpack_from("<Q", data, at)[0])
        hashed = (rotate(hashed, 27) * PRIMES[0] + PRIMES[3]) & MASK
        at += 8
    if at + 4 <= len(data):
        hashed ^= struct.unpack_from("<I", data, at)[0] * PRIMES[0] & MASK
        hashed = (rotate(hashed, 23) * PRIMES[1] + PRIMES[2]) & MASK
        at += 4
    for byte in data[at:]:
        hashed ^= byte * PRIMES[4] & MASK
        hashed = rotate(hashed, 11) * PRIMES[0] & MASK
    hashed = (hashed ^ (hashed >> 33)) * PRIMES[1] & MASK
    hashed = (hashed ^ (hashed >> 29)) * PRIMES[2] & MASK
    return hashed ^ (hashed >> 32)


def load_zstd():
    name = ctypes.util.find_library("zstd") or "libzstd.so.1"
    try:
        library = ctypes.CDLL(name)
    except OSError:
        print("expected libzstd (package libzstd1), which ./dev test installs; found none")
        sys.exit(2)
    library.ZSTD_decompress.restype = ctypes.c_size_t
    library.ZSTD_decompress.argtypes = [
        ctypes.c_char_p,
        ctypes.c_size_t,
        ctypes.c_char_p,
        ctypes.c_size_t,
    ]
    return library


def unzstd(library, stored, raw_size):
    out = ctypes.create_string_buffer(max(raw_size, 1))
    size = library.ZSTD_decompress(out, raw_size, stored, len(stored))
    expect(size == raw_size, f"expected a zstd frame of {raw_size} bytes")
    return out.raw[:raw_size]


def unshuffle(planes, size):
    n = len(planes) // size
    elements = bytearray(planes)
    for b in range(size):
        elements[b : n * size : size] = planes[b * n : (b + 1) * n]
    return bytes(elements)


def undelta(codes, size):
    n = len(codes) // size
    out = bytearray(codes)
    value = 0
    for i in range(n):
        code = int.from_bytes(codes[i * size : (i + 1) * size], "little")
        value += code >> 1 if code % 2 == 0 else -((code + 1) >> 1)
        out[i * size : (i + 1) * size] = (value % (1 << (8 * size))).to_bytes(size, "little")
    return bytes(out)


def in_plane(a, b, ab):
    return a + b - min(max(ab, min(a, b)), max(a, b))


def zigzag(difference, size):
    """Of a difference modulo 2^(8 size), as a signed number."""
    half = 1 << (8 * size - 1)
    signed = (difference + half) % (2 * half) - half
    return 2 * signed if signed >= 0 else -2 * signed - 1


def unpredict(codes, shape, lacks_even, origin, size):
    """Adds up what is predicted and the differences; points before the grid are 0."""
    modulus = 1 << (8 * size)
    values, out, at = {}, bytearray(), 0
    for z in range(shape[2]):
        for y in range(shape[1]):
            for x in range(shape[0]):
                a, b, c, ab, ac, bc = (
                    values.get((x - i, y - j, z - k), 0)
                    for i, j, k in ((1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 0), (1, 0, 1), (0, 1, 1))
                )
                planes = (in_plane(a, b, ab), in_plane(a, c, ac), in_plane(b, c, bc))
                value = sorted(planes)[1]
                if not lacks_even or (x | y | z) % 2:
                    expect(at < len(codes), "more points than differences")
                    code = int.from_bytes(codes[at : at + size], "little")
                    at += size
                    zero = zigzag(-value, size)
                    if code == 0:
                        value = 0
                    else:
                        code -= code <= zero
                        value += code >> 1 if code % 2 == 0 else -((code + 1) >> 1)
                        value %= modulus
                    out += ((value + origin) % modulus).to_bytes(size, "little")
                values[x, y, z] = value
    expect(at == len(codes), "fewer points than differences")
    return bytes(out)


def decode_predicted(library, stored, size, raw_size):
    flags, *shape = struct.unpack_from("<B3H", stored, 0)
    expect(flags <= 1, "unknown flags of a grid")
    origin = int.from_bytes(stored[7 : 7 + size], "little")
    codes = unshuffle(unzstd(library, stored[7 + size :], raw_size), size)
    return unpredict(codes, shape, flags == 1, origin, size)


def decode_ranked(library, stored, size, raw_size):
    n_values, n_stored = struct.unpack_from("<2I", stored, 0)
    planes = unzstd(library, stored[8 : 8 + n_stored], n_values * size)
    values = undelta(unshuffle(planes, size), size)
    n = raw_size // size
    ranks = decode_predicted(library, stored[8 + n_stored :], 2, 2 * n)
    ranks = struct.unpack(f"<{n}H", ranks)
    expect(all(r < n_values for r in ranks), "a rank without a value")
    return b"".join(values[r * size : (r + 1) * size] for r in ranks)


def decode(library, block, stored):
    if block["codec"] == 0:
        return stored
    if block["codec"] >= 4:
        decode_grid = decode_predicted if block["codec"] == 4 else decode_ranked
        return decode_grid(library, stored, block["element_size"], block["raw_size"])
    raw = unzstd(library, stored, block["raw_size"])
    if block["codec"] >= 2:
        raw = unshuffle(raw, block["element_size"])
    if block["codec"] == 3:
        raw = undelta(raw, block["element_size"])
    return raw


def read_header(data):
    expect(data[:8] == MAGIC, "not a .lode file")
    expect(len(data) >= HEADER_BYTES, "truncated header")
    (stored_sum,) = struct.unpack_from("<Q", data, 120)
    expect(stored_sum == xxh64(data[:120]), "header checksum differs")
    names = ("version", "header_size", "features", "file_size", "directory_offset")
    names += ("directory_stored_size", "directory_raw_size", "directory_checksum")
    header = dict(zip(names, struct.unpack_from("<II6Q", data, 8)))
    expect(header["version"] == 2, "unknown version")
    expect(header["features"] in range(8), "unknown features")
    expect(header["file_size"] == len(data), "wrong file size")
    return header


def read_directory(library, data, header):
    start = header["directory_offset"]
    stored = data[start : start + header["directory_stored_size"]]
    expect(start + len(stored) == len(data), "the directory is not at the end")
    expect(xxh64(stored) == header["directory_checksum"], "directory checksum differs")
    return parse_directory(unzstd(library, stored, header["directory_raw_size"]))


def parse_directory(raw):
    (name_size,) = struct.unpack_from("<I", raw, 0)
    model = raw[4 : 4 + name_size].decode("utf-8")
    at = 4 + name_size
    (metadata_size,) = struct.unpack_from("<Q", raw, at)
    metadata = raw[at + 8 : at + 8 + metadata_size]
    at += 8 + metadata_size
    (n,) = struct.unpack_from("<Q", raw, at)
    at += 8
    columns = {}
    names = ("kind", "level", "x", "y", "z", "stored_size", "raw_size", "codec", "element_size")
    for name, letter in zip(names + ("checksum",), "IIiiiQQBBQ"):
        columns[name] = struct.unpack_from(f"<{n}{letter}", raw, at)
        at += n * struct.calcsize(letter)
    expect(at == len(raw), "wrong directory size")
    blocks = [{name: column[i] for name, column in columns.items()} for i in range(n)]
    return model, metadata, blocks


def read_index(library, raw, at):
    """What an index says: model, early metadata and the entries of blocks that follow it."""
    expect(raw[:16] == INDEX_MARK, f"no mark at offset {at}")
    offset, stored_size, raw_size, frame_sum, head_sum = struct.unpack_from("<5Q", raw, 16)
    expect(head_sum == xxh64(raw[:48]), f"index checksum differs at offset {at}")
    expect(offset == at, f"the index at offset {at} says that it lies at {offset}")
    expect(56 + stored_size == len(raw), f"wrong size of the index at offset {at}")
    expect(frame_sum == xxh64(raw[56:]), f"frame checksum differs at offset {at}")
    return parse_directory(unzstd(library, raw[56:], raw_size))


def check_indexes(library, data, blocks):
    """Each index lists just the blocks from it to the next one; gives what else each says."""
    offset, n_listed, found = HEADER_BYTES, 0, []
    for at, block in enumerate(blocks):
        if block["kind"] == 0:
            expect(n_listed == 0, f"an index too early at offset {offset}")
            raw = data[offset : offset + block["stored_size"]]
            model, metadata, entries = read_index(library, raw, offset)
            n_listed = len(entries)
            expect(blocks[at + 1 : at + 1 + n_listed] == entries, f"wrong index at {offset}")
            number = tuple(block[name] for name in ("level", "x", "y", "z"))
            expect(number == (0, len(found), 0, 0), f"wrong number at {offset}")
            found.append((model, metadata))
        else:
            expect(n_listed > 0, f"a block in no index at offset {offset}")
            n_listed -= 1
        offset += block["stored_size"]
    return found


def read_blocks(library, data, header, blocks):
    """Gives the offset, directory entry and raw bytes of each."""
    offset = HEADER_BYTES
    for block in blocks:
        stored = data[offset : offset + block["stored_size"]]
        expect(xxh64(stored) == block["checksum"], f"block checksum differs at offset {offset}")
        raw = decode(library, block, stored)
        expect(len(raw) == block["raw_size"], f"wrong raw size at offset {offset}")
        yield offset, block, raw
        expect(block["codec"] < 4 or header["features"] & 1, "a codec without its feature bit")
        offset += block["stored_size"]
    expect(offset == header["directory_offset"], "a gap before the directory")


def main():
    library = load_zstd()
    with open(sys.argv[1], "rb") as file:
        data = file.read()
    header = read_header(data)
    model, metadata, blocks = read_directory(library, data, header)
    print("model", model)
    print("metadata", len(metadata))
    for offset, block, raw in read_blocks(library, data, header, blocks):
        names = ("stored_size", "raw_size", "codec", "element_size")
        fields = [block[name] for name in ("kind", "level", "x", "y", "z")]
        fields += [offset] + [block[name] for name in names]
        print(*fields, f"{xxh64(raw):016x}")


if __name__ == "__main__":
    try:
        main()
    except (BadFile, struct.error) as error:
        print(error)
        sys.exit(1)
