#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>

#include "tetra_input.h"
#include "text.h"

namespace lode::cli {

void add_warp_options(CLI::App& app, WarpArguments& arguments);
/// Refuses what no deformed answer has, whatever the files hold.
[[nodiscard]] Result<void> check_warp(const QueryArguments& query);

/// Also reads the vector.
[[nodiscard]] ReadingArguments with_warp(ReadingArguments reading, const WarpArguments& arguments);

/// What deforming did.
struct Warped {
  std::string field;
  double scale = 1;
  double error = 0;              ///< Stated by cells: how far it may be off itself, world units.
  std::uint64_t n_inverted = 0;  ///< Cells that were turned round; of a mesh.

  /// "U, 2 times; itself off by up to 0.1 at samples"
  [[nodiscard]] std::string text() const;
};

/// Deforms, where that is wanted, and leaves out again what was read for it alone. `largest_error`:
/// stated of the measured field. Fails where a vertex is beyond what coordinates hold.
[[nodiscard]] Result<std::optional<Warped>> apply_warp(const WarpArguments& arguments,
                                                       const TetraInput& input,
                                                       double largest_error, Threads threads,
                                                       SimplexMesh& mesh);
/// Of an isosurface the measured field is what the surface is at: of one isovalue, that.
[[nodiscard]] Result<std::optional<Warped>> apply_warp(const WarpArguments& arguments,
                                                       const TetraInput& input,
                                                       double largest_error,
                                                       std::span<const double> isovalues,
                                                       Surface& surface);

/// Says so of an answer; nothing where it is as it was.
void add_warp(const std::optional<Warped>& warped, Table& table, Json& json);
/// For a file's comment: "; deformed by ...".
[[nodiscard]] std::string warp_comment(const std::optional<Warped>& warped);

/// Behind where a mesh is that is deformed only then.
inline constexpr const char* kBeforeWarp = ", before --warp";

/// Empty where none was.
[[nodiscard]] std::string inverted_warning(std::uint64_t n_inverted);
void warn_of_inverted(Session& session, std::uint64_t n_inverted);

}  // namespace lode::cli
