#include "lode/api/opened_insertions.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "lode/api/insertions_selection.h"
#include "lode/core/stopwatch.h"
#include "lode/models/terrain/insertions/extract.h"
#include "lode/models/terrain/insertions/local_lines.h"
#include "lode/models/terrain/insertions/local_selection.h"
#include "lode/models/terrain/insertions/mesh_replay.h"
#include "lode/models/terrain/insertions/replay.h"
#include "lode/refine/focus.h"

namespace lode {

using insertions::History;
using insertions::HistoryFile;
using insertions::LevelFacts;
using insertions::ToleranceStep;

namespace {

/// The mesh at a time, in parts.
class StepParts final : public TerrainParts {
 public:
  StepParts(std::shared_ptr<const HistoryFile> file, const ToleranceStep& step, double tolerance)
      : file_(std::move(file)), time_(step.time) {
    const History& base = file_->base();
    report_.triangles = step.n_triangles;
    report_.vertices = std::uint64_t{base.n_base_vertices} + step.time;
    report_.max_error = tolerance;
    report_.achieved_error = static_cast<double>(step.largest);
    if (step.n_triangles == file_->steps().back().n_triangles)
      report_.achieved_error = std::min(report_.achieved_error, base.max_error);
    report_.is_within_error = base.max_error <= tolerance;
    report_.n_samples = base.n_samples;
    report_.n_missing = base.n_missing;
    report_.n_left_out = base.n_left_out;
    for (const LatticePoint& p : base.vertices) box_.add(p);
  }

  [[nodiscard]] const TerrainReport& report() const override { return report_; }
  [[nodiscard]] LatticePoint lower() const override { return box_.lower; }
  [[nodiscard]] LatticePoint upper() const override { return box_.upper; }
  [[nodiscard]] Result<delaunay::Tin> around(std::span<const delaunay::Point> places,
                                             Progress& progress) const override {
    return tin_around(*file_, time_, places, progress);
  }
  [[nodiscard]] Result<delaunay::Tin> along(const delaunay::Point& a, const delaunay::Point& b,
                                            Progress& progress) const override {
    return tin_along(*file_, time_, a, b, progress);
  }
  [[nodiscard]] Result<std::optional<delaunay::Tin>> within(const delaunay::Point& lower,
                                                            const delaunay::Point& upper,
                                                            Progress& progress) const override {
    return tin_within(*file_, time_, lower, upper, time_ / kGreatPart, progress);
  }
  [[nodiscard]] Result<std::optional<delaunay::Tin>> crossing(std::span<const double> heights,
                                                              Progress& progress) const override {
    if (expected_crossing(*file_, time_, heights) > kSoonerAll * time_)
      return std::optional<delaunay::Tin>();
    const auto most = static_cast<std::uint32_t>(kSoonerAll * time_);
    return tin_crossing(*file_, time_, heights, most, progress);
  }
  [[nodiscard]] Result<std::optional<HeightRange>> height_range(Progress& progress) const override {
    return insertions::height_range(*file_, time_, time_ / kGreatPart, progress);
  }

 private:
  /// As for a demand: of a great part of the mesh all is had sooner. Of a part that is known to be
  /// about so large, of more than half.
  static constexpr std::uint32_t kGreatPart = 8;
  static constexpr double kSoonerAll = 0.5;

  std::shared_ptr<const HistoryFile> file_;
  std::uint32_t time_;
  TerrainReport report_;
  insertions::LatticeBox box_;  ///< Of the base, which has the outline.
};

bool is_same(const ToleranceStep& a, const ToleranceStep& b) {
  return a.error == b.error && a.time == b.time && a.n_triangles == b.n_triangles &&
         a.largest == b.largest;
}

/// Angles are computed, elsewhere perhaps otherwise in the last places.
bool is_same(const LevelFacts& a, const LevelFacts& b) {
  constexpr double kRounding = 1e-6;
  return a.tolerance == b.tolerance && a.n_triangles == b.n_triangles &&
         a.n_vertices == b.n_vertices &&
         std::abs(a.smallest_angle - b.smallest_angle) < kRounding &&
         std::abs(a.median_angle - b.median_angle) < kRounding;
}

/// How many differ.
template <typename T>
std::uint64_t count_other(std::span<const T> said, std::span<const T> found) {
  if (said.size() != found.size()) return std::max(said.size(), found.size());
  std::uint64_t n = 0;
  for (std::size_t i = 0; i < said.size(); ++i) n += is_same(said[i], found[i]) ? 0 : 1;
  return n;
}

}  // namespace

Result<std::shared_ptr<const OpenedInsertions>> OpenedInsertions::open(const std::string& path) {
  LODE_TRY(HistoryFile file, HistoryFile::open(path));
  return std::make_shared<const OpenedInsertions>(std::move(file));
}

TerrainModel OpenedInsertions::model() const { return terrain_model_of(file_->base().model); }

const ToleranceStep* OpenedInsertions::step_for(const TerrainOptions& options,
                                                double tolerance) const {
  if (!file_->base().is_worst_first() || (options.max_cells && !options.max_error)) return nullptr;
  const ToleranceStep& step = step_within(file_->steps(), tolerance);
  return options.max_cells && step.n_triangles > *options.max_cells ? nullptr : &step;
}

/// Of a number of triangles, to where there are more.
std::size_t OpenedInsertions::n_bands_for(const TerrainOptions& options) const {
  if (!file_->base().is_worst_first()) return file_->bands().size();
  const auto beyond = std::ranges::find_if(file_->steps(), [&](const ToleranceStep& other) {
    return other.n_triangles > *options.max_cells;
  });
  return file_->n_bands_before(beyond == file_->steps().end() ? file_->n_nodes() : beyond->time);
}

Result<delaunay::Tin> OpenedInsertions::tin_of_step(const ToleranceStep& step,
                                                    Progress& progress) const {
  const std::size_t n_bands = file_->n_bands_before(step.time);
  bool is_first = false;
  {
    const std::lock_guard lock(mutex_);
    is_first = !has_answered_ && (!history_ || n_bands_ < n_bands);
    has_answered_ = true;
  }
  delaunay::Tin tin;
  if (is_first) {
    LODE_TRY(tin, tin_at(*file_, step.time, progress));
  } else {
    LODE_TRY(const auto replayed, history(n_bands, progress));
    tin = tin_at(*replayed, step.time, delaunay::TinLinks::kept);
  }
  const double largest = largest_error(tin);
  if (tin.triangles.size() != step.n_triangles || largest != static_cast<double>(step.largest))
    return fail(
        "{}: expected {} triangles that err by up to {} after {} nodes, got {}, by up to {}",
        file_->path(), step.n_triangles, step.largest, step.time, tin.triangles.size(), largest);
  return tin;
}

Result<std::shared_ptr<const History>> OpenedInsertions::history(std::size_t n_bands,
                                                                 Progress& progress) const {
  const std::lock_guard lock(mutex_);
  if (!history_ || n_bands_ < n_bands) {
    history_ = nullptr;
    LODE_TRY(History replayed, insertions::replay(*file_, n_bands, progress));
    history_ = std::make_shared<const History>(std::move(replayed));
    n_bands_ = n_bands;
  }
  return history_;
}

Result<std::shared_ptr<const InsertionsTerrain>> OpenedInsertions::whole(Progress& progress) const {
  const std::lock_guard lock(mutex_);
  if (!whole_) {
    LODE_TRY(History replayed, insertions::replay(*file_, file_->bands().size(), progress));
    whole_ = std::make_shared<const InsertionsTerrain>(
        insertions::LevelledHistory{std::move(replayed), file_->levels()});
  }
  return whole_;
}

Result<delaunay::Tin> OpenedInsertions::tin_of_demand(const Demand& demand,
                                                      Progress& progress) const {
  constexpr auto kLinks = delaunay::TinLinks::kept;
  constexpr std::uint32_t kGreatPart = 8;
  LODE_TRY(std::optional<delaunay::Tin> tin,
           select_tin(*file_, demand, kLinks, file_->n_nodes() / kGreatPart, progress));
  if (tin) return *std::move(tin);
  LODE_TRY(const auto all, history(file_->bands().size(), progress));
  return tin_of(*all, select_nodes(*all, demand), kLinks);
}

Result<SelectedTerrain> OpenedInsertions::select(const TerrainOptions& options, delaunay::TinLinks,
                                                 Progress& progress) const {
  const Stopwatch watch;
  if (progress.is_cancelled()) return cancelled_error();
  const History& base = file_->base();
  LODE_TRY(const double tolerance, insertions_tolerance(options, base.range, base.max_error));
  SelectedTerrain selected;
  if (options.focus) {
    LODE_TRY(const TerrainDemand focus,
             TerrainDemand::make(*options.focus, tolerance, base.frame, base.range));
    LODE_TRY(selected.tin, tin_of_demand(focus.demand(), progress));
    report_focus(focus, base.frame, selected);
  } else if (!base.is_worst_first() && !options.max_cells) {
    LODE_TRY(selected.tin, tin_of_demand(uniform_demand(tolerance), progress));
    selected.report.is_within_error = base.max_error <= tolerance;
  } else if (const ToleranceStep* const step = step_for(options, tolerance); step != nullptr) {
    LODE_TRY(selected.tin, tin_of_step(*step, progress));
    selected.report.is_within_error = base.max_error <= tolerance;
  } else {
    LODE_TRY(const auto replayed, history(n_bands_for(options), progress));
    selected.tin = uniform_tin(*replayed, base.max_error, options, tolerance, selected.report);
  }
  finish_report(base, {base.max_error, file_->steps().back().n_triangles}, tolerance, watch,
                selected);
  return selected;
}

Result<std::shared_ptr<const TerrainParts>> OpenedInsertions::parts(
    const TerrainOptions& options) const {
  const History& base = file_->base();
  if (options.focus || options.max_cells || !base.is_worst_first())
    return std::shared_ptr<const TerrainParts>{};
  LODE_TRY(const double tolerance, insertions_tolerance(options, base.range, base.max_error));
  return std::shared_ptr<const TerrainParts>(
      std::make_shared<const StepParts>(file_, step_within(file_->steps(), tolerance), tolerance));
}

Result<SelectedTerrain> OpenedInsertions::select_all(Progress& progress) const {
  if (file_->base().is_worst_first()) return BuiltModel::select_all(progress);
  LODE_TRY(const auto all, whole(progress));
  return all->select_all(progress);
}

Result<std::uint64_t> OpenedInsertions::save(const std::string& path, Progress& progress) const {
  LODE_TRY(const auto all, whole(progress));
  return all->save(path, progress);
}

BuiltTerrainInfo OpenedInsertions::describe_source() const {
  BuiltTerrainInfo info = describe_base(file_->base());
  info.n_nodes = file_->n_nodes();
  info.n_triangles = file_->n_triangles();
  info.memory_bytes = file_->n_history_bytes();
  return info;
}

Result<BuiltTerrainInfo> OpenedInsertions::describe(Progress& /*progress*/) const {
  BuiltTerrainInfo info = describe_source();
  add_levels(file_->facts(), info);
  return info;
}

Result<void> OpenedInsertions::check_said(Progress& progress, VerifyReport& report) const {
  LODE_TRY(const auto all, whole(progress));
  const auto steps = find_tolerance_steps(all->history());
  const std::uint64_t n_steps = count_other<ToleranceStep>(file_->steps(), steps);
  report.add("tolerances are kept when the file says", steps.size(), n_steps,
             n_steps > 0 ? fmt::format("{} are not", n_steps) : "");
  LODE_TRY(const auto facts, all->facts(progress));
  const std::uint64_t n_levels = count_other<LevelFacts>(file_->facts(), facts);
  report.add("levels are as the file says", facts.size(), n_levels,
             n_levels > 0 ? fmt::format("{} are not", n_levels) : "");
  return {};
}

Result<VerifyReport> OpenedInsertions::verify(const HeightGrid& grid, Threads threads,
                                              Progress& progress) const {
  LODE_TRY(const auto all, whole(progress));
  LODE_TRY(VerifyReport report, all->verify(grid, threads, progress));
  LODE_CHECK(check_said(progress, report));
  return report;
}

Result<VerifyReport> OpenedInsertions::verify(const PointTerrain& terrain, Threads threads,
                                              Progress& progress) const {
  LODE_TRY(const auto all, whole(progress));
  LODE_TRY(VerifyReport report, all->verify(terrain, threads, progress));
  LODE_CHECK(check_said(progress, report));
  return report;
}

Result<VerifyReport> OpenedInsertions::verify_alone(Threads threads, Progress& progress) const {
  LODE_TRY(const auto all, whole(progress));
  LODE_TRY(VerifyReport report, all->verify_alone(threads, progress));
  LODE_CHECK(check_said(progress, report));
  return report;
}

}  // namespace lode
