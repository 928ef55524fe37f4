#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/models/terrain/insertions/history_file.h"

namespace lode::insertions {

/// The nodes of a file's first bands as they lie in it, band by band and page by page, in a page
/// along a curve, so that near ones are near in memory; and what is kept of the triangles that they
/// make.
struct NodeColumns {
  std::uint32_t n_base = 0;                    ///< Vertices of the base.
  std::vector<delaunay::LatticePoint> points;  ///< Of the base's vertices, then of the nodes.
  std::vector<double> heights;                 ///< Of these.
  std::vector<std::uint32_t> times;            ///< By node,
  std::vector<std::uint32_t> n_made;           ///< and how many triangles it makes,
  std::vector<std::uint32_t> first_error;      ///< where their errors begin,
  std::vector<std::uint8_t> begins_later;      ///< and PageNodes::begins_later.
  std::vector<float> errors;

  [[nodiscard]] std::uint32_t n_nodes() const { return static_cast<std::uint32_t>(times.size()); }
  [[nodiscard]] delaunay::LatticePoint point_of(std::uint32_t node) const {
    return points[n_base + node];
  }

  /// The nodes, one by one as time goes on; times are those from 0 on.
  [[nodiscard]] std::vector<std::uint32_t> in_time() const {
    std::vector<std::uint32_t> nodes(n_nodes());
    for (std::uint32_t node = 0; node < n_nodes(); ++node) nodes[times[node]] = node;
    return nodes;
  }

  /// That the node lies where none of its time can.
  [[nodiscard]] Error not_insertable(const HistoryFile& file, std::uint32_t node) const;

  /// Fails, naming the file, where a page is not as it has to be, and when cancelled.
  [[nodiscard]] static Result<NodeColumns> read(const HistoryFile& file, std::size_t n_bands,
                                                Progress& progress);
};

}  // namespace lode::insertions
