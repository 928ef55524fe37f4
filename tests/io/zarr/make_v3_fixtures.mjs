// Writes the Zarr version 3 fixtures of the tests with zarrita, and reads each back with it.
//
// Usage: node make_v3_fixtures.mjs DIR, where zarrita, @zarrita/storage and crc-32 can be found
// (see README.md beside this file). What zarrita cannot write is made of chunks that it wrote: gzip
// and CRC-32C are put round them, shards are put together from them.

import fs from "node:fs";
import path from "node:path";
import zlib from "node:zlib";
import FileSystemStore from "@zarrita/storage/fs";
import CRC32C from "crc-32/crc32c.js";
import * as zarr from "zarrita";

const root = path.resolve(process.argv[2]);
const SMALL = { shape: [3, 7, 10], chunks: [2, 4, 5] };
const LARGE = { shape: [8, 24, 30], chunks: [8, 16, 20] };
const MISSING = 2n ** 64n - 1n;
const bytesCodec = { name: "bytes", configuration: { endian: "little" } };
const zstdCodec = { name: "zstd", configuration: { level: 3, checksum: false } };

const typedArrays = {
  int8: Int8Array, uint8: Uint8Array, int16: Int16Array, uint16: Uint16Array,
  int32: Int32Array, uint32: Uint32Array, int64: BigInt64Array, uint64: BigUint64Array,
  float32: Float32Array, float64: Float64Array,
};

// The formula that zarr_fixtures.h repeats.
function sample(k, type) {
  const step = k % 200;
  if (type.startsWith("float")) return (step - 100) * 0.75;
  const size = typedArrays[type].BYTES_PER_ELEMENT;
  const ones = BigInt("0x" + "01".repeat(size));
  const value = BigInt(type.startsWith("u") ? step : step - 100) * ones;
  return size === 8 ? value : Number(value);
}

function samples(shape, type, order) {
  const inOrder = [5003, 1009, 101, 13, 1].slice(5 - shape.length);
  const weights = order ? order.map((axis) => inOrder[axis]) : inOrder;
  const data = new typedArrays[type](shape.reduce((a, b) => a * b));
  for (let i = 0; i < data.length; ++i) {
    let k = 0;
    for (let axis = shape.length - 1, rest = i; axis >= 0; --axis) {
      k += weights[axis] * (rest % shape[axis]);
      rest = Math.floor(rest / shape[axis]);
    }
    data[i] = sample(k, type);
  }
  return data;
}

function stridesOf(shape) {
  return shape.map((_, axis) => shape.slice(axis + 1).reduce((a, b) => a * b, 1));
}

const opened = (name) => zarr.root(new FileSystemStore(path.join(root, name)));

async function write(name, options = {}) {
  const { shape, chunks } = { ...SMALL, ...options };
  const type = options.type ?? "int16";
  await zarr.create(opened(name), {
    shape, chunkShape: chunks, dtype: type, codecs: options.codecs ?? [bytesCodec],
    chunkSeparator: options.separator, dimensionNames: options.names,
  });
  // Not given to create, which cannot write one of 64 bits.
  editMetadata(name, (metadata) => { metadata.fill_value = 0; });
  const array = await zarr.open(opened(name), { kind: "array" });
  await zarr.set(array, null, { data: samples(shape, type, options.order), shape, stride: stridesOf(shape) });
}

// Reads all of an array with zarrita and compares; `holes` are chunks (as "0/0/1" of `grid`) that
// hold `fill` instead. `order` says which axis of the formula each axis is.
async function check(name, { shape = SMALL.shape, type = "int16", holes = [], grid, fill,
                             order } = {}) {
  const array = await zarr.open(opened(name), { kind: "array" });
  const { data, stride } = await zarr.get(array);
  const expected = samples(shape, type, order);
  const strides = stridesOf(shape);
  for (let i = 0; i < expected.length; ++i) {
    const place = strides.map((step, axis) => Math.floor(i / step) % shape[axis]);
    const isHole = holes.length > 0 &&
      holes.includes(place.map((p, axis) => Math.floor(p / grid[axis])).join("/"));
    const found = data[place.reduce((sum, p, axis) => sum + p * stride[axis], 0)];
    const wanted = isHole ? fill : expected[i];
    if (!Object.is(found, wanted))
      throw new Error(`${name}: expected ${wanted} at ${place}, zarrita reads ${found}`);
  }
}

async function make(name, options = {}) {
  await write(name, options);
  await check(name, options);
}

function editMetadata(name, edit) {
  const file = path.join(root, name, "zarr.json");
  const metadata = JSON.parse(fs.readFileSync(file));
  edit(metadata);
  fs.writeFileSync(file, JSON.stringify(metadata, null, 1));
}

// The chunk files of an array, as { "0/0/1": bytes }.
function chunksOf(name) {
  const folder = path.join(root, name, "c");
  return Object.fromEntries(fs.readdirSync(folder, { recursive: true, withFileTypes: true })
    .filter((entry) => entry.isFile())
    .map((entry) => path.join(entry.parentPath, entry.name))
    .map((file) => [path.relative(folder, file), fs.readFileSync(file)]));
}

function withChecksum(bytes) {
  const sum = Buffer.alloc(4);
  sum.writeInt32LE(CRC32C.buf(bytes, 0));
  return Buffer.concat([bytes, sum]);
}

// Puts codecs that zarrita only reads round the chunks it wrote.
async function wrap(name, options, added, encode) {
  await write(name, options);
  for (const [chunk, bytes] of Object.entries(chunksOf(name)))
    fs.writeFileSync(path.join(root, name, "c", chunk), encode(bytes));
  editMetadata(name, (metadata) => metadata.codecs.push(...added));
  await check(name, options);
}

const splitPlace = (place) => place.split("/").map(Number);

// One shard of `counts` chunks; `chunkAt` gives the bytes at a place or nothing. With `twice` the
// index stands at both ends, so that zarrita, which reads the one at the end, proves both.
function assembleShard(counts, chunkAt, { checksum = true, twice = false } = {}) {
  const n = counts.reduce((a, b) => a * b);
  const index = Buffer.alloc(16 * n);
  const indexBytes = index.length + (checksum ? 4 : 0);
  const parts = [];
  let offset = twice ? indexBytes : 0;
  // Backwards: nothing says that chunks lie in the order of the index.
  for (let i = n - 1; i >= 0; --i) {
    const place = stridesOf(counts).map((step, axis) => Math.floor(i / step) % counts[axis]);
    const bytes = chunkAt(place);
    index.writeBigUInt64LE(bytes ? BigInt(offset) : MISSING, 16 * i);
    index.writeBigUInt64LE(bytes ? BigInt(bytes.length) : MISSING, 16 * i + 8);
    if (!bytes) continue;
    parts.push(bytes);
    offset += bytes.length;
  }
  const stored = checksum ? withChecksum(index) : index;
  return Buffer.concat([...(twice ? [stored] : []), ...parts, stored]);
}

// Replaces the chunk files of an array by shards of `counts` chunks each.
function shard(name, counts, options = {}) {
  const chunks = chunksOf(name);
  const folder = path.join(root, name, "c");
  fs.rmSync(folder, { recursive: true });
  for (const hole of options.holes ?? []) delete chunks[hole];
  const shards = new Set(Object.keys(chunks).map(
    (chunk) => splitPlace(chunk).map((c, axis) => Math.floor(c / counts[axis])).join("/")));
  for (const place of shards) {
    const first = splitPlace(place).map((s, axis) => s * counts[axis]);
    const bytes = assembleShard(
      counts, (at) => chunks[at.map((p, axis) => first[axis] + p).join("/")], options);
    fs.mkdirSync(path.join(folder, path.dirname(place)), { recursive: true });
    fs.writeFileSync(path.join(folder, place), bytes);
  }
  editMetadata(name, (metadata) => {
    const inner = metadata.chunk_grid.configuration.chunk_shape;
    metadata.chunk_grid.configuration.chunk_shape = inner.map((n, axis) => n * counts[axis]);
    const crc = options.checksum === false ? [] : [{ name: "crc32c" }];
    metadata.codecs = [{
      name: "sharding_indexed",
      configuration: {
        chunk_shape: inner, codecs: metadata.codecs, index_codecs: [bytesCodec, ...crc],
        index_location: "end",
      },
    }];
  });
}

async function makeSharded(name, counts, options = {}) {
  await write(name, options);
  shard(name, counts, options);
  await check(name, options);
}

async function writeTypes() {
  for (const type of Object.keys(typedArrays))
    for (const endian of type.endsWith("t8") ? ["little"] : ["little", "big"])
      await make(`type_${type}_${endian}`,
                 { type, codecs: [{ name: "bytes", configuration: { endian } }] });
  editMetadata("type_uint8_little", (metadata) => { metadata.codecs = ["bytes"]; });
}

async function writeCodecs() {
  await make("codec_zstd", { ...LARGE, codecs: [bytesCodec, zstdCodec] });
  for (const shuffle of ["noshuffle", "shuffle", "bitshuffle"])
    for (const cname of ["blosclz", "lz4", "lz4hc", "zlib", "zstd"]) {
      const configuration = { cname, clevel: 5, shuffle: ["noshuffle", "shuffle", "bitshuffle"]
        .indexOf(shuffle), typesize: 2, blocksize: 0 };
      const name = `codec_blosc_${cname}_${shuffle}`;
      await make(name, { ...LARGE, codecs: [bytesCodec, { name: "blosc", configuration }] });
      editMetadata(name, (metadata) => { metadata.codecs[1].configuration.shuffle = shuffle; });
    }
  const gzip = { name: "gzip", configuration: { level: 6 } };
  await wrap("codec_gzip", LARGE, [gzip], (bytes) => zlib.gzipSync(bytes));
  await wrap("codec_crc32c", LARGE, [{ name: "crc32c" }], withChecksum);
  await wrap("codec_gzip_crc32c", LARGE, [gzip, { name: "crc32c" }],
             (bytes) => withChecksum(zlib.gzipSync(bytes)));
  await wrap("codec_crc32c_gzip", LARGE, [{ name: "crc32c" }, gzip],
             (bytes) => zlib.gzipSync(withChecksum(bytes)));
  await wrap("codec_zstd_crc32c", { ...LARGE, codecs: [bytesCodec, zstdCodec] },
             [{ name: "crc32c" }], withChecksum);
}

async function writeShapes() {
  const transpose = (order) => ({ name: "transpose", configuration: { order } });
  for (const order of [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]])
    await make(`transpose_${order.join("")}`, { codecs: [transpose(order), bytesCodec] });
  await make("rank2", { shape: [7, 10], chunks: [4, 5] });
  await make("rank5", { shape: [2, 3, 2, 7, 10], chunks: [1, 2, 2, 4, 5] });
  await make("named", { shape: [3, 2, 2, 7, 10], chunks: [1, 2, 2, 4, 5],
                        names: ["c", "t", "z", "y", "x"] });
  await make("dots", { separator: "." });
  for (const separator of [".", "/"]) {
    const name = `keys_v2_${separator === "." ? "dots" : "slashes"}`;
    await write(name);
    for (const [chunk, bytes] of Object.entries(chunksOf(name))) {
      const file = path.join(root, name, chunk.replaceAll("/", separator));
      fs.mkdirSync(path.dirname(file), { recursive: true });
      fs.writeFileSync(file, bytes);
    }
    fs.rmSync(path.join(root, name, "c"), { recursive: true });
    editMetadata(name, (metadata) => {
      metadata.chunk_key_encoding = { name: "v2", configuration: { separator } };
    });
    await check(name);
  }
}

async function writeFills() {
  const fills = { fill_42: ["int16", 42], fill_nan: ["float32", "NaN"],
                  fill_infinity: ["float64", "-Infinity"] };
  for (const [name, [type, fill]] of Object.entries(fills)) {
    await write(name, { type });
    fs.rmSync(path.join(root, name, "c/0/0/1"));
    editMetadata(name, (metadata) => { metadata.fill_value = fill; });
    await check(name, { type, holes: ["0/0/1"], grid: SMALL.chunks, fill: Number(fill) });
  }
  fs.cpSync(path.join(root, "fill_nan"), path.join(root, "fill_bits"), { recursive: true });
  editMetadata("fill_bits", (metadata) => { metadata.fill_value = "0x447a0000"; });  // 1000
}

async function writeShards() {
  await makeSharded("shard_raw", [2, 1, 2]);
  await makeSharded("shard_zstd", [1, 2, 1], { codecs: [bytesCodec, zstdCodec] });
  await makeSharded("shard_plain_index", [1, 2, 2], { checksum: false });
  await makeSharded("shard_transposed", [2, 2, 2],
                    { codecs: [{ name: "transpose", configuration: { order: [2, 0, 1] } },
                               { name: "bytes", configuration: { endian: "big" } }, zstdCodec] });
  await makeSharded("shard_holes", [2, 2, 1], { holes: ["0/0/1", "1/1/1", "0/1/1", "1/0/1"],
                                                grid: SMALL.chunks, fill: 0 });
  await makeSharded("shard_some_holes", [2, 2, 2], { holes: ["0/0/1"], grid: SMALL.chunks,
                                                     fill: 0 });
  await makeSharded("shard_rank5", [1, 1, 1, 2, 1],
                    { shape: [2, 3, 2, 7, 10], chunks: [1, 2, 2, 4, 5] });
  await makeSharded("shard_index_at_start", [1, 2, 2], { twice: true });
  editMetadata("shard_index_at_start", (metadata) => {
    metadata.codecs[0].configuration.index_location = "start";
  });
  // Shards in shards: the inner ones as zarrita has just read them.
  await makeSharded("shard_nested", [1, 2, 1], { codecs: [bytesCodec, zstdCodec] });
  shard("shard_nested", [2, 1, 2]);
  // Something round a shard: what zarrita has read is given axes in another order, or checksums.
  const order = [2, 0, 1];
  await makeSharded("shard_inside_transpose", [1, 2, 1], { order, shape: [10, 3, 7],
                                                           chunks: [5, 2, 4] });
  editMetadata("shard_inside_transpose", (metadata) => {
    const restored = (counts) => order.map((_, axis) => counts[order.indexOf(axis)]);
    const grid = metadata.chunk_grid.configuration;
    metadata.shape = restored(metadata.shape);
    grid.chunk_shape = restored(grid.chunk_shape);
    metadata.codecs.unshift({ name: "transpose", configuration: { order } });
  });
  const folder = path.join(root, "shard_inside_transpose", "c");
  const shards = chunksOf("shard_inside_transpose");
  fs.rmSync(folder, { recursive: true });
  for (const [place, bytes] of Object.entries(shards)) {
    const file = path.join(folder, order.map(
      (_, axis) => splitPlace(place)[order.indexOf(axis)]).join("/"));
    fs.mkdirSync(path.dirname(file), { recursive: true });
    fs.writeFileSync(file, bytes);
  }
  await makeSharded("shard_inside_crc32c", [1, 2, 1], { codecs: [bytesCodec, zstdCodec] });
  for (const [place, bytes] of Object.entries(chunksOf("shard_inside_crc32c")))
    fs.writeFileSync(path.join(root, "shard_inside_crc32c/c", place), withChecksum(bytes));
  editMetadata("shard_inside_crc32c", (metadata) => metadata.codecs.push("crc32c"));
}

async function writeImages() {
  const axes = [
    { name: "t", type: "time", unit: "second" }, { name: "c", type: "channel" },
    { name: "z", type: "space", unit: "micrometer" },
    { name: "y", type: "space", unit: "micrometer" },
    { name: "x", type: "space", unit: "micrometer" }];
  const datasets = [
    { path: "s0", coordinateTransformations: [
      { type: "scale", scale: [1, 1, 0.5, 0.25, 0.125] },
      { type: "translation", translation: [0, 0, 10, 20, 30] }] },
    { path: "s1", coordinateTransformations: [
      { type: "scale", scale: [1, 1, 0.5, 0.5, 0.25] }] }];
  const multiscales = [{ name: "cells", axes, datasets, coordinateTransformations: [
    { type: "scale", scale: [0.1, 1, 2, 2, 2] }] }];
  await zarr.create(opened("image"), { attributes: { ome: { version: "0.5", multiscales } } });
  await make("image/s0", { shape: [2, 3, 2, 7, 10], chunks: [1, 1, 2, 4, 5],
                           codecs: [bytesCodec, zstdCodec] });
  await make("image/s1", { shape: [2, 3, 2, 3, 5], chunks: [1, 1, 2, 4, 5] });
}

await writeTypes();
await writeCodecs();
await writeShapes();
await writeFills();
await writeShards();
await writeImages();
