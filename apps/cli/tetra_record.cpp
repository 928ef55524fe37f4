#include "tetra_record.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace lode::cli {
namespace {

struct CountName {
  std::string_view key;
  const char* name;
  std::uint64_t TetraReport::*n;
  std::uint64_t usual = 0;  ///< Not worth a row.
};

constexpr const char* kInverted = "inverted";
constexpr std::array<CountName, 21> kCounts{
    {{"ghost_cells", "ghost cells left out", &TetraReport::n_ghost_cells},
     {"hidden_cells", "hidden cells left out", &TetraReport::n_hidden_cells},
     {"other_regions", "cells of other regions left out", &TetraReport::n_other_regions},
     {"lower_cells", "points, lines and faces left out", &TetraReport::n_lower_cells},
     {"patches", "patches of the boundary", &TetraReport::n_patches},
     {"patch_faces", "faces of patches", &TetraReport::n_patch_cells},
     {"inner_faces", "faces of patches inside left out", &TetraReport::n_inner_faces},
     {"welded_points", "points welded", &TetraReport::n_welded_points},
     {"weld_refusals", "not welded, as values differ", &TetraReport::n_weld_refusals},
     {"unused_points", "unused points left out", &TetraReport::n_unused_points},
     {"coincident_points", "points at another's place", &TetraReport::n_coincident_points},
     {"new_points", "points within polyhedra and quadratic cells", &TetraReport::n_new_points},
     {"quadratic", "quadratic cells, as between their nodes", &TetraReport::n_quadratic},
     {"parted_faces", "faces apart from a neighbour with other nodes",
      &TetraReport::n_parted_faces},
     {"reordered", "quadratic cells put in VTK's order", &TetraReport::n_reordered},
     {"repeating", "tetrahedra with a corner twice left out", &TetraReport::n_repeating},
     {"zero_volume", "cells without volume", &TetraReport::n_zero_volume},
     {"left_handed", "left-handed cells turned", &TetraReport::n_left_handed},
     {"turned_wedges", "wedges turned", &TetraReport::n_turned_wedges},
     {kInverted, "inverted cells", &TetraReport::n_inverted},
     {"components", "components", &TetraReport::n_components, 1}}};

constexpr const char* kNotTaken = "not taken for regions";
constexpr const char* kSkipped = "arrays left out (texts, bits, or as told)";
constexpr const char* kNonfinite = "values that are not finite";
constexpr const char* kAveraged = "cells to points";
constexpr const char* kLinearised = "nodes to corners";
constexpr const char* kMagnitude = "magnitude";
constexpr std::size_t kMostRegions = 10;  // that rows are worth
constexpr std::size_t kMostRegionsTold = 1000;

std::string row_of(const NonfiniteField& field) {
  return fmt::format("{}: {}, the first at point {} from 0", field.name,
                     format_count(field.n_values), field.first);
}
std::string row_of(const AveragedField& field) {
  return fmt::format("{}: {} to {} at cells, {} to {} at points", field.name,
                     format_number(field.cell_min), format_number(field.cell_max),
                     format_number(field.point_min), format_number(field.point_max));
}

std::string row_of(const AveragedField& field, const AveragedRegion& region) {
  return fmt::format(
      "{} in region {}{}: {} to {} at its cells, {} to {} at their points, to which "
      "other regions add",
      field.name, region.id, region.name.empty() ? "" : " (" + region.name + ')',
      format_number(region.cell_min), format_number(region.cell_max),
      format_number(region.point_min), format_number(region.point_max));
}
std::string row_of(const LinearisedField& field) {
  return fmt::format("{}: {} to {} at nodes, {} to {} at the corners that are left", field.name,
                     format_number(field.node_min), format_number(field.node_max),
                     format_number(field.corner_min), format_number(field.corner_max));
}

void add_nonfinite(const TetraReport& report, Json& json) {
  json["nonfinite"] = Json::array();
  std::uint64_t n = 0;
  for (const NonfiniteField& field : report.nonfinite) {
    n += field.n_values;
    json["nonfinite"].push_back(
        {{"field", field.name}, {"values", field.n_values}, {"first_point", field.first}});
  }
  json["nonfinite_values"] = n;
}

/// What means over cells did to the peaks of their fields.
void add_averaged(const TetraReport& report, Json& json) {
  json["averaged"] = Json::array();
  for (const AveragedField& field : report.averaged) {
    Json regions = Json::array();
    for (std::size_t i = 0; i < std::min(field.regions.size(), kMostRegionsTold); ++i) {
      const AveragedRegion& region = field.regions[i];
      regions.push_back({{"region", region.id},
                         {"name", region.name},
                         {"cell_min", region.cell_min},
                         {"cell_max", region.cell_max},
                         {"point_min", region.point_min},
                         {"point_max", region.point_max}});
    }
    json["averaged"].push_back({{"field", field.name},
                                {"cell_min", field.cell_min},
                                {"cell_max", field.cell_max},
                                {"point_min", field.point_min},
                                {"point_max", field.point_max},
                                {"n_mixed_regions", field.regions.size()},
                                {"mixed_regions", std::move(regions)}});
  }
}

void add_linearised(const TetraReport& report, Json& json) {
  json["linearised"] = Json::array();
  for (const LinearisedField& field : report.linearised)
    json["linearised"].push_back({{"field", field.name},
                                  {"node_min", field.node_min},
                                  {"node_max", field.node_max},
                                  {"corner_min", field.corner_min},
                                  {"corner_max", field.corner_max}});
}

void add_averaged_notes(const TetraReport& report, std::vector<TetraBuildRecord::Note>& notes) {
  for (const AveragedField& field : report.averaged) {
    notes.emplace_back(kAveraged, row_of(field));
    const std::size_t n = std::min(field.regions.size(), kMostRegions);
    for (std::size_t i = 0; i < n; ++i)
      notes.emplace_back(kAveraged, row_of(field, field.regions[i]));
    if (n < field.regions.size())
      notes.emplace_back(kAveraged, fmt::format("{}: {} regions more have values of others at "
                                                "their points",
                                                field.name, field.regions.size() - n));
  }
}

std::vector<TetraBuildRecord::Note> notes_of(const TetraReport& report) {
  std::vector<TetraBuildRecord::Note> notes;
  for (const NonfiniteField& field : report.nonfinite)
    notes.emplace_back(kNonfinite, row_of(field));
  for (const std::string& field : report.regions_not_taken) notes.emplace_back(kNotTaken, field);
  if (!report.skipped_arrays.empty())
    notes.emplace_back(kSkipped, fmt::format("{}", fmt::join(report.skipped_arrays, ", ")));
  for (TetraBuildRecord::Note& note : notes_of_fields(report)) notes.push_back(std::move(note));
  return notes;
}

}  // namespace

std::vector<TetraBuildRecord::Note> notes_of_fields(const TetraReport& report) {
  std::vector<TetraBuildRecord::Note> notes;
  add_averaged_notes(report, notes);
  for (const LinearisedField& field : report.linearised)
    notes.emplace_back(kLinearised, row_of(field));
  for (const MagnitudeField& field : report.magnitudes)
    notes.emplace_back(kMagnitude,
                       fmt::format("{}: of {} components", field.name, field.n_components));
  return notes;
}

void add_cell_counts(const TetraReport& report, Table& table, Json& json) {
  for (const CountName& count : kCounts) {
    const std::uint64_t n = report.*count.n;
    json[std::string(count.key)] = n;
    if (n > count.usual) table.add({count.name, format_count(n)});
  }
  add_nonfinite(report, json);
  json["regions_not_taken"] = report.regions_not_taken;
  json["skipped_arrays"] = report.skipped_arrays;
  add_averaged(report, json);
  add_linearised(report, json);
  for (const auto& [name, text] : notes_of(report)) table.add({name, text});
}

void keep_reading(const TetraReport& report, TetraBuildOptions& options) {
  for (const CountName& count : kCounts) options.reading.emplace_back(count.key, report.*count.n);
  options.notes = notes_of(report);
}

void add_kept_reading(const TetraBuildRecord& record, Table& table, Json& json) {
  json["reading"] = Json::object();
  for (const TetraBuildRecord::Count& counted : record.reading) {
    const auto& [key, n] = counted;
    json["reading"][key] = n;
    const auto* const known = std::ranges::find(kCounts, std::string_view(key), &CountName::key);
    const bool is_known = known != kCounts.end();
    if (n > (is_known ? known->usual : 0))
      table.add({is_known ? known->name : key, format_count(n)});
  }
  json["notes"] = Json::array();
  for (const auto& [name, text] : record.notes) {
    json["notes"].push_back({{"about", name}, {"note", text}});
    table.add({name, text});
  }
}

std::uint64_t kept_inverted(const TetraBuildRecord& record) {
  for (const auto& [key, n] : record.reading)
    if (key == kInverted) return n;
  return 0;
}

const char* name_of(CollapseOrder order) {
  switch (order) {
    case CollapseOrder::space_error: return "space";
    case CollapseOrder::quadric: return "quadric";
    case CollapseOrder::squared_error: break;
  }
  return "error";
}

void add_record(const TetraBuildRecord& record, Table& table, Json& json) {
  json["order"] = name_of(record.order);
  table.add({"order", name_of(record.order)});
  json["extrema"] = record.keeps_extrema ? "reference" : "mesh";
  table.add({"extrema that stay",
             record.keeps_extrema ? "of the reference" : "of the mesh as it was by then"});
  json["boundary_tolerance"] = record.boundary_tolerance;
  if (record.boundary_tolerance > 0)
    table.add({"boundary tolerance", format_number(record.boundary_tolerance)});
  json["volume_change"] = record.volume_change;
  json["base_vertices_kept"] = Json::object();
  std::string kept;
  for (const auto& [rule, n_kept] : record.refusals) {
    json["base_vertices_kept"][rule] = n_kept;
    kept += fmt::format("{}{} {}", kept.empty() ? "" : ", ", format_count(n_kept),
                        rule == "limit" ? "that no rule keeps" : rule);
  }
  if (!kept.empty()) table.add({"base vertices kept", kept});
}

}  // namespace lode::cli
