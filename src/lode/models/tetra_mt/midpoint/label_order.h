#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/tetra_mesh.h"
#include "lode/models/tetra_mt/live_tetrahedra.h"
#include "lode/models/tetra_mt/midpoint/codes.h"
#include "lode/models/tetra_mt/midpoint/page_table.h"
#include "lode/models/tetra_mt/midpoint/state.h"

namespace lode::tetra_mt::midpoint {

/// Labels of what collapses make, so that what is near in the forest and in space is in one page.
struct LabelOrder {
  std::vector<std::uint32_t> leaves;  ///< By vertex of the mesh: its label.
  std::vector<std::uint32_t> nodes;   ///< By collapse.
  PageTable pages;
  std::vector<PageCounts> counts;  ///< Of the pages.
  /// By page: of how many nodes its levels have, in the order of their places. All beside a node
  /// that its page has, and that were there before it, are of other levels, before its own.
  std::vector<std::vector<std::uint32_t>> levels;
};

/// The order among nodes asks no more of labels than that each is above those of all vertices
/// beside it. So nodes are first sorted into pages: in bands by the order of collapses, each with
/// as many as those of all later ones together, whole trees of the band's part of the forest along
/// a curve in space. Then they are numbered, by epochs: in each the pages one after the other, the
/// last one first, so that a node's epoch is that of what is beside it in its own page and those
/// after it, or the next one of those before it. `codes`: by vertex of the mesh; `live`: all of it.
[[nodiscard]] LabelOrder order_labels(const TetraMesh& mesh, const Scales& scales,
                                      std::vector<PositionCode> codes,
                                      std::span<const EdgeCollapse> collapses, LiveTetrahedra live);

}  // namespace lode::tetra_mt::midpoint
