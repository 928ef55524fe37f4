#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "lode/models/diamond/error_code.h"

namespace lode::diamond {

/// Attributes of consecutive points of a grid, as in NodeLevel.
struct AttributeRow {
  const ErrorCode* error;
  const float* low;
  const float* high;
};

/// The same of nodes that are to be completed.
struct NodeRow {
  ErrorCode* error;
  float* low;
  float* high;
};

/// Where the children of the node at x lie in the rows that a row takes from.
enum class ChildPlaces : std::uint8_t {
  at_x,          ///< Rows of the same level, at x.
  at_and_round,  ///< The same; and in the own row at x - 1 and x + 1.
  halves,        ///< Rows of the next finer level, at 2 x - 1 and 2 x + 1.
  cubes,         ///< Rows of level 0, an entry a cube of side 2: at x - 1 and x.
};

struct ChildRows {
  ChildPlaces places = ChildPlaces::at_x;
  std::array<AttributeRow, 4> rows{};
  std::size_t n_rows = 0;
  std::size_t n = 0;  ///< Points of each; where children are missing, so are they.

  void add(const AttributeRow& row) { rows[n_rows++] = row; }
};

/// Completes those of the n nodes of a row whose x is even (parity 0) or odd (1): the error becomes
/// the largest of its own and its children's, the range that of the children alone; without a
/// child (inf, -inf). The others stay as they are.
void join_children(const ChildRows& children, std::size_t n, std::size_t parity,
                   const NodeRow& nodes);

}  // namespace lode::diamond
