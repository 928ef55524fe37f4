#include "lode/models/tetra_mt/build_state.h"

#include <algorithm>

#include "lode/models/tetra_mt/interfaces.h"

namespace lode::tetra_mt {

BuildState::BuildState(const TetraMesh& reference)
    : mesh(reference),
      outside(static_cast<std::uint32_t>(reference.positions.size())),
      tetrahedra(reference.tetrahedra),
      next_sample(outside, kNone),
      n_fields(reference.fields.size()),
      errors(n_fields * outside, 0),
      keys(outside, 0),
      is_there(outside, 1),
      is_locked(outside, 0),
      n_cells(tetrahedra.size()) {
  for (const MeshField& field : reference.fields) {
    const auto [low, high] = std::ranges::minmax_element(field.values);
    const double range = field.values.empty() ? 0 : *high - *low;
    scales.push_back(range > 0 ? 1 / range : 0);
  }
}

Result<void> BuildState::close(Threads threads) {
  LODE_CHECK(close_boundary(outside, tetrahedra, threads));
  first_sample.assign(tetrahedra.size(), kNone);
  const auto is_other = [&](std::uint32_t region) { return region != mesh.regions.front(); };
  if (!std::ranges::any_of(mesh.regions, is_other)) return {};
  labels = mesh.regions;
  labels.resize(tetrahedra.size(), kOutsideLabel);
  return {};
}

}  // namespace lode::tetra_mt
