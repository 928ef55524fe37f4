#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "command.h"
#include "text.h"

namespace lode::cli {

/// The extraction options as typed; extract, verify --surface and render share them.
struct ExtractionArguments {
  std::vector<std::string> isovalues;
  std::string max_error;
  std::string style = "tetra";
  std::string style_distance;
  std::string clip;
  std::string normals = "on";
  std::string min_component;
  bool close_border = false;
  std::string keep_topology;  ///< Empty: not asked for.
  bool flip = false;
};

void add_extraction_options(CLI::App& app, ExtractionArguments& arguments);

/// Checks the arguments; an empty list of isovalues is left to the caller. Threads are not set,
/// nor, before set_share(), a max_error that is a share of the field's range.
[[nodiscard]] Result<ExtractOptions> to_extract_options(const ExtractionArguments& arguments);

/// The row of isovalues.
void add_isovalues(const std::vector<double>& isovalues, Table& table);

/// "10 (as asked)" or "1.275 (default: 0.5 % of the value range)".
[[nodiscard]] std::string describe_tolerance(const ExtractOptions& options, double max_error);

/// Of a report with a topology: what was kept, and what that took.
[[nodiscard]] std::string describe_topology(const ExtractReport& report);

/// For a file's comment: ", keep_topology ...", or nothing.
[[nodiscard]] std::string topology_comment(const ExtractReport& report);

/// The keys of isovalues, tolerance, achieved error and counts.
void add_extraction(Json& json, const ExtractOptions& options, const ExtractReport& report);

/// Warns of several isovalues' cubes in one surface.
void warn_of_cubes(Session& session, const ExtractOptions& options);
/// Warns where holes keep a surface open that was to be closed.
void warn_of_open(Session& session, const ExtractReport& report);
/// Warns where a surface is simplified within an error that is less than the persistence.
void warn_of_persistence(Session& session, const ExtractReport& report,
                         const ExtractOptions& options, const DatasetInfo& info);
/// Of cubes, what they are and how far off; of tetrahedra nothing.
void add_style(const ExtractOptions& options, const ExtractReport& report, bool has_holes,
               Table& table);
/// What --min-component dropped, where it is there.
void add_dropped(const ExtractOptions& options, std::uint64_t components, std::uint64_t cells,
                 bool is_lines, Table& table);
/// Warns where coordinates do not tell vertices apart.
void warn_of_coordinates(Session& session, const RegularGrid& grid);
/// Warns of each isovalue without a surface, naming the value range or the options that may have
/// removed it.
void warn_of_unmet(Session& session, const ExtractReport& report, const ExtractOptions& options,
                   const DatasetInfo& info);

}  // namespace lode::cli
