#pragma once

#include <cstddef>
#include <vector>

#include "lode/models/diamond/error_code.h"

namespace lode::diamond {

/// Nested attributes of consecutive points of a grid, as in NodeLevel.
struct AttributeRow {
  const ErrorCode* error;
  const float* low;
  const float* high;
};

/// Scratch: such a row to be filled, without a sample and without error where nothing has been
/// joined.
struct AttributeScratch {
  std::vector<ErrorCode> error;
  std::vector<float> low;
  std::vector<float> high;

  void clear(std::size_t n);
  void join(const AttributeRow& from, std::size_t first, std::size_t n);
};

}  // namespace lode::diamond
