#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "lode/models/diamond/error_code.h"

namespace lode::diamond {

/// Rows of attributes as they are stored, several at once.

/// codes[i] = that of errors[i], rounded up; 0 where there is none (errors[i] < 0).
void encode_errors(std::span<const float> errors, ErrorCode* codes);
/// to[i] = the larger of that and codes[i].
void raise_errors(const ErrorCode* codes, std::size_t n, ErrorCode* to);

/// The ends of the n ranges at i · stride (1 or 2) of a row as integers, which hold those that are
/// finite. Empty ranges (low > high) get the type's largest as their low, its lowest as their high;
/// infinite ends are the type's.
template <typename R>
void encode_lows(const float* low, const float* high, std::size_t n, std::size_t stride, R* out);
template <typename R>
void encode_highs(const float* low, const float* high, std::size_t n, std::size_t stride, R* out);

/// Attributes of level 0's cubes, whose centres lie at every other point of a row: of the points
/// from the first cube's lower border on.
template <typename V>
struct LeafPoints {
  const V* error;  ///< 2 n + 1 of them, the largest over each point's column.
  const V* low;    ///< Of the node at each point; only those at odd places count.
  const V* high;
  /// What a V stands for: errors v · step, samples first + v · step, exactly.
  float first;
  float step;
};

/// Stores n of them. Rows are read up to 32 elements beyond their ends.
void encode_leaf_row(const LeafPoints<std::uint16_t>& from, std::size_t n, ErrorCode* error,
                     float* low, float* high);
void encode_leaf_row(const LeafPoints<float>& from, std::size_t n, ErrorCode* error, float* low,
                     float* high);

}  // namespace lode::diamond
