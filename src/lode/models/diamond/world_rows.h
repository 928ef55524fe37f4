#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "lode/models/diamond/world_code.h"

namespace lode::diamond {

/// The nodes of a block that have the same odd axes, and the points near them, as WorldBlock holds
/// them: see there. Rows are read and written up to kRowPadding elements beyond their ends.
template <typename C>
struct WorldKind {
  std::size_t n_axes = 3;
  std::array<std::size_t, 3> axes{};  ///< The odd ones first.
  std::size_t n_odd = 0;
  std::ptrdiff_t begin = 0;  ///< In memory, from the kind's first node to behind its last.
  std::ptrdiff_t end = 0;
  /// From a node's place to that of the point a step away, by (step + 1) in base 3, x fastest.
  std::array<std::ptrdiff_t, 27> near{};
  std::ptrdiff_t origin = 0;  ///< Place of the first of all points with their parity.
  /// By place from there: all bits set where nodes are mirrored along the second odd axis, or the
  /// third, against the first; as wide as C.
  std::array<const void*, 2> is_mirrored{};
  std::array<C, 3> face{};  ///< Of WorldScale, by axis.
  std::array<C, 3> outward{};
  C longest = 0;
};

/// Finds the shares of the nodes of a kind from their own errors. Where is_nested, each error is
/// joined with those of the nodes next to it along its odd axes first, and so is each share.
void find_worlds(const WorldKind<float>& kind, const float* values, float* errors, float* worlds,
                 bool is_nested);
void find_worlds(const WorldKind<double>& kind, const double* values, double* errors,
                 double* worlds, bool is_nested);

/// Where rows one after the other go that are taken apart: those with even numbers, and those with
/// odd ones, each to its values at even places and at odd ones. Both go on `stride` elements behind
/// every other row.
template <typename C>
struct ApartRows {
  std::array<std::array<C*, 2>, 2> to{};
  std::ptrdiff_t stride = 0;
};

/// Takes rows of n values each apart.
void take_apart(const float* from, std::size_t n, std::size_t n_rows, ApartRows<float> rows);
void take_apart(const double* from, std::size_t n, std::size_t n_rows, ApartRows<double> rows);
void take_apart(const std::uint16_t* from, std::size_t n, std::size_t n_rows,
                ApartRows<float> rows);

/// codes[i * step] = the larger of that and shares[i]'s.
void raise_codes(const float* shares, std::size_t n, std::size_t step, WorldCode* codes);
void raise_codes(const double* shares, std::size_t n, std::size_t step, WorldCode* codes);

}  // namespace lode::diamond
