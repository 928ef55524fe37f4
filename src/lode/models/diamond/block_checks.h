#pragma once

// What is asked of blocks beside their checksums, whoever reads them.

#include <cmath>
#include <limits>
#include <string>

#include "lode/core/atomic_extremes.h"
#include "lode/core/parallel_fill.h"
#include "lode/models/diamond/summary.h"
#include "lode/store/reader.h"

namespace lode::diamond {

/// Compares a number of the metadata with the same one found from the blocks.
template <typename T>
[[nodiscard]] Result<void> check_said(const store::Reader& reader, const std::string& name, T said,
                                      T found) {
  if (said == found) return {};
  return fail("{}: {}: expected {}, as the metadata says, its blocks give {}", reader.path(), name,
              said, found);
}

/// Compares what the metadata say of the samples with what they are.
[[nodiscard]] inline Result<void> check_stats(const store::Reader& reader, const FieldStats& said,
                                              const FieldStats& found) {
  LODE_CHECK(check_said(reader, "smallest sample", said.min, found.min));
  LODE_CHECK(check_said(reader, "largest sample", said.max, found.max));
  LODE_CHECK(check_said(reader, "number of holes", said.n_holes, found.n_holes));
  return check_said(reader, "number of removed cells", said.n_removed_cells, found.n_removed_cells);
}

/// Compares the largest errors; both have one a level.
[[nodiscard]] inline Result<void> check_errors(const store::Reader& reader, const Summary& said,
                                               const Summary& found) {
  LODE_CHECK(check_said(reader, "base error", said.base_error, found.base_error));
  for (std::size_t level = 0; level < found.max_errors.size(); ++level)
    LODE_CHECK(check_said(reader, fmt::format("largest error of level {}", level),
                          said.max_errors[level], found.max_errors[level]));
  return {};
}

/// Fails unless a level's nodes have errors and ranges; empty ranges become what memory has.
[[nodiscard]] inline Result<void> check_nodes(NodeLevel& nodes, const store::Reader& reader,
                                              Threads threads) {
  const std::size_t n = nodes.low.size();
  std::size_t first_bad = n;
  for_each_piece(n, threads, [&](std::size_t first, std::size_t end) {
    for (std::size_t i = first; i < end; ++i) {
      if (nodes.error[i] > kInfiniteError || std::isnan(nodes.low[i]) || std::isnan(nodes.high[i]))
        lower_to(first_bad, i);
      if (!(nodes.low[i] > nodes.high[i])) continue;
      nodes.low[i] = std::numeric_limits<float>::infinity();
      nodes.high[i] = -std::numeric_limits<float>::infinity();
    }
  });
  if (first_bad == n) return {};
  return fail("{}: attributes: expected an error and a range, got a code {} and {} to {}",
              reader.path(), nodes.error[first_bad], nodes.low[first_bad], nodes.high[first_bad]);
}

/// A level's largest nested error.
[[nodiscard]] inline double largest_error(const NodeLevel& nodes) {
  ErrorCode largest = 0;  // codes are ordered as the errors are
  for (const ErrorCode error : nodes.error) largest = std::max(largest, error);
  return static_cast<double>(decode_error(largest));
}

}  // namespace lode::diamond
