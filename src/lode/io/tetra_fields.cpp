#include "lode/io/tetra_fields.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "lode/io/boundary_patches.h"
#include "lode/io/tetra_regions.h"
#include "lode/io/tetra_winding.h"
#include "lode/io/text.h"

namespace lode::io {
namespace {

std::size_t find_named(const std::vector<MeshField>& fields, std::string_view name) {
  const auto found = std::find_if(fields.begin(), fields.end(),
                                  [&](const MeshField& field) { return field.name == name; });
  return static_cast<std::size_t>(found - fields.begin());
}

/// A field of the mesh, and which scalar of it.
struct FieldChoice {
  const MeshField* field = nullptr;
  bool is_of_cells = false;
  std::optional<int> component;  ///< None: the value, or the magnitude.
  std::string name;
  bool is_mises = false;  ///< Von Mises' scalar of a symmetric tensor.
};

constexpr int kSymmetric = 6;  ///< Components: xx, yy, zz, and three others.
constexpr int kTensor = 9;     ///< By rows.
constexpr std::string_view kMises = ":mises";

/// The field that has just this name; none where there is none.
FieldChoice choice_named(const CellMesh& mesh, const std::string& name) {
  FieldChoice choice{.component = {}, .name = name};
  const std::size_t at = find_named(mesh.point_fields, name);
  if (at < mesh.point_fields.size()) {
    choice.field = &mesh.point_fields[at];
    return choice;
  }
  const std::size_t cell = find_named(mesh.cell_fields, name);
  if (cell == mesh.cell_fields.size()) return choice;
  choice.field = &mesh.cell_fields[cell];
  choice.is_of_cells = true;
  return choice;
}

std::string list_names(const CellMesh& mesh) {
  std::string names;
  for (const auto* fields : {&mesh.point_fields, &mesh.cell_fields})
    for (const MeshField& field : *fields) names += (names.empty() ? "" : ", ") + field.name;
  return names.empty() ? "none" : names;
}

Result<FieldChoice> parse_choice(const CellMesh& mesh, const std::string& text) {
  // A name may itself have a colon.
  FieldChoice choice = choice_named(mesh, text);
  if (choice.field != nullptr) return choice;
  if (text.ends_with(kMises)) {
    choice = choice_named(mesh, text.substr(0, text.size() - kMises.size()));
    choice.name = text;
    choice.is_mises = true;
    if (choice.field != nullptr && choice.field->n_components != kSymmetric &&
        choice.field->n_components != kTensor)
      return fail("{}: expected a tensor of 6 or 9 components for {}, got {}", mesh.path,
                  in_quotes(text), choice.field->n_components);
    if (choice.field != nullptr) return choice;
  }
  const std::size_t colon = text.rfind(':');
  const std::optional<std::int64_t> component =
      colon == std::string::npos ? std::nullopt : to_int64(text.substr(colon + 1));
  if (component) choice = choice_named(mesh, text.substr(0, colon));
  if (choice.field == nullptr)
    return fail("{}: expected a field of the mesh ({}), got {}", mesh.path, list_names(mesh),
                in_quotes(text));
  if (choice.field->n_components == 1 && *component != 0)
    return fail("{}: expected no component of the field {}, which is a scalar, got {}", mesh.path,
                in_quotes(choice.field->name), *component);
  if (*component < 0 || *component >= choice.field->n_components)
    return fail("{}: expected a component from 0 to {} of the field {}, got {}", mesh.path,
                choice.field->n_components - 1, in_quotes(choice.field->name), *component);
  choice.component = static_cast<int>(*component);
  choice.name = text;
  return choice;
}

/// All fields of the points, or of the cells but the one of regions.
Result<std::vector<FieldChoice>> all_choices(const CellMesh& mesh, const TetraOptions& options) {
  std::vector<FieldChoice> choices;
  for (const MeshField& field : mesh.point_fields)
    choices.push_back({.field = &field, .component = {}, .name = field.name});
  if (!choices.empty()) return choices;
  LODE_TRY(const std::size_t regions, find_regions(mesh, options));
  for (std::size_t i = 0; i < mesh.cell_fields.size(); ++i)
    if (i != regions && i != find_patch_ids(mesh, regions))
      choices.push_back({.field = &mesh.cell_fields[i],
                         .is_of_cells = true,
                         .component = {},
                         .name = mesh.cell_fields[i].name});
  return choices;
}

/// Beside fields of points those of cells that are no whole numbers, which may number them.
void add_measured_cell_fields(const CellMesh& mesh, std::size_t regions,
                              std::vector<FieldChoice>& choices) {
  for (std::size_t i = 0; i < mesh.cell_fields.size(); ++i) {
    const MeshField& field = mesh.cell_fields[i];
    if (i == regions || !is_floating(field.type)) continue;
    if (std::ranges::find(choices, field.name, &FieldChoice::name) != choices.end()) continue;
    choices.push_back({.field = &field, .is_of_cells = true, .component = {}, .name = field.name});
  }
}

/// What all_choices() has that is not chosen yet, and measured fields of cells beside those of
/// points, by components where there are three.
Result<void> add_others(const CellMesh& mesh, const TetraOptions& options,
                        std::vector<FieldChoice>& choices) {
  constexpr int kOfVector = 3;
  LODE_TRY(std::vector<FieldChoice> all, all_choices(mesh, options));
  LODE_TRY(const std::size_t regions, find_regions(mesh, options));
  if (!all.empty() && !all.front().is_of_cells) add_measured_cell_fields(mesh, regions, all);
  const auto add = [&](FieldChoice choice) {
    if (std::ranges::find(choices, choice.name, &FieldChoice::name) == choices.end())
      choices.push_back(std::move(choice));
  };
  for (const FieldChoice& choice : all) {
    if (choice.field->n_components != kOfVector) {
      add(choice);
      continue;
    }
    for (int k = 0; k < kOfVector; ++k) {
      FieldChoice component = choice;
      component.component = k;
      component.name += ":" + std::to_string(k);
      add(std::move(component));
    }
  }
  return {};
}

double magnitude_at(const MeshField& field, std::size_t i) {
  double sum = 0;
  for (int k = 0; k < field.n_components; ++k) sum += field.at(i, k) * field.at(i, k);
  return std::sqrt(sum);
}

/// Of nine components those off the diagonal are means of two.
double mises_at(const MeshField& field, std::size_t i) {
  const auto c = [&](int k) { return field.at(i, k); };
  const bool is_whole = field.n_components == kTensor;
  const double xx = c(0);
  const double yy = is_whole ? c(4) : c(1);
  const double zz = is_whole ? c(8) : c(2);
  const std::array<double, 3> shear =
      is_whole ? std::array<double, 3>{(c(1) + c(3)) / 2, (c(2) + c(6)) / 2, (c(5) + c(7)) / 2}
               : std::array<double, 3>{c(3), c(4), c(5)};
  const double normal = ((xx - yy) * (xx - yy) + (yy - zz) * (yy - zz) + (zz - xx) * (zz - xx)) / 2;
  return std::sqrt(normal + 3 * (shear[0] * shear[0] + shear[1] * shear[1] + shear[2] * shear[2]));
}

MeshField chosen_field(const FieldChoice& choice) {
  const MeshField& source = *choice.field;
  const bool is_magnitude = !choice.component && source.n_components > 1;
  MeshField field{.name = choice.name,
                  .type = is_magnitude ? ScalarType::float64 : source.type,
                  .n_components = 1,
                  .values = {}};
  const std::size_t n = source.values.size() / static_cast<std::size_t>(source.n_components);
  field.values.reserve(n);
  for (std::size_t i = 0; i < n; ++i)
    field.values.push_back(choice.is_mises ? mises_at(source, i)
                           : is_magnitude  ? magnitude_at(source, i)
                                           : source.at(i, choice.component.value_or(0)));
  return field;
}

/// Tetrahedra of one cell, which follow each other, and their volume.
struct CellRun {
  std::size_t begin = 0;
  std::size_t end = 0;
  double volume = 0;
};

std::vector<CellRun> runs_of(const std::vector<Vec3d>& points, const SplitCells& split) {
  std::vector<CellRun> runs;
  for (std::size_t i = 0; i < split.tetrahedra.size(); ++i) {
    if (i == 0 || split.cells[i] != split.cells[i - 1]) runs.push_back({.begin = i});
    runs.back().end = i + 1;
    runs.back().volume += std::abs(six_volumes(points, split.tetrahedra[i]));
  }
  return runs;
}

/// The points of a cell's tetrahedra, each once.
std::vector<std::uint32_t> points_of(const SplitCells& split, const CellRun& run) {
  std::vector<std::uint32_t> ids;
  for (std::size_t i = run.begin; i < run.end; ++i)
    ids.insert(ids.end(), split.tetrahedra[i].begin(), split.tetrahedra[i].end());
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  return ids;
}

/// A mean of what came so far, with weights and without; roundings do not bring it beyond that.
struct PointMean {
  double weighted = 0;
  double weight = 0;
  double sum = 0;
  double n = 0;
  double low = std::numeric_limits<double>::infinity();
  double high = -low;

  void add(double value, double volume) {
    weighted += value * volume;
    weight += volume;
    sum += value;
    ++n;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  [[nodiscard]] double value() const {
    const double mean = weight > 0 ? weighted / weight : sum / n;
    return std::isfinite(mean) ? std::clamp(mean, low, high) : mean;
  }
};

/// The least and the largest of what comes, of finite numbers.
struct FiniteRange {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;

  void add(double value) {
    if (!std::isfinite(value)) return;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  void put(double& least, double& largest) const {
    if (!(low <= high)) return;
    least = low;
    largest = high;
  }
};

/// Ranges of a field at a region's cells and at their points.
struct RegionRanges {
  FiniteRange cells;
  FiniteRange points;
};

/// Which regions have cells without a finite value, where others have not.
void find_nonfinite_regions(const CellMesh& mesh, std::size_t regions, const SplitCells& split,
                            const std::vector<CellRun>& runs, const std::vector<double>& at_cells,
                            AveragedField& averaged) {
  if (regions >= mesh.cell_fields.size() || averaged.n_nonfinite_cells == 0) return;
  std::map<std::int64_t, bool> lacks;
  for (const CellRun& run : runs) {
    const std::uint32_t cell = split.cells[run.begin];
    bool& is_lacking = lacks[static_cast<std::int64_t>(mesh.cell_fields[regions].values[cell])];
    is_lacking = is_lacking || !std::isfinite(at_cells[cell]);
  }
  const auto n =
      std::count_if(lacks.begin(), lacks.end(), [](const auto& of) { return of.second; });
  if (std::cmp_equal(n, lacks.size())) return;
  for (const auto& [id, is_lacking] : lacks)
    (is_lacking ? averaged.nonfinite_regions : averaged.finite_regions).push_back(id);
}

/// Regions that have points with values beyond those of their cells. `at_cells`: before.
std::vector<AveragedRegion> find_mixed_regions(const CellMesh& mesh, std::size_t regions,
                                               const SplitCells& split,
                                               const std::vector<CellRun>& runs,
                                               const std::vector<double>& at_cells,
                                               const std::vector<double>& at_points) {
  std::vector<AveragedRegion> mixed;
  if (regions >= mesh.cell_fields.size()) return mixed;
  std::map<std::int64_t, RegionRanges> ranges;
  for (const CellRun& run : runs) {
    const std::uint32_t cell = split.cells[run.begin];
    RegionRanges& of = ranges[static_cast<std::int64_t>(mesh.cell_fields[regions].values[cell])];
    of.cells.add(at_cells[cell]);
    for (const std::uint32_t point : points_of(split, run)) of.points.add(at_points[point]);
  }
  std::vector<std::int64_t> ids;
  ids.reserve(ranges.size());
  for (const auto& [id, range] : ranges) ids.push_back(id);
  const std::vector<std::string> names = names_of_regions(mesh, regions, ids);
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const auto& [cells, points] = ranges.at(ids[i]);
    if (!(points.low < cells.low || points.high > cells.high)) continue;
    AveragedRegion region{.id = ids[i], .name = names.empty() ? std::string() : names[i]};
    cells.put(region.cell_min, region.cell_max);
    points.put(region.point_min, region.point_max);
    mixed.push_back(std::move(region));
  }
  return mixed;
}

/// What is said of the cells that tetrahedra are of.
AveragedField describe(const SplitCells& split, const std::vector<CellRun>& runs,
                       const MeshField& field) {
  AveragedField averaged{.name = field.name};
  FiniteRange range;
  for (const CellRun& run : runs) {
    const std::uint32_t cell = split.cells[run.begin];
    range.add(field.values[cell]);
    if (!std::isfinite(field.values[cell]) && averaged.n_nonfinite_cells++ == 0)
      averaged.first_nonfinite = cell;
  }
  range.put(averaged.cell_min, averaged.cell_max);
  return averaged;
}

}  // namespace

Result<ChosenFields> choose_fields(const CellMesh& mesh, const TetraOptions& options) {
  std::vector<FieldChoice> choices;
  if (options.fields.empty()) {
    LODE_TRY(choices, all_choices(mesh, options));
  }
  for (const std::string& name : options.fields) {
    LODE_TRY(FieldChoice choice, parse_choice(mesh, name));
    for (const FieldChoice& other : choices)
      if (other.name == name)
        return fail("{}: expected each field once, got {} twice", mesh.path, in_quotes(name));
    choices.push_back(std::move(choice));
  }
  if (options.has_all && !options.fields.empty()) LODE_CHECK(add_others(mesh, options, choices));
  ChosenFields chosen;
  for (const FieldChoice& choice : choices) {
    if (!choice.component && !choice.is_mises && choice.field->n_components > 1)
      chosen.magnitudes.push_back({choice.name, choice.field->n_components});
    chosen.fields.push_back(chosen_field(choice));
    chosen.is_of_cells.push_back(choice.is_of_cells ? 1 : 0);
  }
  return chosen;
}

void average_cells(const CellMesh& mesh, std::size_t regions, const SplitCells& split,
                   ChosenFields& chosen, TetraReport& report) {
  const std::vector<Vec3d>& points = mesh.points;
  const std::vector<CellRun> runs = runs_of(points, split);
  for (std::size_t f = 0; f < chosen.fields.size(); ++f) {
    if (chosen.is_of_cells[f] == 0) continue;
    MeshField& field = chosen.fields[f];
    std::vector<PointMean> means(points.size());
    AveragedField averaged = describe(split, runs, field);
    FiniteRange range;
    for (const CellRun& run : runs)
      for (const std::uint32_t point : points_of(split, run))
        means[point].add(field.values[split.cells[run.begin]], run.volume);
    const std::vector<double> at_cells = std::move(field.values);
    field.values.assign(points.size(), std::numeric_limits<double>::quiet_NaN());
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (means[i].n == 0) continue;
      field.values[i] = means[i].value();
      range.add(field.values[i]);
    }
    range.put(averaged.point_min, averaged.point_max);
    find_nonfinite_regions(mesh, regions, split, runs, at_cells, averaged);
    averaged.regions = find_mixed_regions(mesh, regions, split, runs, at_cells, field.values);
    field.type = ScalarType::float64;
    chosen.is_of_cells[f] = 0;
    report.averaged.push_back(std::move(averaged));
  }
}

}  // namespace lode::io
