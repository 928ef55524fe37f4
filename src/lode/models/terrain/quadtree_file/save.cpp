#include "lode/models/terrain/quadtree_file/file_layout.h"
#include "lode/models/terrain/quadtree_file/quadtree_file.h"
#include "lode/models/terrain/terrain_file/stored_raster.h"
#include "lode/store/writer.h"

namespace lode::quadtree_file {
namespace {

using terrain_file::append_column;

Result<void> append_errors(const SurfaceQuadtree& tree, store::Writer& writer) {
  for (std::int32_t level = 0; level < tree.domain().n_levels(); ++level) {
    const auto& errors = tree.errors()[static_cast<std::size_t>(level)];
    LODE_CHECK(append_column<float>(
        key_of(Column::error, level), errors.size(), [&](std::uint64_t i) { return errors[i]; },
        writer));
  }
  return {};
}

Result<void> append_errors(const QuaternaryTriangulation& tree, store::Writer& writer) {
  for (std::int32_t level = 0; level < tree.domain().n_levels(); ++level) {
    const auto& errors = tree.errors()[static_cast<std::size_t>(level)];
    LODE_CHECK(append_column<float>(
        key_of(Column::error, level), 2 * errors.size(),
        [&](std::uint64_t i) { return errors[i / 2][i % 2]; }, writer));
  }
  return {};
}

Result<void> append_errors(const SquareDomain& /*domain*/, store::Writer& /*writer*/) { return {}; }

}  // namespace

const SquareDomain& domain_of(const QuadtreeModel& model) {
  if (const auto* surface = std::get_if<SurfaceQuadtree>(&model.tree)) return surface->domain();
  if (const auto* right = std::get_if<QuaternaryTriangulation>(&model.tree)) return right->domain();
  return std::get<SquareDomain>(model.tree);
}

std::string_view model_name(const QuadtreeModel& model) { return kModelNames[model.tree.index()]; }

Result<std::uint64_t> save(const QuadtreeModel& model, const std::string& path,
                           Progress& progress) {
  const std::vector<LatticePoint>& kept = domain_of(model).kept();
  LODE_TRY(auto writer, store::Writer::create(
                            path, model_name(model),
                            terrain_file::encode_raster_head(kLayout, model.source, model.levels,
                                                             model.grid, kept.size())));
  LODE_CHECK(terrain_file::append_raster(model.grid, kept, writer));
  if (progress.is_cancelled()) return cancelled_error();
  LODE_CHECK(std::visit([&](const auto& tree) { return append_errors(tree, writer); }, model.tree));
  return writer.finish(progress);
}

}  // namespace lode::quadtree_file
