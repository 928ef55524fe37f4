#pragma once

#include <array>
#include <cstdint>

#include "lode/core/uninitialized_array.h"
#include "lode/models/diamond/leaf_rows.h"
#include "lode/models/diamond/model.h"
#include "lode/models/diamond/sample_scale.h"
#include "lode/models/diamond/world_code.h"
#include "lode/models/diamond/world_rows.h"

namespace lode::diamond {

/// What world errors take of a grid's spacing: per axis squared factors that make a difference of
/// values between neighbours a slope in units of value / longest edge, and the longest edges of
/// nodes by their odd axes, as shares of the level's longest.
template <int D, typename C>
struct WorldScale {
  std::array<C, as_size(D)> face;     ///< Neighbours 2h apart,
  std::array<C, as_size(D)> outward;  ///< h apart.
  std::array<C, power(2, D)> longest{};
  double edge = 0;  ///< Longest of level 0's simplices, in world units.

  explicit WorldScale(const Vec<double, as_size(D)>& spacing);
  /// Axes of the lattice are taken as orthogonal.
  template <typename Field>
  explicit WorldScale(const LatticeField<D, Field>& field)
      : WorldScale([&] {
          Vec<double, as_size(D)> spacing;
          for (std::size_t i = 0; i < as_size(D); ++i)
            spacing[i] = field.info.grid.spacing[as_size(field.axes.axis[i])];
          return spacing;
        }()) {}
};

/// For whichever C a field takes.
template <int D>
struct WorldScales {
  WorldScale<D, float> in_float;
  WorldScale<D, double> in_double;

  template <typename Field>
  explicit WorldScales(const LatticeField<D, Field>& field) : in_float(field), in_double(field) {}
};

/// Points of a block's nodes along an edge, and of their samples: one layer more on either side.
template <int D>
inline constexpr std::int32_t kWorldNodes = kBrickSamples<D>;
template <int D>
inline constexpr std::int32_t kWorldSamples = kWorldNodes<D> + 2;

/// Finds the world errors of a block of a level's nodes (see WorldErrorRule), many at a time.
/// Points are held by the parity of their coordinates: what a node is made of then lies as far away
/// for all nodes of a kind, and neighbours in memory are of one kind. Coordinates are relative to
/// the block's lowest node, which is a multiple of 4 of the level's steps.
template <int D, typename C>
class WorldBlock {
 public:
  explicit WorldBlock(const WorldScale<D, C>& scale);

  /// values: kWorldSamples^D, from point -1 on, x fastest, and kRowPadding more. Held in V.
  template <typename V>
  void put_values(const V* values);
  /// Nodes with lower <= p <= upper have no neighbours outside of that.
  void hide_outside(const Index<D>& lower, const Index<D>& upper);
  /// errors: kWorldNodes^D, and kRowPadding more.
  template <typename V>
  void put_errors(const V* errors);

  /// From own errors of all nodes.
  void find_own() { find(false); }
  /// Of level 0 the nested ones: put were the errors at the nodes' own centres only.
  void find_nested() { find(true); }

  /// The shares of the nodes at p and every second point of its row from there on.
  [[nodiscard]] const C* shares_from(const Index<D>& p) const { return worlds_.data() + place(p); }

 private:
  static constexpr std::int32_t kEdge = (kWorldSamples<D> + 1) / 2;  ///< Of a parity's points.
  /// A parity's points, and what vectors may reach beyond.
  static constexpr std::size_t kSize = power(as_size(kEdge), D) + 2 * kRowPadding;

  [[nodiscard]] static std::size_t place(const Index<D>& p) {
    std::size_t parity = 0;
    std::size_t at = 0;
    for (std::size_t i = as_size(D); i-- > 0;) {
      parity = 2 * parity + as_size((p[i] + 1) & 1);
      at = at * as_size(kEdge) + as_size((p[i] + 1) >> 1);
    }
    return parity * kSize + at;
  }
  /// Of a cube from point `first` on.
  template <typename V>
  void put(const V* from, std::int32_t edge, std::int32_t first, UninitializedArray<C>& to);
  void find(bool is_nested);
  [[nodiscard]] WorldKind<C> kind_of(std::uint32_t odd) const;

  WorldScale<D, C> scale_;
  UninitializedArray<C> values_;
  UninitializedArray<C> errors_;
  UninitializedArray<C> worlds_;
};

extern template struct WorldScale<2, float>;
extern template struct WorldScale<3, float>;
extern template struct WorldScale<2, double>;
extern template struct WorldScale<3, double>;
extern template class WorldBlock<2, float>;
extern template class WorldBlock<3, float>;
extern template class WorldBlock<2, double>;
extern template class WorldBlock<3, double>;

}  // namespace lode::diamond
