#pragma once

// The models of vertex splits as the contract tests see them.

#include <cstdint>
#include <memory>
#include <vector>

#include "lode/core/parallel.h"
#include "lode/refine/cut.h"
#include "tests/contract/mesh.h"
#include "tests/contract/split_models.h"

namespace lode::test {

/// What the contracts of both have in common.
class SplitContract {
 public:
  static constexpr int kDimension = 2;
  /// A node may be needed that has less error than any that needs it.
  static constexpr bool kIsNestedAlongParents = false;

  /// The mesh of the cut that the model stands at.
  [[nodiscard]] Mesh mesh(const SplitModel& opened, const Cut& /*cut*/) const {
    Mesh mesh{kDimension, {}};
    for (const Triangle& triangle : opened.mesh().triangles()) {
      Mesh::Cell cell;
      for (const Label v : triangle.corners) cell.push_back(vertex(v));
      mesh.cells.push_back(cell);
    }
    return mesh;
  }

  /// Whether a face may belong to one cell only: it lies on a side of the rectangle.
  [[nodiscard]] bool may_end_at(const std::vector<MeshVertex>& face) const {
    const auto& corner = hierarchy_->vertices[hierarchy_->n_samples - 1].position;
    for (std::size_t i = 0; i < 2; ++i)
      for (const double end : {0.0, corner[i]})
        if (face[0].position[i] == end && face[1].position[i] == end) return true;
    return false;
  }

  /// The vertices of the reference mesh.
  [[nodiscard]] std::vector<MeshVertex> samples() const {
    std::vector<MeshVertex> result;
    for (std::size_t i = 0; i < hierarchy_->n_samples; ++i)
      result.push_back(vertex(static_cast<Label>(i)));
    return result;
  }

 protected:
  explicit SplitContract(std::uint32_t seed)
      : hierarchy_(std::make_unique<SplitHierarchy>(build_split_hierarchy(seed))) {}

  [[nodiscard]] const SplitHierarchy& hierarchy() const { return *hierarchy_; }

 private:
  [[nodiscard]] MeshVertex vertex(Label v) const {
    const SplitVertex& found = hierarchy_->vertices[v];
    return {found.position.v, found.value};
  }

  std::unique_ptr<const SplitHierarchy> hierarchy_;
};

class SplitTableContract : public SplitContract {
 public:
  static SplitTableContract make(std::uint32_t seed, Threads /*threads*/) {
    return SplitTableContract(seed);
  }
  [[nodiscard]] SplitTable refinable() const { return {hierarchy(), *parents_}; }

 private:
  explicit SplitTableContract(std::uint32_t seed)
      : SplitContract(seed), parents_(std::make_unique<ParentTable>(find_parents(hierarchy()))) {}

  std::unique_ptr<const ParentTable> parents_;
};

class SplitLabelsContract : public SplitContract {
 public:
  static SplitLabelsContract make(std::uint32_t seed, Threads /*threads*/) {
    return SplitLabelsContract(seed);
  }
  [[nodiscard]] SplitLabels refinable() const { return SplitLabels(hierarchy()); }

 private:
  using SplitContract::SplitContract;
};

}  // namespace lode::test
