#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>
#include <vector>

#include "input.h"
#include "lode/api/warp.h"

namespace lode::cli {

/// By which of a mesh's vectors it is deformed, and how much, as typed.
struct WarpArguments {
  std::string field;
  std::string scale;

  [[nodiscard]] bool is_wanted() const { return !field.empty(); }
  [[nodiscard]] bool is_empty() const { return field.empty() && scale.empty(); }
  friend bool operator==(const WarpArguments&, const WarpArguments&) = default;
};

void add_warp_options(CLI::App& app, WarpArguments& arguments);
[[nodiscard]] Result<void> check_warp(const WarpArguments& arguments);

/// Also reads the vector.
[[nodiscard]] ReadingArguments with_warp(ReadingArguments reading, const WarpArguments& arguments);

/// Deforms, where that is wanted, and leaves the vector out again unless --with names it. Of a mesh
/// it returns how many cells were turned round.
[[nodiscard]] Result<std::uint64_t> apply_warp(const WarpArguments& arguments,
                                               const ReadingArguments& reading, Threads threads,
                                               SimplexMesh& mesh);
/// Empty where none was.
[[nodiscard]] std::string inverted_warning(std::uint64_t n_inverted);
void warn_of_inverted(Session& session, std::uint64_t n_inverted);
[[nodiscard]] Result<void> apply_warp(const WarpArguments& arguments,
                                      const ReadingArguments& reading, Surface& surface);

}  // namespace lode::cli
