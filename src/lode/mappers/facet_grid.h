#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "lode/core/vec.h"

namespace lode {

/// A triangle of a surface, and where it comes from: its user's business.
struct Facet {
  std::array<Vec3f, 3> corner;
  std::uint64_t place = 0;
};

[[nodiscard]] inline std::array<Vec3d, 3> corners_of(const Facet& facet) {
  std::array<Vec3d, 3> corners;
  for (std::size_t i = 0; i < 3; ++i)
    corners[i] = {{static_cast<double>(facet.corner[i][0]), static_cast<double>(facet.corner[i][1]),
                   static_cast<double>(facet.corner[i][2])}};
  return corners;
}

/// Facets by the cells of a grid that they, or boxes round their pieces, touch: to find the nearest
/// one to a point. Cells are longer along axes along which facets are; facets much larger than a
/// cell cost as many entries as cells that they pass.
class FacetGrid {
 public:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  /// A facet, and its distance from a point: exact, or where it is near enough that of its middle.
  struct Nearest {
    std::uint32_t facet = kNone;
    double squared_distance = std::numeric_limits<double>::infinity();
  };

  /// `facets` must outlive it; `reach`: up to about how far from points facets will be looked for.
  FacetGrid(std::span<const Facet> facets, double reach);

  [[nodiscard]] std::span<const Facet> facets() const { return facets_; }
  /// What it takes, and what a search in one cell does.
  [[nodiscard]] std::size_t n_entries() const { return entries_.size(); }
  [[nodiscard]] std::size_t n_most_in_cell() const;
  /// How to look for a facet near a point.
  struct Search {
    double limit = 0;            ///< None farther is found.
    double enough = 0;           ///< The first as near as this will do.
    std::uint32_t hint = kNone;  ///< One to begin with.
  };
  /// The nearest facet within the limit, or one that is near enough: the same each time.
  [[nodiscard]] Nearest find(const Vec3d& p, const Search& search) const;

 private:
  using Cell = std::array<std::int32_t, 3>;

  void choose_cells(double reach);
  [[nodiscard]] std::int32_t coordinate(double x, std::size_t axis) const;
  [[nodiscard]] std::size_t number(const Cell& c) const {
    return (static_cast<std::size_t>(c[2]) * static_cast<std::size_t>(dims_[1]) +
            static_cast<std::size_t>(c[1])) *
               static_cast<std::size_t>(dims_[0]) +
           static_cast<std::size_t>(c[0]);
  }
  /// Of a box round a piece, which is cut in four as long as that is large: whether it was not.
  template <typename Visit>
  bool for_each_cell(const std::array<Vec3d, 3>& piece, const Visit& visit) const;
  /// The squared distance from p to a cell.
  [[nodiscard]] double squared_distance(const Vec3d& p, const Cell& c) const;
  /// Whether what is found there is within `enough`, squared.
  bool look_in(const Cell& c, const Vec3d& p, double enough, Nearest& nearest) const;

  std::span<const Facet> facets_;
  Vec3d lower_;
  Vec3d edge_{{1, 1, 1}};  ///< Of a cell.
  Cell dims_{1, 1, 1};
  std::vector<std::uint32_t> first_;    ///< By cell, of entries_.
  std::vector<std::uint32_t> entries_;  ///< Numbers of facets.
  std::vector<float> radii_;            ///< By facet, round its middle; rounded up.
};

}  // namespace lode
