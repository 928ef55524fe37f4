#include "bench/layout/lode_reads.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "bench/timing.h"
#include "lode/api/focused_surface.h"
#include "lode/api/mesh_extraction.h"
#include "lode/models/diamond/file_extract.h"

namespace lode::bench {
namespace {

/// What refining a query's surface from the base reads.
Result<Touched> read_for(const std::string& path, const Query& query) {
  LODE_TRY(const Dataset dataset, Dataset::open(path, {2}));
  Surface surface;
  SurfaceCollector sink(surface);
  Progress progress;
  LODE_CHECK(extract_focused(dataset, {.query = query, .normals = Normals::off, .threads = {2}},
                             surface, progress));
  return Touched{dataset.reads().blocks, dataset.reads().bytes};
}

Query overview(double isovalue, std::uint64_t n_cells) {
  Query query;
  query.isovalues = {isovalue};
  query.max_error = 0;
  query.budget.max_cells = n_cells;
  return query;
}

}  // namespace

Result<Touched> read_for_surface(const std::string& path, double isovalue, double tolerance) {
  LODE_TRY(const auto reader, store::Reader::open(path));
  LODE_TRY(const auto metadata, diamond::read_metadata(reader));
  LODE_TRY(const auto coarse, diamond::load_coarse<3>(reader, metadata, {2}));
  store::BlockCache blocks(reader, std::numeric_limits<std::uint64_t>::max());
  Surface surface;
  SurfaceCollector sink(surface);
  Progress progress;
  const diamond::IsosurfaceQuery query{
      .isovalue = isovalue, .tolerance = tolerance, .threads = {2}};
  LODE_CHECK(diamond::extract_from_file<3>(
      coarse, blocks, diamond::IsovalueList::of({{query.isovalue}}), query,
      [&](std::size_t) { return &sink; }, progress));
  return Touched{reader.reads().n_blocks, reader.reads().n_bytes};
}

Result<Touched> read_for_box(const std::string& path, double isovalue, double tolerance,
                             const Box3d& box) {
  Query query;
  query.isovalues = {isovalue};
  query.max_error = tolerance;
  query.boxes = {box};
  return read_for(path, query);
}

Result<Touched> read_for_overview(const std::string& path, double isovalue, std::uint64_t n_cells) {
  return read_for(path, overview(isovalue, n_cells));
}

Result<SampleSet> corners_of_overview(const std::string& path, double isovalue,
                                      std::uint64_t n_cells) {
  LODE_TRY(const Dataset dataset, Dataset::open(path, {2}));
  SimplexMesh mesh;
  Progress progress;
  LODE_CHECK(dataset.extract_mesh({.query = overview(isovalue, n_cells)}, mesh, progress));
  const RegularGrid grid = dataset.describe().volume.grid;
  SampleSet samples(grid.dims);
  for (const auto& cell : mesh.tetrahedra) {
    const auto is_inside = [&](std::uint32_t v) { return mesh.values[v] >= isovalue; };
    const auto n_inside = std::ranges::count_if(cell, is_inside);
    if (n_inside == 0 || n_inside == 4) continue;
    for (const std::uint32_t v : cell) {
      const Vec3d index = grid.to_index(mesh.positions[v]);
      Index3 p;
      for (std::size_t i = 0; i < 3; ++i)
        p[i] = std::clamp(static_cast<std::int32_t>(std::lround(index[i])), 0, grid.dims[i] - 1);
      samples.add(p);
    }
  }
  return samples;
}

Result<SampleSet> corners_of_cut(const std::string& path, double isovalue, double tolerance) {
  LODE_TRY(const auto reader, store::Reader::open(path));
  Progress progress;
  LODE_TRY(const auto model, diamond::load<3>(reader, {2}, progress));
  SampleSet samples(model.info.grid.dims);
  const diamond::IsosurfaceQuery query{
      .isovalue = isovalue, .tolerance = tolerance, .threads = {2}};
  for (const auto& simplex : diamond::active_simplices<3>(model, query))
    for (const auto& p : simplex.vertex) samples.add(model.clamped(p));
  return samples;
}

Result<FileFacts> write_file(const Dataset& dataset, const std::string& path) {
  Progress progress;
  FileFacts facts;
  for (int run = 0; run < 3; ++run) {
    double start = processor_seconds();
    LODE_CHECK(dataset.save(path, {1}, progress));
    const double write_seconds = processor_seconds() - start;
    LODE_TRY(const auto reader, store::Reader::open(path));
    double n_raw = 0;
    start = processor_seconds();
    for (std::size_t i = 0; i < reader.blocks().size(); ++i) {
      LODE_TRY(const auto raw, reader.read_block(i));
      n_raw += static_cast<double>(raw.size());
    }
    facts.read_rate = std::max(facts.read_rate, n_raw / (processor_seconds() - start));
    facts.write_rate = std::max(facts.write_rate, n_raw / write_seconds);
    facts.n_blocks = reader.blocks().size();
    facts.data_bytes = facts.attribute_bytes = 0;
    for (const store::BlockEntry& block : reader.blocks()) {
      if (store::is_index(block.key)) continue;
      const bool is_data = block.key.kind == static_cast<std::uint32_t>(diamond::Kind::samples);
      (is_data ? facts.data_bytes : facts.attribute_bytes) += block.stored_size;
    }
    facts.other_bytes = reader.file_size() - facts.data_bytes - facts.attribute_bytes;
  }
  return facts;
}

}  // namespace lode::bench
