#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace lode::io {

/// What VTK says of a type of cell.
struct CellKind {
  std::string_view name;
  int dimension = 0;
  std::size_t n_corners = 0;  ///< 0: any number.
};

/// Nothing for a number that VTK has not given to any type.
[[nodiscard]] std::optional<CellKind> cell_kind(std::uint8_t type);

/// Whether a type is known and has a volume.
[[nodiscard]] bool is_solid(std::uint8_t type);

}  // namespace lode::io
