#include "lode/api/terrain_comparison.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <new>
#include <random>
#include <string>
#include <system_error>

#include "lode/api/built_terrain.h"
#include "lode/api/compared_ground.h"
#include "lode/api/compared_terrain.h"
#include "lode/api/edge_walk.h"
#include "lode/api/file_build.h"
#include "lode/core/out_of_memory.h"
#include "lode/core/peak_memory.h"
#include "lode/core/stopwatch.h"
#include "lode/delaunay/tin_links.h"
#include "lode/locate/tin_height.h"
#include "lode/locate/tin_locator.h"
#include "lode/locate/tin_profile.h"
#include "lode/mappers/tin_contours.h"

namespace lode {
namespace {

double median(std::vector<double> seconds) {
  const auto middle = seconds.begin() + static_cast<std::ptrdiff_t>(seconds.size() / 2);
  std::nth_element(seconds.begin(), middle, seconds.end());
  return *middle;
}

/// The median time of n runs; an error of any ends them.
Result<double> time_of(int n_runs, const std::function<Result<void>()>& run) {
  std::vector<double> seconds;
  for (int i = 0; i < n_runs; ++i) {
    const Stopwatch watch;
    LODE_CHECK(run());
    seconds.push_back(watch.seconds());
  }
  return median(std::move(seconds));
}

std::vector<double> contour_levels(const HeightRange& range, int n) {
  std::vector<double> levels;
  for (int i = 0; i < n; ++i) {
    const double level = range.lower + (range.upper - range.lower) * (i + 0.5) / n;
    if (levels.empty() || level > levels.back()) levels.push_back(level);
  }
  return levels;
}

class Comparison {
 public:
  Comparison(const ComparedGround& ground, const ComparisonOptions& options, Progress& progress)
      : ground_(ground),
        options_(options),
        progress_(progress),
        range_(ground.range()),
        memory_limit_(options.memory_limit > 0 ? options.memory_limit : physical_memory() / 4) {
    std::mt19937_64 random(options.seed);
    const auto place = [&](std::int32_t n) {
      return static_cast<double>(random() >> 11) * 0x1p-53 * (n - 1);
    };
    for (std::uint32_t i = 0; i < options.n_places; ++i)
      places_.push_back({{place(frame().n_columns), place(frame().n_rows)}});
  }

  Result<TerrainComparison> run() {
    TerrainComparison made{.range = range_, .models = {}};
    made.n_samples = ground_.n_samples();
    made.memory_limit = memory_limit_;
    const std::vector<std::unique_ptr<TerrainCandidate>> models =
        terrain_candidates(made.memory_limit);
    for (std::size_t i = 0; i < models.size(); ++i) {
      progress_.report("comparing", static_cast<double>(i) / static_cast<double>(models.size()));
      LODE_TRY(ComparedModel model, compare(*models[i]));
      made.models.push_back(std::move(model));
    }
    return made;
  }

 private:
  Result<ComparedModel> compare(TerrainCandidate& model) {
    ComparedModel compared{.name = model.name(),
                           .what = model.what(),
                           .is_made_anew = model.is_made_anew(),
                           .neighbours = model.neighbours().how};
    const PeakMemory memory;
    if (auto refusal = ground_.prepare(model, options_.tolerances, options_.threads, progress_);
        !refusal) {
      if (progress_.is_cancelled()) return cancelled_error();
      compared.refusal = refusal.error().message;
      return compared;
    }
    compared.build_seconds = model.build_seconds();
    if (compared.build_seconds && !compared.is_made_anew) compared.peak_bytes = memory.bytes();
    const ModelLevels levels = model.levels();
    compared.n_levels = levels.n;
    compared.levels_are = levels.what;
    compared.memory_bytes = model.memory_bytes();
    compared.n_links = model.n_links();
    for (const double tolerance : options_.tolerances) {
      auto mesh = measure(model, tolerance);
      if (!mesh) {
        if (progress_.is_cancelled()) return cancelled_error();
        compared.refusal = fmt::format("within {}: {}", tolerance, mesh.error().message);
        compared.meshes.clear();
        return compared;
      }
      compared.meshes.push_back(*mesh);
      if (compared.is_made_anew)
        compared.build_seconds = compared.build_seconds.value_or(0) + mesh->extract_seconds;
    }
    if (compared.is_made_anew) {
      LODE_TRY(compared.peak_bytes, measure_making(model));
    }
    if (const auto kind = built_model_of(compared.name)) {
      LODE_TRY(compared.file_bytes, measure_file(*kind));
    }
    add_missing(model, compared);
    return compared;
  }

  /// What the mesh within the finest tolerance takes, made once more.
  Result<std::optional<std::uint64_t>> measure_making(TerrainCandidate& model) {
    const PeakMemory memory;
    LODE_TRY(const auto made, model.extract(std::ranges::min(options_.tolerances), progress_));
    return memory.bytes();
  }

  /// Says of all that has no value why.
  static void add_missing(const TerrainCandidate& model, ComparedModel& compared) {
    const auto add = [&](bool is_there, const char* what, std::string why) {
      if (!is_there) compared.missing.push_back({what, std::move(why)});
    };
    const auto has = [&](auto member) {
      return std::ranges::all_of(
          compared.meshes, [&](const ComparedMesh& mesh) { return (mesh.*member).has_value(); });
    };
    add(compared.n_levels > 0, "levels", compared.levels_are);
    add(compared.memory_bytes.has_value(), "memory", model.why_not(ModelPart::memory));
    add(compared.peak_bytes.has_value(), "building took", "the system does not tell");
    add(compared.file_bytes.has_value(), "file", model.why_not(ModelPart::file));
    add(compared.n_links.has_value(), "links", model.why_not(ModelPart::links));
    add(has(&ComparedMesh::variable_seconds), "variable", model.why_not(ModelPart::variable));
    add(has(&ComparedMesh::zoom_seconds), "zoom", model.why_not(ModelPart::zoom));
    add(has(&ComparedMesh::located_per_second), "found", model.why_not(ModelPart::location));
    add(has(&ComparedMesh::crossed_per_second), "steps", compared.neighbours);
    add(has(&ComparedMesh::contour_seconds), "contours",
        "lines would break off where triangles leave gaps");
    add(has(&ComparedMesh::profile_seconds), "profile",
        "it would break off where triangles leave gaps");
  }

  /// Builds it once more, for a file that is removed again.
  Result<std::uint64_t> measure_file(TerrainModel kind) {
    TerrainBuildOptions options{
        .model = kind, .levels = options_.tolerances, .memory_limit = memory_limit_};
    std::ranges::sort(options.levels, std::greater());
    options.levels.erase(std::unique(options.levels.begin(), options.levels.end()),
                         options.levels.end());
    LODE_TRY(const BuiltTerrain built, ground_.build(options, progress_));
    const std::string path = fmt::format(
        "{}/lode-compare-{}.lode", std::filesystem::temp_directory_path().string(), ::getpid());
    auto size = built.save(path, progress_);
    std::error_code ignored;
    std::filesystem::remove(path, ignored);
    return size;
  }

  Result<ComparedMesh> measure(TerrainCandidate& model, double tolerance) {
    ComparedMesh mesh{.tolerance = tolerance};
    TerrainCandidate::Answer answer;
    LODE_TRY(mesh.extract_seconds, time_of(options_.n_runs, [&]() -> Result<void> {
               LODE_TRY(answer, model.extract(tolerance, progress_));
               return {};
             }));
    delaunay::Tin& tin = answer.tin;
    mesh.triangles = tin.triangles.size();
    mesh.vertices = tin.vertices.size();
    mesh.stated_error = answer.stated_error;
    mesh.rounding = rounding_of(answer);
    mesh.quality = ground_.quality(tin, answer.scale, options_.threads);
    mesh.gaps = measure_gaps(tin);
    LODE_CHECK(measure_variable(model, tolerance, mesh));
    LODE_CHECK(measure_descent(model, tolerance, mesh));
    complete(tin, mesh);
    LODE_CHECK(measure_navigation(model, tin, tolerance, mesh));
    mesh.memory_bytes = tin.triangles.size() * (2 * sizeof(tin.triangles[0]) + sizeof(float)) +
                        tin.vertices.size() * (sizeof(tin.vertices[0]) + sizeof(double));
    LODE_CHECK(measure_questions(tin, answer.scale, mesh));
    if (mesh.gaps.n_hanging > 0) LODE_CHECK(measure_patches(model, tolerance, mesh));
    if (progress_.is_cancelled()) return cancelled_error();
    return mesh;
  }

  /// Errors are measured in 64 bits of mantissa, from differences of heights. Those of vertices
  /// between samples are rounded themselves.
  [[nodiscard]] double rounding_of(const TerrainCandidate::Answer& answer) const {
    if (answer.scale == 1) return 0x1p-52 * (range_.upper - range_.lower);
    return 0x1p-48 * std::max(std::abs(range_.lower), std::abs(range_.upper));
  }

  Result<void> measure_variable(TerrainCandidate& model, double tolerance, ComparedMesh& mesh) {
    if (!model.can_vary()) return {};
    LODE_TRY(mesh.variable_seconds, time_of(options_.n_runs, [&]() -> Result<void> {
               LODE_TRY(mesh.variable_triangles, model.extract_middle(tolerance, progress_));
               return {};
             }));
    return {};
  }

  /// What a model finds without a mesh.
  Result<void> measure_descent(TerrainCandidate& model, double tolerance,
                               ComparedMesh& mesh) const {
    const TerrainWindow window{{part(frame().n_columns, 3), part(frame().n_rows, 3)},
                               {part(frame().n_columns, 5), part(frame().n_rows, 5)}};
    bool can_zoom = false;
    LODE_TRY(const double zoom_seconds, time_of(options_.n_runs, [&]() -> Result<void> {
               LODE_TRY(const auto found, model.zoom(tolerance, window));
               can_zoom = found.has_value();
               mesh.zoom_triangles = found.value_or(0);
               return {};
             }));
    if (can_zoom) mesh.zoom_seconds = zoom_seconds;
    std::vector<delaunay::LatticePoint> samples;
    for (const delaunay::Point& place : places_)
      samples.push_back({static_cast<std::int32_t>(place[0]), static_cast<std::int32_t>(place[1])});
    bool can_locate = false;
    LODE_TRY(const double seconds, time_of(options_.n_runs, [&]() -> Result<void> {
               can_locate = model.locate(tolerance, samples).has_value();
               return {};
             }));
    if (can_locate && seconds > 0) mesh.located_per_second = options_.n_places / seconds;
    return {};
  }

  Result<void> measure_navigation(TerrainCandidate& model, const delaunay::Tin& tin,
                                  double tolerance, ComparedMesh& mesh) const {
    const Neighbours::Place place = model.neighbours().place;
    if (place == Neighbours::Place::nowhere) return {};
    std::uint64_t n_crossed = 0;
    const auto middle = static_cast<std::uint32_t>(tin.triangles.size() / 2);
    LODE_TRY(const double seconds, time_of(options_.n_runs, [&]() -> Result<void> {
               n_crossed = place == Neighbours::Place::in_model
                               ? model.walk(tolerance, options_.n_steps, options_.seed)
                               : walk_edges(middle, options_.n_steps, options_.seed,
                                            [&](std::uint32_t triangle, unsigned edge) {
                                              return tin.twins[triangle][edge];
                                            });
               return {};
             }));
    if (seconds > 0) mesh.crossed_per_second = static_cast<double>(n_crossed) / seconds;
    return {};
  }

  /// What questions need.
  static void complete(delaunay::Tin& tin, ComparedMesh& mesh) {
    if (tin.twins.empty()) {
      const Stopwatch watch;
      tin.twins = delaunay::find_twins(tin.triangles);
      mesh.twins_seconds = watch.seconds();
    }
    if (tin.errors.empty()) tin.errors.assign(tin.triangles.size(), 0);
  }

  Result<void> measure_questions(const delaunay::Tin& tin, double scale, ComparedMesh& mesh) const {
    // What crosses gaps would be broken there.
    if (mesh.gaps.n_hanging == 0) LODE_CHECK(measure_lines(tin, scale, mesh));
    const Stopwatch making;
    const TinLocator locator(tin);
    mesh.locator_seconds = making.seconds();
    std::vector<delaunay::Point> places = places_;
    for (delaunay::Point& place : places) place = place * scale;
    double sum = 0;
    LODE_TRY(const double seconds, time_of(options_.n_runs, [&]() -> Result<void> {
               for (const delaunay::Point& place : places)
                 if (const auto triangle = locator.find(place))
                   sum += height_in(tin, *triangle, place).height;
               return {};
             }));
    if (seconds > 0 && std::isfinite(sum)) mesh.places_per_second = options_.n_places / seconds;
    return {};
  }

  /// A profile over gaps, where the model has what to go along there.
  Result<void> measure_patches(TerrainCandidate& model, double tolerance,
                               ComparedMesh& mesh) const {
    LODE_TRY(const std::shared_ptr<const TerrainPatches> patches,
             model.patches(tolerance, progress_));
    if (!patches) return {};
    const auto line = line_across(1);
    LODE_TRY(mesh.profile_seconds, time_of(options_.n_runs, [&]() -> Result<void> {
               mesh.profile_points = patches->profile(line[0], line[1]).size();
               return {};
             }));
    return {};
  }

  Result<void> measure_lines(const delaunay::Tin& tin, double scale, ComparedMesh& mesh) const {
    const std::vector<double> levels = contour_levels(range_, options_.n_contours);
    LODE_TRY(mesh.contour_seconds, time_of(options_.n_runs, [&]() -> Result<void> {
               LODE_TRY(const ContourSet found,
                        trace_contours(tin, levels, KeptLines::drawable, progress_));
               mesh.contour_points = found.n_points;
               return {};
             }));
    const auto line = line_across(scale);
    LODE_TRY(mesh.profile_seconds, time_of(options_.n_runs, [&]() -> Result<void> {
               mesh.profile_points = tin_profile(tin, line[0], line[1]).size();
               return {};
             }));
    return {};
  }

  /// Near the diagonal, which is an edge of many models' bases, and of some of all their meshes.
  [[nodiscard]] std::array<delaunay::Point, 2> line_across(double scale) const {
    const double width = scale * (frame().n_columns - 1);
    const double height = scale * (frame().n_rows - 1);
    return {{{{0.01 * width, 0.03 * height}}, {{0.98 * width, 0.99 * height}}}};
  }
  [[nodiscard]] const HeightFrame& frame() const { return ground_.frame(); }
  /// So many eighths.
  static std::int32_t part(std::int32_t n, std::int32_t eighths) {
    return static_cast<std::int32_t>(std::int64_t{n} * eighths / 8);
  }

  const ComparedGround& ground_;
  const ComparisonOptions& options_;
  Progress& progress_;
  HeightRange range_;
  std::uint64_t memory_limit_;  ///< Of links between levels.
  std::vector<delaunay::Point> places_;
};

Result<void> check_options(const ComparisonOptions& options) {
  if (options.tolerances.empty()) return fail("tolerances: expected some, got none");
  for (const double tolerance : options.tolerances)
    if (!(tolerance >= 0 && std::isfinite(tolerance)))
      return fail("tolerances: expected finite numbers >= 0, got {}", tolerance);
  if (options.n_runs < 1 || options.n_contours < 1)
    return fail("expected at least one run and one contour, got {} and {}", options.n_runs,
                options.n_contours);
  return {};
}

}  // namespace

namespace {

Result<TerrainComparison> compare_on(const ComparedGround& ground, const ComparisonOptions& options,
                                     Progress& progress) try {
  const Stopwatch watch;
  LODE_CHECK(check_options(options));
  LODE_CHECK(ground.check());
  LODE_TRY(TerrainComparison made, Comparison(ground, options, progress).run());
  made.seconds = watch.seconds();
  return made;
} catch (const std::bad_alloc&) {
  return out_of_memory("compare models of terrain");
}

}  // namespace

Result<TerrainComparison> compare_terrain(const HeightGrid& grid, const ComparisonOptions& options,
                                          Progress& progress) {
  return compare_on(ComparedGround(grid), options, progress);
}

Result<TerrainComparison> compare_terrain(const PointTerrain& terrain,
                                          const ComparisonOptions& options, Progress& progress) {
  return compare_on(ComparedGround(terrain), options, progress);
}

}  // namespace lode
