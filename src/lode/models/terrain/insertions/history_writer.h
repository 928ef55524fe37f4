#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/height_grid.h"
#include "lode/core/result.h"
#include "lode/delaunay/greedy_insertion.h"
#include "lode/delaunay/grid_domain.h"
#include "lode/models/terrain/insertions/history.h"
#include "lode/models/terrain/insertions/recorder.h"

namespace lode::insertions {

/// A history of a grid's samples before any. Fails on heights that check_heights() refuses.
[[nodiscard]] Result<History> begin_history(const HeightGrid& grid,
                                            const delaunay::GridDomain& domain, Model model);

/// Writes down what insertions do, and what they know of errors.
template <typename Nodes>
class HistoryWriter final : public delaunay::MeshObserver<Nodes> {
 public:
  /// The history has no vertices yet, and outlives it.
  explicit HistoryWriter(History& history) : history_(history), recorder_(history) {}

  void on_start(const delaunay::NodeMesh<Nodes>& mesh, std::span<const float> errors) override;
  void on_insertion(const delaunay::NodeMesh<Nodes>& mesh, std::uint32_t node,
                    std::span<const std::uint32_t> slots, std::size_t n_removed,
                    std::span<const float> errors) override;
  /// After all; height(node) by its number in the mesh.
  template <typename Height>
  void finish(const Height& height) {
    recorder_.finish();
    history_.heights.reserve(nodes_.size());
    for (const std::uint32_t node : nodes_) history_.heights.push_back(height(node));
  }
  /// Of the history's vertices, as the mesh numbers them.
  [[nodiscard]] std::span<const std::uint32_t> nodes() const { return nodes_; }

 private:
  History& history_;
  Recorder recorder_;
  std::vector<std::uint32_t> nodes_;
};

}  // namespace lode::insertions
