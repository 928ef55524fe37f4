// Times @mapbox/martini, an npm package, on a square of heights; bench/peers/martini.cpp runs it.
//   node martini.mjs PACKAGE HEIGHTS SIZE RUNS TOLERANCE...
// HEIGHTS: SIZE^2 float32, SIZE = 2^n + 1. Prints "errors MS" and for each tolerance "mesh MS
// TRIANGLES", medians of RUNS after as many to warm up, and writes to HEIGHTS.K the K-th mesh:
// uint32 counts of vertices and triangles, then uint32 x, y and uint32 corners.
import { readFileSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { resolve } from 'node:path';

const [folder, path, size, runs, ...tolerances] = process.argv.slice(2);
const Martini = createRequire(import.meta.url)(resolve(folder));

function medianMilliseconds(work) {
  const times = [];
  for (let i = 0; i < 2 * runs; ++i) {
    const start = performance.now();
    work();
    if (i >= runs) times.push(performance.now() - start);
  }
  times.sort((a, b) => a - b);
  return times[times.length >> 1];
}

const bytes = readFileSync(path);
const heights = new Float32Array(bytes.buffer, bytes.byteOffset, size * size);
const martini = new Martini(Number(size));
let tile;
console.log('errors', medianMilliseconds(() => { tile = martini.createTile(heights); }));
tolerances.forEach((tolerance, k) => {
  let mesh;
  const ms = medianMilliseconds(() => { mesh = tile.getMesh(Number(tolerance)); });
  console.log('mesh', ms, mesh.triangles.length / 3);
  const counts = [mesh.vertices.length / 2, mesh.triangles.length / 3];
  writeFileSync(`${path}.${k}`,
    new Uint8Array(Uint32Array.of(...counts).buffer));
  writeFileSync(`${path}.${k}`, new Uint8Array(Uint32Array.from(mesh.vertices).buffer),
    { flag: 'a' });
  writeFileSync(`${path}.${k}`, new Uint8Array(Uint32Array.from(mesh.triangles).buffer),
    { flag: 'a' });
});
