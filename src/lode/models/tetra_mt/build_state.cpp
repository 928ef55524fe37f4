#include "lode/models/tetra_mt/build_state.h"

#include <algorithm>

namespace lode::tetra_mt {

BuildState::BuildState(const TetraMesh& reference)
    : mesh(reference),
      outside(static_cast<std::uint32_t>(reference.positions.size())),
      tetrahedra(reference.tetrahedra),
      next_sample(outside, kNone),
      n_fields(reference.fields.size()),
      values(n_fields * outside),
      errors(values.size(), 0),
      keys(outside, 0),
      is_there(outside, 1),
      is_locked(outside, 0),
      n_cells(tetrahedra.size()) {
  for (std::size_t f = 0; f < n_fields; ++f) {
    const std::vector<double>& from = reference.fields[f].values;
    const auto [low, high] = std::ranges::minmax_element(from);
    const double range = from.empty() ? 0 : *high - *low;
    const double scale = range > 0 ? 1 / range : 0;
    for (std::size_t v = 0; v < outside; ++v)
      values[v * n_fields + f] = static_cast<float>((from[v] - *low) * scale);
  }
}

}  // namespace lode::tetra_mt
