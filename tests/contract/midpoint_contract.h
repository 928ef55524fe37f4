#pragma once

// The model of tetrahedral meshes by midpoints as the contract tests see it.

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "lode/models/tetra_mt/midpoint/midpoint_cut.h"
#include "lode/models/tetra_mt/midpoint/persist.h"
#include "lode/refine/cut.h"
#include "lode/refine/engine.h"
#include "tests/contract/mesh.h"
#include "tests/contract/tetra_contract.h"

namespace lode::test {

/// `kFields`: it is refined by the last of so many.
template <std::size_t kFields>
class MidpointContract {
 public:
  static constexpr int kDimension = 3;
  /// A node may be needed that has less error than any that needs it.
  static constexpr bool kIsNestedAlongParents = false;

  static MidpointContract make(std::uint32_t seed, Threads threads) {
    Progress progress;
    TetraMesh mesh = TetraContract::holed_cube(seed);
    mesh.fields.erase(mesh.fields.begin(), mesh.fields.end() - kFields);
    const auto collapses =
        tetra_mt::midpoint::collapse_edges(mesh, {.base_cells = 60, .threads = threads}, progress);
    auto hierarchy = tetra_mt::midpoint::make_hierarchy(mesh, *collapses, threads);
    Forest forest(*hierarchy);
    return {std::make_shared<const Hierarchy>(std::move(*hierarchy)), std::move(forest)};
  }

  Result<void> save(const std::string& path) const {
    Progress progress;
    LODE_CHECK(tetra_mt::midpoint::save(*hierarchy_, path, {2}, progress));
    return {};
  }
  /// With all pages, so that whatever is wrong with the file is found here.
  static Result<MidpointContract> open(const std::string& path) {
    LODE_TRY(auto opened, tetra_mt::midpoint::open(path));
    static_cast<void>(opened.forest.root_word(0, kFields - 1));
    for (std::uint32_t node = 0; node < opened.forest.head().n_nodes(); ++node)
      static_cast<void>(opened.forest.split(node, kFields - 1));
    LODE_CHECK(opened.forest.check());
    return MidpointContract({}, std::move(opened.forest));
  }

  [[nodiscard]] tetra_mt::midpoint::MidpointCut refinable() const {
    return tetra_mt::midpoint::MidpointCut(*forest_, kFields - 1);
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
    auto opened = refinable();
    Engine<tetra_mt::midpoint::MidpointCut> engine(opened);
    engine.set_query(Demand([](const NodeFacts&) { return 1.0; }));
    engine.finish();
    std::vector<bool> is_used(forest_->head().n_vertices);
    for (const auto& t : opened.cells())
      for (const std::uint32_t v : t) is_used[v] = true;
    std::vector<MeshVertex> result;
    for (std::uint32_t v = 0; v < is_used.size(); ++v)
      if (is_used[v]) result.push_back({opened.position(v).v, opened.value(v)});
    return result;
  }

 private:
  using Forest = tetra_mt::midpoint::Forest;
  using Hierarchy = tetra_mt::midpoint::Hierarchy;

  MidpointContract(std::shared_ptr<const Hierarchy> hierarchy, Forest forest)
      : hierarchy_(std::move(hierarchy)),
        forest_(std::make_unique<const Forest>(std::move(forest))) {}

  std::shared_ptr<const Hierarchy> hierarchy_;  ///< None of a file's.
  std::unique_ptr<const Forest> forest_;
};

}  // namespace lode::test
