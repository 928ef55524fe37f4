#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "lode/io/mesh_gmsh_input.h"
#include "lode/io/text.h"

namespace lode::io {
namespace {

/// Fields of one name and shape.
using SeriesKey = std::pair<std::string, int>;

/// Fields of points or of cells, with their times.
struct TimedFields {
  std::vector<MeshField>& fields;
  const std::vector<GmshTime>& times;
  std::map<SeriesKey, std::set<GmshTime>> series{};  ///< Of those that have several.
};

TimedFields timed_fields(std::vector<MeshField>& fields, const std::vector<GmshTime>& times) {
  TimedFields timed{fields, times};
  for (std::size_t i = 0; i < fields.size(); ++i)
    timed.series[{fields[i].name, fields[i].n_components}].insert(times[i]);
  std::erase_if(timed.series, [](const auto& series) { return series.second.size() < 2; });
  return timed;
}

/// Gives a field a name that none before has: its own, with "@STEP" behind as often as need be.
Result<void> make_name_new(const GmshTime& when, std::set<std::string>& names, MeshField& field,
                           const CellMesh& mesh) {
  // Names grow, and a file of many sections of one name would have far more of them than bytes.
  constexpr int kMostTimes = 64;
  const std::string name = field.name;
  const std::string suffix = fmt::format("@{}", when.step);
  for (int i = 0; i < kMostTimes; ++i, field.name += suffix)
    if (names.insert(field.name).second) return {};
  return fail("{}: expected at most {} fields of the name {} at step {}, got more", mesh.path,
              kMostTimes, in_quotes(name), when.step);
}

/// The first field of a series at a time stays, and all that are in none.
Result<void> keep_step(const std::optional<GmshTime>& chosen, TimedFields& timed, CellMesh& mesh) {
  std::vector<MeshField> kept;
  std::set<std::string> names;
  for (std::size_t i = 0; i < timed.fields.size(); ++i) {
    MeshField& field = timed.fields[i];
    const bool is_of_series = timed.series.contains({field.name, field.n_components});
    if (is_of_series && timed.times[i] != chosen) continue;
    LODE_CHECK(make_name_new(timed.times[i], names, field, mesh));
    kept.push_back(std::move(field));
  }
  for (const auto& [key, times] : timed.series)
    if (!times.contains(*chosen))
      mesh.skipped_arrays.push_back(
          fmt::format("{} (at other times than {}: --time chooses one)", key.first, chosen->time));
  timed.fields = std::move(kept);
  return {};
}

/// The one time that all have; none where they have several, or there are none.
std::optional<double> only_time(const GmshInput& input) {
  std::optional<double> only;
  for (const auto* times : {&input.point_times, &input.cell_times})
    for (const GmshTime& when : *times) {
      if (only && *only != when.time) return std::nullopt;
      only = when.time;
    }
  return only;
}

}  // namespace

Result<void> choose_gmsh_step(const MeshReadOptions& options, GmshInput& input) {
  CellMesh& mesh = input.mesh;
  TimedFields points = timed_fields(mesh.point_fields, input.point_times);
  TimedFields cells = timed_fields(mesh.cell_fields, input.cell_times);
  std::set<GmshTime> all;
  for (const TimedFields* timed : {&points, &cells})
    for (const auto& [key, times] : timed->series) all.insert(times.begin(), times.end());
  const std::vector<GmshTime> steps(all.begin(), all.end());
  std::optional<GmshTime> chosen;
  mesh.time = only_time(input);
  if (!steps.empty()) {
    mesh.step = options.step.value_or(steps.size() - 1);
    if (mesh.step >= steps.size())
      return fail("{}: expected a step from 0 to {}, got {}", mesh.path, steps.size() - 1,
                  mesh.step);
    chosen = steps[mesh.step];
    mesh.time = chosen->time;
    for (const GmshTime& when : steps) mesh.times.push_back(when.time);
  }
  LODE_CHECK(keep_step(chosen, points, mesh));
  return keep_step(chosen, cells, mesh);
}

}  // namespace lode::io
