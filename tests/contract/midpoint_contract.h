#pragma once

// The model of tetrahedral meshes by midpoints as the contract tests see it.

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "lode/models/tetra_mt/midpoint/midpoint_cut.h"
#include "lode/refine/cut.h"
#include "tests/contract/mesh.h"
#include "tests/contract/tetra_contract.h"

namespace lode::test {

class MidpointContract {
 public:
  static constexpr int kDimension = 3;
  /// A node may be needed that has less error than any that needs it.
  static constexpr bool kIsNestedAlongParents = false;

  static MidpointContract make(std::uint32_t seed, Threads threads) {
    Progress progress;
    TetraMesh mesh = TetraContract::holed_cube(seed);
    mesh.fields.erase(mesh.fields.begin());
    const auto collapses =
        tetra_mt::midpoint::collapse_edges(mesh, {.base_cells = 60, .threads = threads}, progress);
    auto hierarchy = tetra_mt::midpoint::make_hierarchy(mesh, *collapses, threads);
    return MidpointContract(std::move(mesh), std::move(*hierarchy));
  }

  [[nodiscard]] tetra_mt::midpoint::MidpointCut refinable() const {
    return tetra_mt::midpoint::MidpointCut(*hierarchy_);
  }

  /// The mesh of the cut that the model stands at.
  [[nodiscard]] Mesh mesh(const tetra_mt::midpoint::MidpointCut& opened, const Cut& /*cut*/) const {
    Mesh mesh{kDimension, {}};
    for (const auto& t : opened.cells()) {
      Mesh::Cell cell;
      for (const std::uint32_t v : t) cell.push_back({opened.position(v).v, opened.value(v)});
      mesh.cells.push_back(cell);
    }
    return mesh;
  }

  [[nodiscard]] bool may_end_at(const std::vector<MeshVertex>& face) const {
    return TetraContract::may_end_at(face);
  }

  /// The vertices of the reference mesh, but for those in the cavity.
  [[nodiscard]] std::vector<MeshVertex> samples() const {
    std::vector<bool> is_used(reference_.positions.size());
    for (const auto& t : reference_.tetrahedra)
      for (const std::uint32_t v : t) is_used[v] = true;
    std::vector<MeshVertex> result;
    for (std::uint32_t v = 0; v < is_used.size(); ++v)
      if (is_used[v]) result.push_back({reference_.positions[v].v, reference_.fields[0].values[v]});
    return result;
  }

 private:
  MidpointContract(TetraMesh reference, tetra_mt::midpoint::Hierarchy hierarchy)
      : reference_(std::move(reference)),
        hierarchy_(std::make_unique<const tetra_mt::midpoint::Hierarchy>(std::move(hierarchy))) {}

  TetraMesh reference_;
  std::unique_ptr<const tetra_mt::midpoint::Hierarchy> hierarchy_;
};

}  // namespace lode::test
