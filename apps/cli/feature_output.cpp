#include "feature_output.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "to_crs.h"
#include "vector_output.h"

namespace lode::cli {
namespace {

using terrain_features::CriticalKind;
using terrain_features::LineKind;

const char* kind_name(CriticalKind kind) {
  switch (kind) {
    case CriticalKind::pit: return "pit";
    case CriticalKind::pass: return "pass";
    case CriticalKind::peak: return "peak";
  }
  return "";
}

/// Of a GeoPackage.
constexpr std::size_t kPointLayer = 0;
constexpr std::size_t kRidgeLayer = 1;
constexpr std::size_t kChannelLayer = 2;

std::vector<VectorLayer> to_layers(const std::string& crs) {
  const std::vector<VectorColumn> of_lines{{"from_height"}, {"to_height"}, {"persistence"}};
  return {{.name = "critical_points",
           .shape = VectorShape::points,
           .columns = {{"kind", ColumnType::text},
                       {"height"},
                       {"persistence"},
                       {"multiplicity", ColumnType::integer},
                       {"on_outline", ColumnType::integer}},
           .crs = crs,
           .has_heights = true},
          {.name = "ridges", .columns = of_lines, .crs = crs, .has_heights = true},
          {.name = "channels", .columns = of_lines, .crs = crs, .has_heights = true}};
}

/// The only layer of a GeoJSON file; each feature has the properties that mean something for it.
VectorLayer to_mixed_layer(const std::string& crs) {
  return {.name = "features",
          .shape = VectorShape::mixed,
          .columns = {{"kind", ColumnType::text},
                      {"height"},
                      {"persistence"},
                      {"multiplicity", ColumnType::integer},
                      {"on_outline", ColumnType::integer},
                      {"from_height"},
                      {"to_height"}},
          .crs = crs};
}

double on_outline(const TerrainFeatures::Point& point) { return point.is_on_outline ? 1 : 0; }

constexpr std::size_t kPointColumns = 5;

std::array<VectorValue, kPointColumns> values_of(const TerrainFeatures::Point& point) {
  return {kind_name(point.kind), point.at[2], point.relief, static_cast<double>(point.multiplicity),
          on_outline(point)};
}

Result<void> add_layered(VectorWriter& writer, const TerrainFeatures::Line& line) {
  const std::array<VectorValue, 3> values{line.points.front()[2], line.points.back()[2],
                                          line.relief};
  return writer.add(line.kind == LineKind::ridge ? kRidgeLayer : kChannelLayer, values,
                    line.points);
}

Result<void> add_mixed(VectorWriter& writer, const TerrainFeatures::Point& point) {
  std::array<VectorValue, kPointColumns + 2> values;
  std::ranges::copy(values_of(point), values.begin());
  return writer.add(0, values, {&point.at, 1});
}

Result<void> add_mixed(VectorWriter& writer, const TerrainFeatures::Line& line) {
  const std::array<VectorValue, kPointColumns + 2> values{
      line.kind == LineKind::ridge ? "ridge" : "channel",
      {},
      line.relief,
      {},
      {},
      line.points.front()[2],
      line.points.back()[2]};
  return writer.add(0, values, line.points);
}

Result<void> write_vectors(const std::string& path, const std::string& crs,
                           const TerrainFeatures& features, Progress& progress) {
  const bool is_mixed = is_geojson_path(path);
  LODE_TRY(VectorWriter writer, is_mixed ? VectorWriter::create(path, to_mixed_layer(crs))
                                         : VectorWriter::create(path, to_layers(crs)));
  const std::size_t n_points = features.points.size();
  return write_each(writer, n_points + features.lines.size(), progress, [&](std::size_t i) {
    if (i >= n_points) {
      const TerrainFeatures::Line& line = features.lines[i - n_points];
      return is_mixed ? add_mixed(writer, line) : add_layered(writer, line);
    }
    const TerrainFeatures::Point& point = features.points[i];
    return is_mixed ? add_mixed(writer, point)
                    : writer.add(kPointLayer, values_of(point), {&point.at, 1});
  });
}

/// Kinds as numbers: pit 0, pass 1, peak 2, ridge 3, channel 4.
Network to_network(const TerrainFeatures& features) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  constexpr double kRidge = 3;
  constexpr double kChannel = 4;
  const auto number_of = [](double relief) { return std::isfinite(relief) ? relief : kNone; };
  Network network;
  network.n_points = features.points.size();
  network.places.reserve(features.points.size() + features.n_line_points);
  Network::Column kinds{.name = "kind", .is_integer = true, .values = {}};
  Network::Column reliefs{.name = "persistence", .values = {}};
  Network::Column multiplicities{.name = "multiplicity", .is_integer = true, .values = {}};
  Network::Column outline{.name = "on_outline", .is_integer = true, .values = {}};
  for (const TerrainFeatures::Point& point : features.points) {
    network.places.push_back(point.at);
    kinds.values.push_back(static_cast<double>(point.kind));
    reliefs.values.push_back(number_of(point.relief));
    multiplicities.values.push_back(point.multiplicity);
    outline.values.push_back(on_outline(point));
  }
  for (const TerrainFeatures::Line& line : features.lines) {
    network.places.insert(network.places.end(), line.points.begin(), line.points.end());
    network.line_ends.push_back(network.places.size());
    kinds.values.push_back(line.kind == LineKind::ridge ? kRidge : kChannel);
    reliefs.values.push_back(number_of(line.relief));
    multiplicities.values.push_back(0);
    outline.values.push_back(0);
  }
  network.columns = {std::move(kinds), std::move(reliefs), std::move(multiplicities),
                     std::move(outline)};
  return network;
}

}  // namespace

Result<void> write_features(const std::string& path, const TerrainInput& input,
                            const TerrainFeatures& features, Progress& progress) {
  const std::string& crs = written_crs(input.opened, input.target);
  if (!is_vtp_path(path)) return write_vectors(path, crs, features, progress);
  const std::string comment = fmt::format(
      "Lode {}: features of relief {} or more; kind: pit 0, pass 1, peak 2, ridge 3, channel 4{}",
      LODE_VERSION, features.least_relief, crs.empty() ? "" : ", CRS " + crs);
  return write_network_vtp(path, to_network(features), comment, progress);
}

}  // namespace lode::cli
