// Whole .lode files of tetrahedra and of terrain: opened, described, a coarse and the finest mesh
// taken from them and parts of it, values probed, and all of it verified; what is accepted must not
// contradict itself, and whatever is refused names the file.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "lode/api/built_terrain.h"
#include "lode/api/terrain.h"
#include "lode/api/terrain_focus.h"
#include "lode/api/terrain_tin.h"
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

/// What parts of a mesh are asked for, with all further fields.
void ask_parts(const TetraDataset& dataset, const TetraFieldUse& fields, Progress& progress) {
  const TetraInfo& info = dataset.describe();
  const Vec3d middle = (info.bounds.lower + info.bounds.upper) * 0.5;
  Surface surface;
  TetraMeshOptions boundary{.query = {.max_error = 0.0}, .threads = kOne, .fields = fields};
  if (!info.patches.empty()) boundary.patches = {std::to_string(info.patches.back().id)};
  (void)dataset.extract_boundary(boundary, surface, progress);
  std::vector<std::int64_t> regions;
  if (!info.regions.empty()) regions.push_back(info.regions.back().id);
  const TetraSectionOptions section{.planes = {{.point = middle, .normal = {{1, 2, 3}}}},
                                    .max_error = 0.0,
                                    .regions = regions,
                                    .fields = fields};
  (void)dataset.extract_section(section, surface, progress);
  std::vector<ProbedLinePoint> along_line;
  (void)dataset.probe_line({.begin = info.bounds.lower, .end = info.bounds.upper},
                           {.along = fields.along, .threads = kOne}, along_line, progress);
  (void)dataset.integrate({.box = Box3d{info.bounds.lower, middle},
                           .regions = regions,
                           .along = fields.along,
                           .threads = kOne},
                          progress);
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
  SimplexMesh in_space;
  TetraMeshOptions by_space{.query = {.max_world_error = 0.1}, .threads = kOne};
  by_space.fields.measured = info.fields.size() - 1;
  if (dataset.extract_mesh(by_space, in_space, progress)) check_mesh(in_space);
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
  TetraFieldUse fields;
  for (std::size_t f = 1; f < info.fields.size(); ++f) fields.along.push_back(f);
  ask_parts(dataset, fields, progress);
  (void)dataset.verify({.n_random_cuts = 2, .threads = kOne}, progress);
}

/// Heights and contours from the whole TIN, and from what of it is read for them.
void ask_places(const Terrain& terrain, const TerrainOptions& options, Progress& progress) {
  const HeightFrame& frame = terrain.frame();
  const auto middle = frame.world(0.5 * (frame.n_columns - 1), 0.5 * (frame.n_rows - 1));
  const auto corner = frame.world(0, 0);
  for (const double x : {middle[0], middle[1], corner[0], corner[1]})
    if (!std::isfinite(x)) return;
  for (const TinUse use : {TinUse::all, TinUse::places, TinUse::lines}) {
    const auto tin = TerrainTin::select(terrain, options, {}, progress, use);
    if (!tin) continue;
    if (use != TinUse::places) (void)tin->contours(std::array{terrain.range().lower}, progress);
    if (use == TinUse::lines) continue;
    std::vector<TerrainHeight> heights;
    (void)tin->heights(std::array{middle, corner}, heights, kOne, progress);
    (void)tin->profile(middle, corner, progress);
  }
}

/// Within a box in the middle, and elsewhere anything.
void ask_focus(const Terrain& terrain, TerrainOptions options, Progress& progress) {
  const HeightFrame& frame = terrain.frame();
  const auto a = frame.world(0.4 * frame.n_columns, 0.4 * frame.n_rows);
  const auto b = frame.world(0.6 * frame.n_columns, 0.6 * frame.n_rows);
  TerrainFocus focus;
  focus.boxes.push_back({{{std::min(a[0], b[0]), std::min(a[1], b[1])}},
                         {{std::max(a[0], b[0]), std::max(a[1], b[1])}}});
  options.focus = focus;
  (void)extract_terrain(terrain, options, progress);
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
    ask_places(terrain, options, progress);
    ask_focus(terrain, options, progress);
  }
  (void)built->verify_alone(kOne, progress);
}

}  // namespace lode::fuzz
