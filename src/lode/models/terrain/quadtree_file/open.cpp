#include <array>
#include <cstddef>
#include <utility>

#include "lode/models/terrain/quadtree_file/file_layout.h"
#include "lode/models/terrain/quadtree_file/quadtree_file.h"
#include "lode/models/terrain/terrain_file/stored_raster.h"
#include "lode/store/reader.h"

namespace lode::quadtree_file {
namespace {

using terrain_file::naming;
using terrain_file::read_column;

Result<SurfaceQuadtree> read_surface(const store::Reader& reader, SquareDomain domain) {
  std::vector<std::vector<float>> errors;
  for (std::int32_t level = 0; level < domain.n_levels(); ++level) {
    LODE_TRY(auto of_level,
             read_column<float>(reader, key_of(Column::error, level), domain.n_squares(level)));
    errors.push_back(std::move(of_level));
  }
  return naming(reader.path(), SurfaceQuadtree::of(std::move(domain), std::move(errors)));
}

Result<QuaternaryTriangulation> read_quaternary(const store::Reader& reader, SquareDomain domain) {
  std::vector<std::vector<std::array<float, 2>>> errors;
  for (std::int32_t level = 0; level < domain.n_levels(); ++level) {
    LODE_TRY(const auto numbers,
             read_column<float>(reader, key_of(Column::error, level), 2 * domain.n_squares(level)));
    auto& of_level = errors.emplace_back(domain.n_squares(level));
    for (std::size_t i = 0; i < numbers.size(); ++i) of_level[i / 2][i % 2] = numbers[i];
  }
  return naming(reader.path(), QuaternaryTriangulation::of(std::move(domain), std::move(errors)));
}

}  // namespace

Result<QuadtreeModel> open(const std::string& path, Progress& progress) {
  LODE_TRY(const store::Reader reader, store::Reader::open(path));
  LODE_TRY(const std::size_t kind, terrain_file::find_model(reader, kModelNames));
  LODE_TRY(terrain_file::StoredRaster raster, terrain_file::read_raster(reader, kLayout));
  if (progress.is_cancelled()) return cancelled_error();
  LODE_TRY(SquareDomain domain, naming(path, SquareDomain::make(raster.grid)));
  LODE_CHECK(terrain_file::check_kept(path, raster.kept,
                                      [&](LatticePoint p) { return domain.has_node(p); }));
  domain.keep(std::move(raster.kept));
  const auto make = [&](auto tree) {
    return QuadtreeModel{std::move(raster.source), std::move(raster.levels), std::move(raster.grid),
                         std::move(tree)};
  };
  if (kind == 0) {
    LODE_TRY(SurfaceQuadtree tree, read_surface(reader, std::move(domain)));
    return make(std::move(tree));
  }
  if (kind == 1) {
    LODE_TRY(QuaternaryTriangulation tree, read_quaternary(reader, std::move(domain)));
    return make(std::move(tree));
  }
  return make(std::move(domain));
}

}  // namespace lode::quadtree_file
