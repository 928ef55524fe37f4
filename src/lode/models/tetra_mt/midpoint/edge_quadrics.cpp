// The order of collapses by quadrics of the fields: field_quadric.h.
#include <algorithm>
#include <array>
#include <cmath>

#include "lode/models/tetra_mt/midpoint/edge_collapser.h"

namespace lode::tetra_mt::midpoint {

void EdgeCollapser::find_quadrics(std::size_t n) {
  for (std::uint32_t v = 0; v < n; ++v)
    if (state_.is_locked[global(v)] == 0 && gatherer_.gather(v, star_)) add_quadrics_of_star();
}

/// Of the reference's tetrahedra round the vertex, by their volumes; all in shares of the mesh's
/// size and the fields' ranges.
void EdgeCollapser::add_quadrics_of_star() {
  const std::size_t n = state_.n_fields;
  const double unit = 1 / state_.size;
  const Vec3d centre = unit * (positions_[star_.vertex] - state_.centre);
  for (int i = 0; i < star_.n_triangles; ++i) {
    if (star_.is_on_boundary() && star_.has(i, star_.outside)) continue;
    const auto& t = star_.triangles[static_cast<std::size_t>(i)];
    std::array<Vec3d, 3> at;
    for (std::size_t k = 0; k < 3; ++k)
      at[k] = unit * (positions_[star_.link[t[k]]] - positions_[star_.vertex]);
    const std::array<Vec3d, 3> rows{cross(at[1], at[2]), cross(at[2], at[0]), cross(at[0], at[1])};
    const double volume = dot(rows[0], at[0]);
    for (std::size_t f = 0; f < n; ++f) {
      const double own = state_.value_units[f] * values_[star_.vertex * n + f];
      Vec3d gradient;
      for (std::size_t k = 0; k < 3; ++k) {
        const double value = state_.value_units[f] * values_[star_.link[t[k]] * n + f];
        gradient = gradient + ((value - own) / volume) * rows[k];
      }
      const double slope = dot(gradient, gradient);
      if (!std::isfinite(slope)) continue;  // without volume
      state_.quadrics_of(global(star_.vertex))[f].add_linear(gradient, own - dot(gradient, centre),
                                                             std::abs(volume));
    }
  }
}

/// What both ends' quadrics say of the new vertex, whatever tetrahedra would come: most of these
/// choices are never looked at again.
std::optional<EdgeCollapser::Choice> EdgeCollapser::choice_by_quadrics(int place) {
  if (!look_at_other(place)) return {};
  const auto rule = rule_of(place);
  if (!rule) return {};
  rule_ = *rule;
  find_vertex(place);
  const Vec3d at = (1 / state_.size) * (state_.scales.position(code_) - state_.centre);
  double sum = 0;
  for (std::size_t f = 0; f < state_.n_fields; ++f) {
    const double value = state_.value_units[f] * value_[f].value;
    for (const std::uint32_t end : {star_.vertex, other_.vertex})
      sum += std::max(state_.quadrics_of(global(end))[f].at(at, value), 0.0);
  }
  return Choice{place, static_cast<float>(sum / std::max(1, n_cells_beside(place))),
                is_inner(other_)};
}

}  // namespace lode::tetra_mt::midpoint
