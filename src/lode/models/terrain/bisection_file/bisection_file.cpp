#include "lode/models/terrain/bisection_file/bisection_file.h"

#include <array>
#include <string_view>
#include <utility>

#include "lode/models/terrain/terrain_file/stored_raster.h"

namespace lode::bisection_file {
namespace {

constexpr std::array<std::string_view, 1> kModelNames{"right_triangle_bisection"};
constexpr std::uint32_t kLayout = 1;

}  // namespace

Result<std::uint64_t> save(const BisectionModel& model, const std::string& path,
                           Progress& progress) {
  const std::vector<LatticePoint>& kept = model.tree.kept();
  LODE_TRY(auto writer, store::Writer::create(
                            path, kModelNames[0],
                            terrain_file::encode_raster_head(kLayout, model.source, model.levels,
                                                             model.grid, kept.size())));
  LODE_CHECK(terrain_file::append_raster(model.grid, kept, writer));
  if (progress.is_cancelled()) return cancelled_error();
  return writer.finish(progress);
}

Result<BisectionModel> open(const std::string& path, Threads threads, Progress& progress) {
  LODE_TRY(const store::Reader reader, store::Reader::open(path));
  LODE_CHECK(terrain_file::find_model(reader, kModelNames));
  LODE_TRY(terrain_file::StoredRaster raster, terrain_file::read_raster(reader, kLayout));
  auto built = bisection::Bisection::build(raster.grid, threads, progress);
  if (progress.is_cancelled()) return cancelled_error();
  LODE_TRY(bisection::Bisection tree, terrain_file::naming(path, std::move(built)));
  LODE_CHECK(terrain_file::check_kept(path, raster.kept,
                                      [&](LatticePoint p) { return tree.has_node(p); }));
  tree.keep(std::move(raster.kept));
  return BisectionModel{std::move(raster.source), std::move(raster.levels), std::move(raster.grid),
                        std::move(tree)};
}

}  // namespace lode::bisection_file
