#pragma once

#include <string>

#include "input.h"
#include "text.h"

namespace lode::cli {

/// A mesh of cells and the file that its hierarchy goes to.
struct TetraBuildJob {
  std::string input;
  std::string output;
  std::string base_cells;          ///< As given; empty: a hundredth.
  std::string boundary_tolerance;  ///< The same; empty: 0.
  std::string memory_limit;        ///< The same; empty: what the machine has.
  bool is_everywhere = false;      ///< Where errors hold.
  bool has_space_errors = false;   ///< Besides.
  bool is_lean = false;            ///< Without what queries do without.
  bool keeps_extrema = false;      ///< Of the reference.
  std::string at;                  ///< The time, or "file"; empty: none.
  ReadingArguments reading;
};

/// A row for each field, and the first as that of the model.
void add_fields(const TetraInfo& info, Table& table, Json& json);

/// Looks at the arguments alone.
[[nodiscard]] Result<void> check_tetra_build(const TetraBuildJob& job);
/// Builds the hierarchy in memory and writes it.
[[nodiscard]] Result<Outcome> run_tetra_build(const TetraBuildJob& job, Session& session);

/// What a mesh of cells, or the hierarchy of one in a .lode file, has.
[[nodiscard]] Result<Outcome> tetra_info(const std::string& path, const ReadingArguments& reading,
                                         Session& session);

}  // namespace lode::cli
