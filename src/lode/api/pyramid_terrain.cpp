#include "lode/api/pyramid_terrain.h"

#include <algorithm>
#include <array>

#include "lode/api/insertions_selection.h"
#include "lode/api/terrain_focus.h"
#include "lode/core/stopwatch.h"
#include "lode/models/terrain/delaunay_pyramid/link_search.h"

namespace lode {

using delaunay_pyramid::Encoding;
using delaunay_pyramid::LinkStart;
using delaunay_pyramid::Pyramid;
using delaunay_pyramid::PyramidBytes;
using delaunay_pyramid::PyramidFile;

namespace {

/// As the enumerators of Encoding.
constexpr std::array kPyramidModels{TerrainModel::complete_pyramid, TerrainModel::triangle_lists,
                                    TerrainModel::linked_triangle_lists};

Encoding encoding_of(TerrainModel model) {
  const auto* const found = std::ranges::find(kPyramidModels, model);
  return static_cast<Encoding>(found - kPyramidModels.begin());
}

/// What it asks for beside one tolerance; nothing where that is all.
const char* what_varies(const TerrainFocus& focus, double tolerance) {
  if (focus.view) return "a view";
  if (focus.point && focus.growth > 0) return "a tolerance that grows from a point";
  if (focus.max_error_outside && *focus.max_error_outside != tolerance)
    return "another tolerance outside of the focus";
  return nullptr;
}

void add_parts(const PyramidBytes& memory, const PyramidBytes& file, BuiltTerrainInfo& info) {
  info.parts = {{"vertices", memory.vertices, file.vertices},
                {"triangles", memory.triangles, file.triangles},
                {"neighbours", memory.neighbours, file.neighbours},
                {"links", memory.links, file.links}};
  std::erase_if(info.parts, [](const auto& part) { return part.memory_bytes == 0; });
}

/// The mesh of a level, in parts.
class LevelParts final : public TerrainParts {
 public:
  LevelParts(std::shared_ptr<const PyramidFile> file, LinkStart start, std::size_t level,
             const TerrainReport& report)
      : file_(std::move(file)), start_(std::move(start)), level_(level), report_(report) {}

  [[nodiscard]] const TerrainReport& report() const override { return report_; }
  [[nodiscard]] LatticePoint lower() const override { return start_.box().lower; }
  [[nodiscard]] LatticePoint upper() const override { return start_.box().upper; }
  [[nodiscard]] Result<delaunay::Tin> around(std::span<const delaunay::Point> places,
                                             Progress& progress) const override {
    return tin_around(*file_, start_, level_, places, progress);
  }
  [[nodiscard]] Result<delaunay::Tin> along(const delaunay::Point& a, const delaunay::Point& b,
                                            Progress& progress) const override {
    return tin_along(*file_, start_, level_, a, b, progress);
  }

 private:
  std::shared_ptr<const PyramidFile> file_;
  LinkStart start_;
  std::size_t level_;
  TerrainReport report_;
};

}  // namespace

PyramidTerrain::PyramidTerrain(Pyramid pyramid)
    : head_(pyramid.head), loaded_(std::make_shared<const Pyramid>(std::move(pyramid))) {}

PyramidTerrain::PyramidTerrain(PyramidFile file)
    : head_(file.head()), file_(std::make_shared<const PyramidFile>(std::move(file))) {}

Result<std::shared_ptr<const PyramidTerrain>> PyramidTerrain::build(
    const insertions::History& history, const TerrainBuildOptions& options,
    const std::vector<double>& levels, Progress& progress) {
  LODE_TRY(Pyramid pyramid, encode(history, levels, encoding_of(options.model),
                                   {.n_bytes = options.memory_limit}, progress));
  return std::make_shared<const PyramidTerrain>(std::move(pyramid));
}

Result<std::shared_ptr<const PyramidTerrain>> PyramidTerrain::open(const std::string& path) {
  LODE_TRY(PyramidFile file, PyramidFile::open(path));
  return std::make_shared<const PyramidTerrain>(std::move(file));
}

TerrainModel PyramidTerrain::model() const {
  return kPyramidModels[static_cast<std::size_t>(head_.encoding)];
}

Result<PyramidTerrain::Shared> PyramidTerrain::with_mesh(std::size_t level,
                                                         Progress& progress) const {
  const std::lock_guard lock(mutex_);
  if (loaded_ && (!loaded_level_ || loaded_level_ == level)) return loaded_;
  LODE_TRY(Pyramid read, file_->read_mesh(level, progress));
  loaded_ = std::make_shared<const Pyramid>(std::move(read));
  loaded_level_ = level;
  return loaded_;
}

Result<PyramidTerrain::Shared> PyramidTerrain::all(Progress& progress) const {
  const std::lock_guard lock(mutex_);
  if (loaded_ && !loaded_level_) return loaded_;
  LODE_TRY(Pyramid read, file_->read_all(progress));
  loaded_ = std::make_shared<const Pyramid>(std::move(read));
  loaded_level_ = {};
  return loaded_;
}

std::size_t PyramidTerrain::level_within(double tolerance) const {
  std::size_t level = 0;
  while (level + 1 < head_.n_levels() && head_.tolerances[level] > tolerance) ++level;
  return level;
}

std::size_t PyramidTerrain::level_for(const TerrainOptions& options, double tolerance,
                                      TerrainReport& report) const {
  std::size_t level = level_within(tolerance);
  if (options.max_cells) {
    while (level > 0 && head_.n_in_mesh[level] > *options.max_cells) --level;
    report.budget_met = head_.n_in_mesh[level] <= *options.max_cells;
  }
  const bool is_last = level + 1 == head_.n_levels();
  report.is_within_error = (is_last ? head_.max_error : head_.tolerances[level]) <= tolerance;
  return level;
}

Result<void> PyramidTerrain::check_focus(const TerrainFocus& focus, double tolerance) const {
  const char* const asked = what_varies(focus, tolerance);
  if (asked == nullptr) return {};
  return fail(
      "expected one tolerance for all of a {}, which has meshes of whole levels, that do not meet "
      "where two of them are side by side, got {}: the delaunay_pyramid has all insertions, so its "
      "tolerance may vary",
      name_of(model()), asked);
}

Result<SelectedTerrain> PyramidTerrain::select(const TerrainOptions& options, delaunay::TinLinks,
                                               Progress& progress) const {
  const Stopwatch watch;
  if (progress.is_cancelled()) return cancelled_error();
  LODE_TRY(const double tolerance, insertions_tolerance(options, source().range, finest_error()));
  SelectedTerrain selected;
  std::optional<TerrainDemand> focus;
  if (options.focus) {
    LODE_CHECK(check_focus(*options.focus, tolerance));
    LODE_TRY(focus, TerrainDemand::make(*options.focus, tolerance, source().frame, source().range));
  }
  const std::size_t level = level_for(options, tolerance, selected.report);
  LODE_TRY(const Shared pyramid, with_mesh(level, progress));
  selected.tin = tin_of_level(*pyramid, level, delaunay::TinLinks::kept);
  if (focus) report_focus(*focus, source().frame, selected);
  finish_report(source(), {head_.max_error, head_.n_in_mesh.back()}, tolerance, watch, selected);
  return selected;
}

Result<std::shared_ptr<const TerrainParts>> PyramidTerrain::parts(
    const TerrainOptions& options) const {
  if (!file_ || !has_links(head_.encoding) || options.focus)
    return std::shared_ptr<const TerrainParts>{};
  LODE_TRY(const double tolerance, insertions_tolerance(options, source().range, finest_error()));
  TerrainReport report;
  const std::size_t level = level_for(options, tolerance, report);
  report.triangles = head_.n_in_mesh[level];
  report.vertices = head_.vertices_until[level];
  report.n_samples = source().n_samples;
  report.n_missing = source().n_missing;
  report.n_left_out = source().n_left_out;
  report.max_error = tolerance;
  report.achieved_error = head_.facts[level].largest_error;
  if (report.triangles == head_.n_in_mesh.back())
    report.achieved_error = std::min(report.achieved_error, head_.max_error);
  Progress progress;
  LODE_TRY(LinkStart start, LinkStart::read(*file_, progress));
  return std::shared_ptr<const TerrainParts>(
      std::make_shared<const LevelParts>(file_, std::move(start), level, report));
}

Result<std::uint64_t> PyramidTerrain::save(const std::string& path, Progress& progress) const {
  LODE_TRY(const Shared pyramid, all(progress));
  return delaunay_pyramid::save(*pyramid, path, progress);
}

BuiltTerrainInfo PyramidTerrain::describe_source() const {
  BuiltTerrainInfo info;
  info.sample_type = source().sample_type;
  info.has_place = source().has_place;
  info.n_nodes = head_.vertices_until.back();
  info.n_base_triangles = head_.n_in_mesh.front();
  info.n_triangles = head_.n_all_kept();
  info.n_links = head_.n_all_links();
  info.n_lines = head_.n_lines;
  info.memory_bytes = head_.bytes().all();
  add_parts(head_.bytes(), file_ ? file_->stored_bytes() : PyramidBytes{}, info);
  info.is_of_points = source().is_of_points;
  info.n_samples = source().n_samples;
  info.n_missing = source().n_missing;
  info.n_left_out = source().n_left_out;
  info.range = source().range;
  info.max_error = finest_error();
  return info;
}

Result<BuiltTerrainInfo> PyramidTerrain::describe(Progress& /*progress*/) const {
  BuiltTerrainInfo info = describe_source();
  for (std::size_t level = 0; level < head_.n_levels(); ++level)
    info.levels.push_back({head_.tolerances[level], head_.n_in_mesh[level],
                           head_.vertices_until[level], head_.facts[level].smallest_angle,
                           head_.facts[level].median_angle});
  return info;
}

}  // namespace lode
