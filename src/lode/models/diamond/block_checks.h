#pragma once

// What is asked of blocks beside their checksums, whoever reads them.

#include <cmath>
#include <limits>
#include <string>

#include "lode/models/diamond/model.h"
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

/// Fails unless a level's nodes have errors and ranges; empty ranges become what memory has.
[[nodiscard]] inline Result<void> check_nodes(NodeLevel& nodes, const store::Reader& reader) {
  for (std::size_t i = 0; i < nodes.low.size(); ++i) {
    if (nodes.error[i] > kInfiniteError || std::isnan(nodes.low[i]) || std::isnan(nodes.high[i]))
      return fail("{}: attributes: expected an error and a range, got a code {} and {} to {}",
                  reader.path(), nodes.error[i], nodes.low[i], nodes.high[i]);
    if (nodes.low[i] > nodes.high[i]) {
      nodes.low[i] = std::numeric_limits<float>::infinity();
      nodes.high[i] = -std::numeric_limits<float>::infinity();
    }
  }
  return {};
}

/// A level's largest nested error.
[[nodiscard]] inline double largest_error(const NodeLevel& nodes) {
  ErrorCode largest = 0;  // codes are ordered as the errors are
  for (const ErrorCode error : nodes.error) largest = std::max(largest, error);
  return static_cast<double>(decode_error(largest));
}

}  // namespace lode::diamond
