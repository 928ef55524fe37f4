#pragma once

#include <optional>
#include <string>
#include <vector>

#include "input.h"
#include "query_options.h"
#include "tetra_field_names.h"
#include "text.h"

namespace lode::cli {

/// A mesh of cells ready for queries.
struct TetraInput {
  TetraDataset dataset;
  std::optional<TetraReport> report;  ///< What came of a foreign file's cells.
  double seconds = 0;                 ///< Opening, or reading and building.
  TetraFieldUse fields{};             ///< That of --field, and those of --with and of --warp.
  std::optional<WarpPlaces> warp{};   ///< With --warp.

  [[nodiscard]] const TetraFieldInfo& field() const {
    return dataset.describe().fields[fields.measured];
  }
  /// Of the fields' step; none where no field has steps, or it has no time.
  [[nodiscard]] std::optional<double> time() const;
  [[nodiscard]] bool was_built() const { return report.has_value(); }
  /// Cells of the mesh that are folded over others.
  [[nodiscard]] std::uint64_t n_inverted() const;
};

/// "at samples" or "everywhere".
[[nodiscard]] const char* name_of(ErrorPlace place);
[[nodiscard]] const char* name_of(Placement placement);

/// Refuses options of reading that meshes of cells do not have.
[[nodiscard]] Result<void> check_tetra_reading(const ReadingArguments& reading,
                                               const std::string& path);

/// Whether a mesh is named as MEDIT's are, whose fields are in files of their own.
[[nodiscard]] bool is_medit_path(const std::string& path);

/// How a hierarchy is built; without what a file's build alone is told.
[[nodiscard]] Result<TetraBuildOptions> to_build_options(const ReadingArguments& reading,
                                                         Threads threads);

/// How cells become tetrahedra. Fails on what cannot be meant. `is_field`: of the mesh, where that
/// is known.
[[nodiscard]] Result<TetraOptions> to_tetra_options(const ReadingArguments& reading,
                                                    const IsField& is_field = {});

/// The tetrahedra of a foreign file, with the field that is wanted, then those of --with.
[[nodiscard]] Result<TetrahedraOutcome> read_tetra_mesh(const std::string& path,
                                                        const ReadingArguments& reading,
                                                        Session& session);

/// With a number for --max-error-outside where that is a share of the range of values: set_share()
/// has the right one when the field is there.
[[nodiscard]] Result<QueryArguments> without_share(const QueryArguments& arguments);

/// A misspelt preset is told as such; what a file holds is looked at before the work starts. An
/// empty text is none.
[[nodiscard]] Result<void> check_opacity(const std::string& preset_or_path);
/// What is said of an error that a transfer function weighs.
inline constexpr const char* kWhereShown = ", times extinction as a share of the largest";

/// Opens a .lode file, or builds the hierarchy of a foreign file's cells in memory and says so on
/// stderr.
[[nodiscard]] Result<TetraInput> open_tetra_input(const std::string& path,
                                                  const ReadingArguments& reading,
                                                  Session& session);

/// What was made of the file's cells (add_cell_counts()), or how much of a .lode file was read.
void add_reading(const TetraInput& input, Table& table, Json& json);

}  // namespace lode::cli
