#pragma once

#include <CLI/CLI.hpp>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "lode/api/dataset.h"

namespace lode::cli {

/// Kinds of data: each has options that the others refuse.
enum class DataKind : std::uint8_t { volume, mesh, terrain };

inline constexpr std::array<const char*, 3> kDataKinds{"volume", "mesh", "terrain"};

/// What commands of several kinds end their help with.
struct HelpFooter {
  struct Part {
    const char* text;      ///< Paragraphs, each of which ends a line; may be empty.
    const char* examples;  ///< A line each.
  };
  std::array<Part, kDataKinds.size()> parts;  ///< As kDataKinds.

  /// All of it, or of one kind.
  [[nodiscard]] std::string text(std::string_view command, std::optional<DataKind> kind) const;
};

[[nodiscard]] std::optional<DataKind> find_data_kind(std::string_view name);

/// What the command reads first holds, if that was named and is there; of what cannot be read,
/// volume.
[[nodiscard]] std::optional<DataKind> kind_of_input(const CLI::App& app);

/// Takes options that a kind does not have out of a command's help.
void show_only(DataKind kind, CLI::App& app);

/// Refuses options that what the command reads first does not have.
[[nodiscard]] Result<void> check_options(const CLI::App& app);

}  // namespace lode::cli
