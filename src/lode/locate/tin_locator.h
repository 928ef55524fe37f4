#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "lode/delaunay/predicates.h"
#include "lode/delaunay/tin.h"

namespace lode {

/// Finds the triangle of a TIN that holds a place, exactly: squares of a power of two of columns
/// and rows know the triangles that reach into them; from the first of them it is a walk to the
/// place, which cannot turn in circles where inner edges are locally Delaunay (L. De Floriani, B.
/// Falcidieno, G. Nagy, C. Pienovi, "On sorting triangles in a Delaunay tessellation",
/// Algorithmica 6, 1991). Where the outline stops the walk, or it gets long, all triangles of the
/// square are tried.
/// Const members are safe from many threads. O(n) to make usually, about 16 bytes a triangle.
class TinLocator {
 public:
  /// The TIN has twins, and outlives it.
  explicit TinLocator(const delaunay::Tin& tin);

  /// A triangle, with its edges, that p (column and row, finite) lies in: of several the
  /// first, so that a TIN of some triangles of another, in their order, has the same. None outside
  /// the domain.
  [[nodiscard]] std::optional<std::uint32_t> find(const delaunay::Point& p) const;

  /// All of them, in their order. O(those of p's square).
  [[nodiscard]] std::vector<std::uint32_t> find_all(const delaunay::Point& p) const;

  [[nodiscard]] const delaunay::Tin& tin() const { return tin_; }
  /// Whether the closed triangle holds p, exactly.
  [[nodiscard]] bool holds(std::uint32_t triangle, const delaunay::Point& p) const;
  /// A number for each square, so that what is near in places can be near in time. Of places in
  /// the rectangle of the TIN only.
  [[nodiscard]] std::uint32_t square_of(const delaunay::Point& p) const;
  [[nodiscard]] bool is_in_rectangle(const delaunay::Point& p) const;
  [[nodiscard]] std::uint32_t n_squares() const {
    return static_cast<std::uint32_t>(n_columns_) * static_cast<std::uint32_t>(n_rows_);
  }

 private:
  template <typename Visit>
  void visit_squares(std::uint32_t triangle, const Visit& visit) const;
  void choose_size();
  void fill_squares();
  [[nodiscard]] bool is_on_edge(std::uint32_t triangle, const delaunay::Point& p) const;
  /// A square's triangles are in their order.
  [[nodiscard]] std::optional<std::uint32_t> first_with(std::span<const std::uint32_t> near,
                                                        const delaunay::Point& p) const;
  [[nodiscard]] std::span<const std::uint32_t> triangles_in(std::uint32_t square) const;

  const delaunay::Tin& tin_;
  delaunay::LatticePoint lower_{};  ///< Of all vertices.
  delaunay::LatticePoint upper_{};
  int bits_ = 0;  ///< Squares are 2^bits columns wide.
  std::int32_t n_columns_ = 1;
  std::int32_t n_rows_ = 1;
  std::vector<std::uint64_t> first_;    ///< Per square, and one more: where its list begins.
  std::vector<std::uint32_t> entries_;  ///< Triangles.
};

}  // namespace lode
