// Whole .lode files of tetrahedra and of terrain: opened, described, a coarse and the finest mesh
// taken from them, values probed, and all of it verified; what is accepted must not contradict
// itself, and whatever is refused names the file.
#include <array>
#include <cmath>
#include <vector>

#include "lode/api/built_terrain.h"
#include "lode/api/terrain.h"
#include "lode/api/tetra_dataset.h"
#include "tests/fuzz/fuzz_files.h"

namespace lode::fuzz {
namespace {

constexpr Threads kOne{1};

void check_mesh(const SimplexMesh& mesh) {
  for (const auto& cell : mesh.tetrahedra)
    for (const std::uint32_t corner : cell)
      expect(corner < mesh.positions.size(), "cells have vertices that there are");
}

void ask_tetra(const TetraDataset& dataset) {
  Progress progress;
  const TetraInfo& info = dataset.describe();
  expect(!info.fields.empty(), "a hierarchy has a field");
  const TetraFieldInfo& field = info.fields.front();
  for (const double max_error : {field.base_error / 2, 0.0}) {
    SimplexMesh mesh;
    TetraMeshOptions options{.query = {.max_error = max_error}, .threads = kOne};
    for (std::size_t f = 1; f < info.fields.size(); ++f) options.fields.along.push_back(f);
    if (dataset.extract_mesh(options, mesh, progress)) check_mesh(mesh);
  }
  Surface surface;
  const TetraSurfaceOptions options{
      .query = {.isovalues = {field.range_min / 2 + field.range_max / 2}, .max_error = 0.0},
      .threads = kOne};
  (void)dataset.extract_surface(options, surface, progress);
  const Vec3d middle = (info.bounds.lower + info.bounds.upper) * 0.5;
  std::vector<ProbedPoint> found;
  (void)dataset.probe(std::array{middle, info.bounds.lower}, {.threads = kOne}, found, progress);
  const ProbeOptions last{.field = info.fields.size() - 1, .threads = kOne};
  (void)dataset.probe(std::array{middle}, last, found, progress);
  (void)dataset.verify({.n_random_cuts = 2, .threads = kOne}, progress);
}

}  // namespace

void run_tetra_file(Input input) {
  const std::string path = fuzz_directory().write("t.lode", input);
  const auto dataset = TetraDataset::open(path);
  if (!dataset)
    return expect(dataset.error().message.find(path) != std::string::npos,
                  "an error names the file", dataset.error().message);
  ask_tetra(*dataset);
}

void run_terrain_file(Input input) {
  const std::string path = fuzz_directory().write("d.lode", input);
  Progress progress;
  const auto built = BuiltTerrain::open(path, progress);
  if (!built)
    return expect(built.error().message.find(path) != std::string::npos, "an error names the file",
                  built.error().message);
  (void)built->describe(progress);
  const Terrain terrain = built->terrain();
  const HeightRange range = terrain.range();
  for (const double max_error : {terrain.origin().finest_error(), range.upper - range.lower}) {
    if (!(max_error >= 0 && std::isfinite(max_error))) continue;
    const TerrainOptions options{.max_error = max_error, .threads = kOne};
    const auto made = extract_terrain(terrain, options, progress);
    if (!made) continue;
    for (const auto& triangle : made->surface.triangles)
      for (const std::uint32_t corner : triangle)
        expect(corner < made->surface.positions.size(), "triangles have vertices that there are");
  }
  (void)built->verify_alone(kOne, progress);
}

}  // namespace lode::fuzz
