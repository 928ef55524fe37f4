#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/core/vec.h"

namespace lode::io {

/// Points, and lines of several points each, in space.
struct Network {
  /// A number of each point, then of each line.
  struct Column {
    std::string name;
    bool is_integer = false;     ///< Of 32 bits.
    std::vector<double> values;  ///< NaN where there is none.
  };

  std::vector<Vec3d> places;  ///< Points, then the lines' places, line after line.
  std::size_t n_points = 0;
  std::vector<std::uint64_t> line_ends;  ///< By line: where the next one's places begin.
  std::vector<Column> columns;
};

/// VTK XML PolyData with raw appended arrays: vertices and polylines, with the columns as cell
/// data, and the third coordinate as point data "height". Whole or not at all; fails when
/// cancelled. `comment`: one line for the file's head.
[[nodiscard]] Result<void> write_network_vtp(const std::string& path, const Network& network,
                                             const std::string& comment, Progress& progress);

}  // namespace lode::io
