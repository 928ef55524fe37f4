#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "command.h"
#include "extraction_options.h"
#include "lode/api/mesh_extraction.h"

namespace lode::cli {

/// The options of meshes and sections as typed.
struct QueryArguments {
  bool is_mesh = false;
  std::string section;
  std::vector<std::string> field_ranges;
  std::vector<std::string> boxes;
  std::vector<std::string> balls;
  std::string max_error_outside;
  std::string max_cells;

  /// Whether the answer is a mesh or a section, and no surface.
  [[nodiscard]] bool is_wanted() const { return is_mesh || !section.empty(); }
};

void add_query_options(CLI::App& app, QueryArguments& arguments);

/// Refuses options that only meshes and sections have, where neither is wanted.
[[nodiscard]] Result<void> check_unused(const QueryArguments& arguments);

[[nodiscard]] Result<MeshOptions> to_mesh_options(const QueryArguments& arguments,
                                                  const ExtractionArguments& extraction);
[[nodiscard]] Result<SectionOptions> to_section_options(const QueryArguments& arguments,
                                                        const ExtractionArguments& extraction);

}  // namespace lode::cli
