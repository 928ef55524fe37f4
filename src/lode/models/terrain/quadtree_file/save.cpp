#include <type_traits>

#include "lode/models/terrain/quadtree_file/file_layout.h"
#include "lode/models/terrain/quadtree_file/quadtree_file.h"
#include "lode/store/bytes.h"
#include "lode/store/writer.h"

namespace lode::quadtree_file {
namespace {

using terrain_file::append_column;

std::vector<std::byte> encode_head(const QuadtreeModel& model) {
  store::ByteWriter out;
  out.write(kLayout);
  terrain_file::write(out, model.source);
  out.write(static_cast<std::uint8_t>(model.grid.heights.index()));
  terrain_file::write_levels(out, model.levels);
  out.write(static_cast<std::uint32_t>(domain_of(model).kept().size()));
  return std::move(out).take();
}

Result<void> append_heights(const HeightGrid& grid, store::Writer& writer) {
  const auto append = [&]<typename T>(const HeightGrid::Samples<T>& samples) {
    const auto n_columns = static_cast<std::uint64_t>(grid.n_columns);
    return append_column<T>(
        key_of(Column::height), static_cast<std::uint64_t>(grid.n_samples()),
        [&](std::uint64_t i) {
          const auto x = static_cast<std::int32_t>(i % n_columns);
          const auto y = static_cast<std::int32_t>(i / n_columns);
          return grid.has_height(x, y) ? samples[static_cast<std::size_t>(y * grid.stride + x)]
                                       : T{};
        },
        writer);
  };
  LODE_CHECK(std::visit(append, grid.heights));
  if (grid.is_valid.empty()) return {};
  return append_column<std::uint8_t>(
      key_of(Column::is_valid), grid.is_valid.size(),
      [&](std::uint64_t i) { return grid.is_valid[i]; }, writer);
}

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

Result<void> append_kept(const SquareDomain& domain, store::Writer& writer) {
  const std::vector<LatticePoint>& kept = domain.kept();
  if (kept.empty()) return {};
  return append_column<std::uint32_t>(
      key_of(Column::kept), 2 * kept.size(),
      [&](std::uint64_t i) {
        const LatticePoint p = kept[i / 2];
        return static_cast<std::uint32_t>(i % 2 == 0 ? p.x : p.y);
      },
      writer);
}

}  // namespace

const SquareDomain& domain_of(const QuadtreeModel& model) {
  if (const auto* surface = std::get_if<SurfaceQuadtree>(&model.tree)) return surface->domain();
  if (const auto* right = std::get_if<QuaternaryTriangulation>(&model.tree)) return right->domain();
  return std::get<SquareDomain>(model.tree);
}

std::string_view model_name(const QuadtreeModel& model) { return kModelNames[model.tree.index()]; }

Result<std::uint64_t> save(const QuadtreeModel& model, const std::string& path,
                           Progress& progress) {
  LODE_TRY(auto writer, store::Writer::create(path, model_name(model), encode_head(model)));
  LODE_CHECK(append_heights(model.grid, writer));
  LODE_CHECK(append_kept(domain_of(model), writer));
  if (progress.is_cancelled()) return cancelled_error();
  LODE_CHECK(std::visit([&](const auto& tree) { return append_errors(tree, writer); }, model.tree));
  return writer.finish(progress);
}

}  // namespace lode::quadtree_file
