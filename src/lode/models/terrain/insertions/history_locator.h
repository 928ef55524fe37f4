#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "lode/delaunay/predicates.h"
#include "lode/delaunay/window.h"
#include "lode/models/terrain/insertions/history.h"
#include "lode/models/terrain/insertions/start_finder.h"

namespace lode::insertions {

/// Finds places in the meshes of all times and sets.
class HistoryLocator {
 public:
  /// The history must outlive it.
  explicit HistoryLocator(const History& history);

  /// A triangle of the nodes' mesh that holds a place (column and row, finite), down the history
  /// from the base.
  [[nodiscard]] std::optional<std::uint32_t> find(const NodeSet& nodes,
                                                  const delaunay::Point& p) const;
  [[nodiscard]] std::uint64_t n_bytes() const { return start_.n_bytes(); }

 private:
  const History* history_;
  StartFinder start_;
};

/// The triangles of the nodes' mesh that meet a window, in the order of their numbers.
[[nodiscard]] std::vector<std::uint32_t> zoom_in(const History& history, const NodeSet& nodes,
                                                 const delaunay::Window& window);

}  // namespace lode::insertions
