#include "lode/api/tetra_cut_errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "lode/locate/cell_locator.h"

namespace lode {
namespace {

/// What one vertex finds: of all cells there the one that is best for the model.
struct VertexFinding {
  bool is_looked_at = false;
  bool is_outside = false;
  bool is_in_range = false;
  bool is_within_stated = false;
  double error = std::numeric_limits<double>::infinity();  ///< The least.
  double certain = error;                                  ///< Likewise, less what rounding may be.
  double stated = 0;                                       ///< The largest.
  double distance = 0;
};

class VertexSearch {
 public:
  VertexSearch(const TetraVertices& vertices, const TetraCells& cells, const CellLocator& locator,
               const std::vector<StatedFacts>& stated, const MovedBoundary* moved)
      : vertices_(vertices),
        cells_(cells),
        locator_(locator),
        stated_(stated),
        moved_(moved),
        reach_(moved != nullptr ? moved->reach : 2 * vertices.boundary_allowance()) {}

  [[nodiscard]] VertexFinding find(std::uint32_t vertex) const {
    VertexFinding finding;
    finding.is_looked_at = true;
    const Vec3d& p = vertices_.positions[vertex];
    locator_.visit_near(p, 0, [&](std::uint32_t cell) { look_inside(vertex, cell, finding); });
    finding.is_outside = !std::isfinite(finding.error);
    if (finding.is_outside) finding.distance = locator_.distance_to_nearest(p);
    const bool is_right = finding.is_within_stated && finding.is_in_range;
    const bool is_beside = moved_ == nullptr
                               ? finding.is_outside
                               : !finding.is_outside && !is_right && moved_->is_near[vertex];
    if (is_beside)
      locator_.visit_near(p, reach_,
                          [&](std::uint32_t cell) { look_beside(vertex, cell, finding); });
    return finding;
  }

 private:
  /// A point so little outside, as a share of the cell's height, may only have been rounded there.
  static constexpr double kSlack = 1e-9;

  void look_inside(std::uint32_t vertex, std::uint32_t cell, VertexFinding& finding) const {
    const CellWeights found = locator_.weights_in(cell, vertices_.positions[vertex]);
    const double slack = kSlack + found.rounding;
    if (!std::isfinite(slack) || found.least() < -slack) return;
    offer(vertex, cell, found.weights, slack, finding);
  }
  void look_beside(std::uint32_t vertex, std::uint32_t cell, VertexFinding& finding) const {
    const Vec3d& p = vertices_.positions[vertex];
    if (locator_.distance_to_faces(cell, p) > reach_) return;
    const CellWeights found = locator_.weights_in(cell, p);
    if (!std::isfinite(found.rounding)) return;
    const double outside = moved_ == nullptr ? std::max(0.0, -found.least()) : 0;
    offer(vertex, cell, found.clamped(), found.rounding + outside, finding);
  }
  /// `slack`: by how much each weight may be off.
  void offer(std::uint32_t vertex, std::uint32_t cell, const std::array<double, 4>& weights,
             double slack, VertexFinding& finding) const {
    const double value = vertices_.values[vertex];
    double there = 0;
    double low = value;
    double high = value;
    for (std::size_t k = 0; k < 4; ++k) {
      const double corner = vertices_.values[cells_.corners[cell][k]];
      // Relative to the vertex's: rounding is that of what differs.
      there += weights[k] * (corner - value);
      low = std::min(low, corner);
      high = std::max(high, corner);
    }
    const double error = std::abs(there);
    const StatedFacts& stated = stated_[cell];
    const double certain = error - 4 * slack * (high - low);
    finding.error = std::min(finding.error, error);
    finding.certain = std::min(finding.certain, certain);
    finding.stated = std::max(finding.stated, stated.error);
    finding.is_within_stated = finding.is_within_stated || certain <= stated.error;
    finding.is_in_range =
        finding.is_in_range || (stated.range.low <= value && value <= stated.range.high);
  }

  const TetraVertices& vertices_;
  const TetraCells& cells_;
  const CellLocator& locator_;
  const std::vector<StatedFacts>& stated_;
  const MovedBoundary* moved_;
  double reach_;
};

void add_finding(const VertexFinding& finding, std::size_t vertex, double allowance,
                 TetraCutErrors& errors) {
  ++errors.n_vertices;
  const bool is_found = std::isfinite(finding.error);
  const bool is_far = finding.is_outside && !(finding.distance <= allowance);
  errors.n_outside += finding.is_outside ? 1 : 0;
  errors.n_far_outside += is_far ? 1 : 0;
  errors.farthest_outside = std::max(errors.farthest_outside, finding.distance);
  errors.n_above_stated += is_found && !finding.is_within_stated ? 1 : 0;
  errors.n_out_of_range += is_found && !finding.is_in_range ? 1 : 0;
  if (is_found) errors.largest = std::max(errors.largest, finding.error);
  if (is_found) errors.largest_certain = std::max(errors.largest_certain, finding.certain);
  errors.largest_stated = std::max(errors.largest_stated, finding.stated);
  if (!errors.first.empty()) return;
  if (is_far)
    errors.first = fmt::format("vertex {} is {:.3g} outside", vertex, finding.distance);
  else if (is_found && !finding.is_within_stated)
    errors.first = fmt::format("vertex {}: |F - F'| {:.6g}, stated {:.6g}", vertex, finding.error,
                               finding.stated);
  else if (is_found && !finding.is_in_range)
    errors.first = fmt::format("vertex {}: its value is not in the range stated", vertex);
}

}  // namespace

void TetraCutErrors::append(const TetraCutErrors& later) {
  n_vertices += later.n_vertices;
  n_above_stated += later.n_above_stated;
  n_out_of_range += later.n_out_of_range;
  n_outside += later.n_outside;
  n_far_outside += later.n_far_outside;
  largest = std::max(largest, later.largest);
  largest_certain = std::max(largest_certain, later.largest_certain);
  largest_stated = std::max(largest_stated, later.largest_stated);
  farthest_outside = std::max(farthest_outside, later.farthest_outside);
  if (first.empty()) first = later.first;
}

MovedBoundary find_moved(const TetraVertices& vertices, const TetraCutShape& reference,
                         double deviation, Threads threads) {
  std::vector<CellLocator::Cell> faces;  // As cells that are flat.
  faces.reserve(reference.outer.size());
  for (const auto& [a, b, c] : reference.outer) faces.push_back({a, b, c, c});
  const CellLocator locator(vertices.positions, faces, threads);
  std::vector<std::uint8_t> is_near(vertices.positions.size());
  parallel_for(is_near.size(), threads, 256, [&](std::size_t v, int) {
    const Vec3d& p = vertices.positions[v];
    bool is = false;
    locator.visit_near(p, deviation, [&](std::uint32_t face) {
      is = is || locator.distance_to_faces(face, p) <= deviation;
    });
    is_near[v] = is ? 1 : 0;
  });
  return {{is_near.begin(), is_near.end()}, 2 * deviation};
}

TetraCutErrors measure_errors(const TetraVertices& vertices, const TetraCells& cells,
                              const MovedBoundary* moved, Threads threads) {
  std::vector<bool> is_there(vertices.positions.size(), false);
  for (const auto& t : cells.corners)
    for (const std::uint32_t v : t) is_there[v] = true;
  const CellLocator locator(vertices.positions, cells.corners, threads);
  const VertexSearch search(vertices, cells, locator, cells.stated, moved);
  std::vector<VertexFinding> findings(vertices.samples.size());
  parallel_for(findings.size(), threads, 256, [&](std::size_t i, int) {
    if (!is_there[vertices.samples[i]]) findings[i] = search.find(vertices.samples[i]);
  });
  TetraCutErrors errors;
  for (const StatedFacts& facts : cells.stated)
    errors.largest_stated = std::max(errors.largest_stated, facts.error);
  for (std::size_t i = 0; i < findings.size(); ++i)
    if (findings[i].is_looked_at)
      add_finding(findings[i], vertices.samples[i], vertices.boundary_allowance(), errors);
  return errors;
}

}  // namespace lode
