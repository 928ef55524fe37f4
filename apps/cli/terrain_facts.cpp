#include "terrain_facts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "point_facts.h"

namespace lode::cli {
namespace {

Json text_or_null(const std::string& text) { return text.empty() ? Json(nullptr) : Json(text); }

/// The name that WKT gives: what its first quotes hold.
std::string crs_name(const std::string& wkt) {
  const std::size_t first = wkt.find('"');
  const std::size_t last = first == std::string::npos ? first : wkt.find('"', first + 1);
  return last == std::string::npos ? wkt : wkt.substr(first + 1, last - first - 1);
}

Json counts_of(const terrain_features::FeatureCounts& counts) {
  return {{"peaks", counts.peaks}, {"passes", counts.passes}, {"pits", counts.pits}};
}

/// Of all corners, as rasters may be turned.
PlaceBox extent_of(const HeightFrame& frame) {
  const Place first = frame.world(0, 0);
  PlaceBox box{first, first};
  for (const int x : {0, frame.n_columns - 1})
    for (const int y : {0, frame.n_rows - 1}) {
      const Place corner = frame.world(x, y);
      for (std::size_t axis = 0; axis < 2; ++axis) {
        box.lower[axis] = std::min(box.lower[axis], corner[axis]);
        box.upper[axis] = std::max(box.upper[axis], corner[axis]);
      }
    }
  return box;
}

/// "degrees", "metre", ... of x and y; empty: not known.
std::string place_unit(const HorizontalMetric& metric) {
  if (!metric.ellipsoid) return metric.unit;
  constexpr double kDegree = std::numbers::pi / 180;
  if (std::abs(metric.angle_unit / kDegree - 1) < 1e-9) return "degrees";
  return fmt::format("{} radians", metric.angle_unit);
}

}  // namespace

Result<void> add_extent(const TerrainFacts& facts, Json& json, Table& table) {
  const HeightFrame& frame = facts.frame;
  LODE_TRY(const HorizontalMetric metric, read_metric(frame.crs));
  const std::string unit = place_unit(metric);
  const PlaceBox box = extent_of(frame);
  const auto& g = frame.to_world;
  const std::array<double, 2> cell{std::hypot(g[1], g[4]), std::hypot(g[2], g[5])};
  const bool is_of_cells = !facts.is_of_points && !facts.points;
  json["extent"] = {{"x", {box.lower[0], box.upper[0]}}, {"y", {box.lower[1], box.upper[1]}}};
  json["place_unit"] = text_or_null(unit);
  json["cell_size"] = is_of_cells ? Json(cell) : Json(nullptr);
  const auto between = [&](std::size_t axis) {
    const double step = std::min(cell[axis], box.upper[axis] - box.lower[axis]);
    // To be typed again as a place, where a comma would part numbers.
    std::string text = fmt::format("{} to {}", format_height(box.lower[axis], step),
                                   format_height(box.upper[axis], step));
    std::erase(text, ',');
    return text;
  };
  table.add({"extent of x", between(0)});
  table.add({"extent of y", between(1)});
  table.add({"unit of x and y", !facts.has_place ? "columns, and rows from the last up"
                                : unit.empty()   ? "not known"
                                                 : unit});
  if (is_of_cells)
    table.add(
        {"cell size", fmt::format("{} x {}", format_number(cell[0]), format_number(cell[1]))});
  const bool has_pixels = is_of_cells && facts.form.geotransform.has_value();
  json["pixels"] = has_pixels ? Json(facts.form.is_point ? "points" : "areas") : Json(nullptr);
  if (has_pixels)
    table.add({"pixels", facts.form.is_point ? "points: the file has the places of samples"
                                             : "areas: samples are in their middle"});
  return {};
}

void add_lines(const OpenedTerrain& opened, Json& json, Table& table) {
  if (!opened.lines) return;
  const TerrainLineReport& lines = *opened.lines;
  Json& all = json["lines"];
  if (lines.kept_features) {
    const auto& kept = *lines.kept_features;
    all["features"] = {{"relief", lines.least_relief},
                       {"kept", counts_of(kept)},
                       {"all", counts_of(*lines.all_features)},
                       {"ridges", lines.n_ridges},
                       {"channels", lines.n_channels}};
    table.add(
        {"features", fmt::format("{} peaks, {} passes, {} pits of a relief of {} or more",
                                 format_count(kept.peaks), format_count(kept.passes),
                                 format_count(kept.pits), format_number(lines.least_relief))});
  }
  if (lines.n_breaklines > 0) {
    all["breaklines"] = {{"lines", lines.n_breaklines},
                         {"left_out_points", lines.n_points},
                         {"own_heights", lines.n_own_heights},
                         {"drape_error", lines.drape_error},
                         {"outside", lines.n_outside},
                         {"cut", lines.n_cut},
                         {"left_out_edges", lines.n_crossing},
                         {"replaced_samples", lines.n_replaced},
                         {"largest_change", lines.largest_change},
                         {"unequal_crossings", lines.n_unequal},
                         {"largest_spread", lines.largest_spread},
                         {"largest_move", lines.largest_move}};
    table.add({"breaklines",
               fmt::format("{}, {} with their own heights", format_count(lines.n_breaklines),
                           format_count(lines.n_own_heights))});
    if (lines.n_replaced > 0)
      table.add({"replaced",
                 fmt::format("{} samples under breaklines, by up to {}",
                             format_count(lines.n_replaced), format_number(lines.largest_change))});
    if (lines.n_unequal > 0)
      table.add({"averaged",
                 fmt::format("{} places where breaklines meet at heights up to {} apart",
                             format_count(lines.n_unequal), format_number(lines.largest_spread))});
  }
  all["edges"] = lines.n_edges;
  all["seconds"] = lines.seconds;
}

std::uint64_t n_full_triangles(const TerrainFacts& facts, std::uint64_t n_samples) {
  if (facts.is_of_points || facts.points) return 2 * n_samples;
  const HeightFrame& frame = facts.frame;
  return 2 * static_cast<std::uint64_t>(frame.n_columns - 1) *
         static_cast<std::uint64_t>(frame.n_rows - 1);
}

void add_facts(const TerrainFacts& facts, Json& json, Table& table) {
  const HeightFrame& frame = facts.frame;
  json["columns"] = frame.n_columns;
  json["rows"] = frame.n_rows;
  json["type"] = facts.type;
  json["missing_samples"] = facts.n_missing;
  json["to_world"] = frame.to_world;
  json["has_position"] = facts.has_place;
  json["crs"] = text_or_null(frame.crs);
  const std::string vertical = vertical_name(frame.crs);
  json["vertical_crs"] = text_or_null(vertical);
  json["vertical_unit"] = text_or_null(frame.vertical_unit);
  const VerticalOutcome& outcome = facts.vertical;
  if (!outcome.transformation.empty())
    json["vertical_transformation"] = {
        {"name", outcome.transformation},
        {"accuracy", outcome.accuracy ? Json(*outcome.accuracy) : Json(nullptr)}};
  json["is_of_points"] = facts.is_of_points || facts.points.has_value();
  if (facts.points) {
    add_point_facts(*facts.points, json, table);
  } else if (facts.is_of_points) {
    table.add({"lattice", fmt::format("{} x {}, of {}", frame.n_columns, frame.n_rows,
                                      facts.type == "points" ? "points" : "a raster with lines")});
  } else {
    const std::int64_t n_samples = std::int64_t{frame.n_columns} * frame.n_rows;
    table.add(
        {"samples", fmt::format("{} x {} = {}, {}", frame.n_columns, frame.n_rows,
                                format_count(static_cast<std::uint64_t>(n_samples)), facts.type)});
  }
  if (!facts.points || facts.n_missing > 0) table.add({"missing", format_count(facts.n_missing)});
  table.add({"CRS", frame.crs.empty() ? "not known" : crs_name(frame.crs)});
  table.add({"vertical CRS", vertical.empty() ? "not known" : vertical});
  table.add({"vertical unit", frame.vertical_unit.empty() ? "not known" : frame.vertical_unit});
  if (!outcome.transformation.empty())
    table.add(
        {"transformed",
         fmt::format("{}{}", outcome.transformation,
                     outcome.accuracy ? fmt::format(", accuracy {} m", *outcome.accuracy) : "")});
}

}  // namespace lode::cli
