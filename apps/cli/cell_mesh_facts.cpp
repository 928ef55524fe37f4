#include "cell_mesh_facts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace lode::cli {
namespace {

/// Of finite numbers; empty where there is none.
struct FoundRange {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  std::uint64_t n_other = 0;  ///< That are no finite numbers.

  void add(double x) {
    if (!std::isfinite(x)) {
      ++n_other;
      return;
    }
    low = std::min(low, x);
    high = std::max(high, x);
  }
  [[nodiscard]] bool is_empty() const { return low > high; }
  [[nodiscard]] std::string text() const {
    if (is_empty()) return "no finite values";
    if (n_other == 0) return format_range(low, high);
    return fmt::format("{}, {} not finite", format_range(low, high), format_count(n_other));
  }
  [[nodiscard]] Json json() const { return is_empty() ? Json(nullptr) : Json::array({low, high}); }
};

/// Of scalars their range, of vectors that of lengths, which --field NAME alone takes.
FoundRange range_of_lengths(const MeshField& field) {
  FoundRange range;
  const auto n = static_cast<std::size_t>(field.n_components);
  for (std::size_t i = 0; i + n <= field.values.size(); i += n) {
    double sum = 0;
    for (std::size_t k = 0; k < n; ++k) sum += field.values[i + k] * field.values[i + k];
    range.add(n == 1 ? field.values[i] : std::sqrt(sum));
  }
  return range;
}

Json component_ranges(const MeshField& field) {
  const auto n = static_cast<std::size_t>(field.n_components);
  std::vector<FoundRange> ranges(n);
  for (std::size_t i = 0; i < field.values.size(); ++i) ranges[i % n].add(field.values[i]);
  Json all = Json::array();
  for (const FoundRange& range : ranges) all.push_back(range.json());
  return all;
}

void add_bounds(const std::vector<Vec3d>& points, Table& table, Json& json) {
  std::array<FoundRange, 3> axes;
  for (const Vec3d& p : points)
    for (std::size_t i = 0; i < 3; ++i) axes.at(i).add(p[i]);
  json["bounds"] = nullptr;
  if (std::ranges::any_of(axes, [](const FoundRange& axis) { return axis.is_empty(); })) return;
  json["bounds"] = {{axes[0].low, axes[1].low, axes[2].low},
                    {axes[0].high, axes[1].high, axes[2].high}};
  table.add(
      {"bounds", fmt::format("x {}, y {}, z {}", axes[0].text(), axes[1].text(), axes[2].text())});
}

void add_fields(const char* name, const std::vector<MeshField>& fields, Table& table, Json& json) {
  Json list = Json::array();
  for (const MeshField& field : fields) {
    const FoundRange range = range_of_lengths(field);
    list.push_back({{"name", field.name},
                    {"type", name_of(field.type)},
                    {"components", field.n_components},
                    {"range", range.json()},
                    {"nonfinite", range.n_other},
                    {"component_ranges", component_ranges(field)}});
    table.add({name, fmt::format("{}, {}, {}{}", field.name, name_of(field.type),
                                 field.n_components > 1
                                     ? fmt::format("{} components of length ", field.n_components)
                                     : "",
                                 range.text())});
  }
  json[std::string(name) + "s"] = std::move(list);
}

}  // namespace

void add_cell_mesh(const CellMesh& cells, Table& table, Json& json) {
  add_bounds(cells.points, table, json);
  add_fields("point field", cells.point_fields, table, json);
  add_fields("cell field", cells.cell_fields, table, json);
}

}  // namespace lode::cli
