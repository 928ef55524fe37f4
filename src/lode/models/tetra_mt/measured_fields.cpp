#include "lode/models/tetra_mt/measured_fields.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "lode/models/tetra_mt/fan_distance.h"
#include "lode/models/tetra_mt/held_samples.h"
#include "lode/models/tetra_mt/live_tetrahedra.h"
#include "lode/models/tetra_mt/mesh_check.h"
#include "lode/models/tetra_mt/region_match.h"
#include "lode/models/tetra_mt/tetra_cut.h"
#include "lode/refine/engine.h"
#include "lode/refine/focus.h"

namespace lode::tetra_mt {
namespace {

std::vector<Tetrahedron> in_order(std::span<const Tetrahedron> tetrahedra) {
  std::vector<Tetrahedron> sorted(tetrahedra.begin(), tetrahedra.end());
  for (Tetrahedron& t : sorted) std::ranges::sort(t);
  std::ranges::sort(sorted);
  return sorted;
}

/// Nodes as they may be undone: each after all that depend on it.
Result<std::vector<std::uint32_t>> order_of_collapses(const PackedHierarchy& hierarchy) {
  const HierarchyHead& head = hierarchy.head();
  const std::uint32_t n_nodes = head.shape.n_nodes;
  std::vector<std::uint32_t> n_waiting(n_nodes, 0);  // for parents
  for (std::uint32_t node = 0; node < n_nodes; ++node)
    n_waiting[node] = hierarchy.links(node).n_parents();
  std::vector<std::uint32_t> order;
  for (std::uint32_t node = 0; node < n_nodes; ++node)
    if (n_waiting[node] == 0) order.push_back(node);
  for (std::size_t at = 0; at < order.size(); ++at) {
    NodePage::Links links = hierarchy.links(order[at]);
    for (std::uint32_t k = links.n_children(); k > 0; --k) {
      const std::uint32_t child = links.next_node();
      if (child < n_nodes && n_waiting[child] > 0 && --n_waiting[child] == 0)
        order.push_back(child);
    }
  }
  LODE_CHECK(hierarchy.check());
  if (order.size() != n_nodes) return fail("expected nodes that depend on each other in no circle");
  std::ranges::reverse(order);
  return order;
}

/// How a tetrahedron covers a point: shares of its corners, the kept one's first.
struct Covering {
  std::uint32_t slot = kNone;
  std::array<double, 4> shares{};
  double least = -std::numeric_limits<double>::infinity();
  double rounding = 0;  ///< What a share may be off.
};

Covering cover(const TetraMesh& mesh, const Tetrahedron& corners, std::uint32_t kept,
               const Vec3d& p) {
  const auto place = static_cast<std::size_t>(std::ranges::find(corners, kept) - corners.begin());
  const auto other = others(corners, place);
  const Vec3d& origin = mesh.positions[kept];
  const Vec3d a = mesh.positions[other[0]] - origin;
  const Vec3d b = mesh.positions[other[1]] - origin;
  const Vec3d c = mesh.positions[other[2]] - origin;
  const Vec3d d = p - origin;
  const Vec3d bc = cross(b, c);
  const double volume = dot(bc, a);
  Covering made;
  if (volume == 0) return made;
  made.shares = {0, dot(bc, d) / volume, dot(cross(c, a), d) / volume,
                 dot(cross(a, b), d) / volume};
  made.shares[0] = 1 - (made.shares[1] + made.shares[2] + made.shares[3]);
  made.least = std::ranges::min(made.shares);
  const double sizes = length(b) * length(c) + length(c) * length(a) + length(a) * length(b);
  made.rounding = 0x1p-48 * (1 + sizes * length(d) / std::abs(volume));
  return made;
}

/// Of a point outside: the shares of one inside that is near.
void clamp(Covering& covering) {
  double sum = 0;
  for (double& share : covering.shares) sum += share = std::max(share, 0.0);
  for (double& share : covering.shares) share /= sum;
}

class FieldMeasurer {
 public:
  FieldMeasurer(const PackedHierarchy& hierarchy, std::span<const std::uint32_t> mesh_vertices,
                const TetraMesh& mesh)
      : hierarchy_(hierarchy),
        mesh_vertices_(mesh_vertices),
        mesh_(mesh),
        n_(static_cast<std::uint32_t>(mesh.positions.size())),
        has_world_errors_(hierarchy.head().fields[0].base_world_error.has_value()),
        live_(n_, n_, mesh.tetrahedra),
        beside_(live_),
        first_sample_(mesh.tetrahedra.size(), kNone),
        next_sample_(n_, kNone),
        sample_corners_(n_, kAllCorners),
        corner_sets_(mesh.tetrahedra.size()),
        facts_(mesh.fields.size(), std::vector<Facts>(hierarchy.head().shape.n_nodes)) {
    for (const MeshField& field : mesh.fields) {
      const auto [low, high] = std::ranges::minmax_element(field.values);
      slacks_.push_back(field.values.empty() ? 0 : kSameValue * (*high - *low));
    }
  }

  void collapse(std::uint32_t node);
  /// Joins what it discovers, of which all is known.
  void nest(std::uint32_t node);
  /// Whether all that a collapse made was flat, as no builder makes it: then errors are not known.
  [[nodiscard]] bool has_lost_sample() const { return has_lost_sample_; }
  [[nodiscard]] std::vector<NumberedField> take_fields();

 private:
  struct Facts {
    double error = 0;
    double low = std::numeric_limits<double>::infinity();
    double high = -std::numeric_limits<double>::infinity();
    double world_error = 0;

    void widen(double value) {
      low = std::min(low, value);
      high = std::max(high, value);
    }
  };

  [[nodiscard]] Covering best_of_made(std::uint32_t sample, std::uint32_t kept) const;
  [[nodiscard]] std::array<double, 4> shares_of_corners(const Covering& covering,
                                                        std::uint32_t kept) const;
  void assign(std::uint32_t sample, std::uint32_t node, std::uint32_t kept);
  void find_beside(std::uint32_t removed);
  void note_held(std::uint32_t sample, std::uint32_t node, std::uint32_t kept);
  [[nodiscard]] double error_of(const Covering& covering, std::uint32_t sample, std::uint32_t kept,
                                std::size_t field) const;
  [[nodiscard]] double world_error_of(std::uint32_t sample, std::size_t first,
                                      std::size_t field) const;

  const PackedHierarchy& hierarchy_;
  std::span<const std::uint32_t> mesh_vertices_;
  const TetraMesh& mesh_;
  std::uint32_t n_;
  bool has_world_errors_;
  LiveTetrahedra live_;
  TetrahedraBeside beside_;
  std::vector<std::uint32_t> first_sample_;  ///< By slot,
  std::vector<std::uint32_t> next_sample_;   ///< and by vertex that has gone,
  std::vector<CornerBits> sample_corners_;   ///< with where it lies there.
  std::vector<CornerSets> corner_sets_;      ///< By slot, of the same.
  std::vector<std::vector<Facts>> facts_;    ///< By field and node.
  std::vector<std::uint32_t> made_;          ///< Slots of what a collapse makes.
  std::vector<std::uint32_t> samples_;
  std::vector<std::uint32_t> link_;            ///< Of what goes.
  std::vector<std::uint32_t> samples_beside_;  ///< Some of which what a collapse makes may hold.
  std::vector<double> slacks_;                 ///< By field: kSameValue of its range.
  bool has_lost_sample_ = false;
};

double FieldMeasurer::error_of(const Covering& covering, std::uint32_t sample, std::uint32_t kept,
                               std::size_t field) const {
  const std::vector<double>& values = mesh_.fields[field].values;
  const Tetrahedron& corners = live_.corners(covering.slot);
  const auto place = static_cast<std::size_t>(std::ranges::find(corners, kept) - corners.begin());
  const auto other = others(corners, place);
  double made = 0;
  double size = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double rise = values[other[k]] - values[kept];
    made += covering.shares[k + 1] * rise;
    size += std::abs(rise);
  }
  const double error = std::abs(values[sample] - values[kept] - made);
  return error == 0 ? 0 : error + size * covering.rounding;
}

std::array<double, 4> FieldMeasurer::shares_of_corners(const Covering& covering,
                                                       std::uint32_t kept) const {
  const Tetrahedron& corners = live_.corners(covering.slot);
  const auto place = static_cast<std::size_t>(std::ranges::find(corners, kept) - corners.begin());
  const auto other = others(corners, place);
  std::array<double, 4> shares{};
  for (std::size_t i = 0; i < shares.size(); ++i) {
    const auto at = std::ranges::find(other, corners[i]) - other.begin();
    shares[i] = covering.shares[i == place ? 0 : static_cast<std::size_t>(at) + 1];
  }
  return shares;
}

/// By the cells that a collapse makes; `first`: the place of the one that covers the sample.
double FieldMeasurer::world_error_of(std::uint32_t sample, std::size_t first,
                                     std::size_t field) const {
  const std::vector<double>& of = mesh_.fields[field].values;
  const auto cell_at = [&](std::size_t i, ValuedCell& cell) {
    const Tetrahedron& t = live_.corners(made_[i]);
    for (std::size_t k = 0; k < 4; ++k) {
      cell.corners[k] = mesh_.positions[t[k]];
      cell.values[k] = of[t[k]];
    }
    return true;
  };
  const Range same{of[sample] - slacks_[field], of[sample] + slacks_[field]};
  return distance_in_cells(made_.size(), first, cell_at, same, mesh_.positions[sample], 0);
}

Covering FieldMeasurer::best_of_made(std::uint32_t sample, std::uint32_t kept) const {
  constexpr double kInside = 1e-12;
  Covering best;
  for (const std::uint32_t slot : made_) {
    Covering here = cover(mesh_, live_.corners(slot), kept, mesh_.positions[sample]);
    here.slot = slot;
    if (here.least > best.least) best = here;
    if (best.least > kInside) break;
  }
  return best;
}

void FieldMeasurer::assign(std::uint32_t sample, std::uint32_t node, std::uint32_t kept) {
  Covering best = best_of_made(sample, kept);
  if (best.slot == kNone) {
    has_lost_sample_ = true;
    return;
  }
  if (best.least < 0) clamp(best);
  sample_corners_[sample] = corners_round(shares_of_corners(best, kept), best.least);
  corner_sets_[best.slot].add(sample_corners_[sample]);
  const auto covers = static_cast<std::size_t>(std::ranges::find(made_, best.slot) - made_.begin());
  next_sample_[sample] = first_sample_[best.slot];
  first_sample_[best.slot] = sample;
  for (std::size_t f = 0; f < facts_.size(); ++f) {
    Facts& facts = facts_[f][node];
    const double error = error_of(best, sample, kept, f);
    facts.error = std::max(facts.error, error);
    if (has_world_errors_)
      facts.world_error = std::max(facts.world_error, world_error_of(sample, covers, f));
    facts.widen(mesh_.fields[f].values[sample]);
  }
}

/// What others cover, before the collapse.
void FieldMeasurer::find_beside(std::uint32_t removed) {
  link_.clear();
  for (const std::uint32_t slot : made_)
    for (const std::uint32_t v : live_.corners(slot))
      if (v != removed) link_.push_back(v);
  std::ranges::sort(link_);
  link_.erase(std::unique(link_.begin(), link_.end()), link_.end());
  samples_beside_.clear();
  const auto sets_of = [&](std::uint32_t slot) { return corner_sets_[slot]; };
  beside_.visit(std::span(&removed, 1), link_, sets_of, [&](std::uint32_t slot, unsigned others) {
    for (std::uint32_t s = first_sample_[slot]; s != kNone; s = next_sample_[s])
      if ((sample_corners_[s] & others) == 0) samples_beside_.push_back(s);
  });
}

void FieldMeasurer::note_held(std::uint32_t sample, std::uint32_t node, std::uint32_t kept) {
  const Covering best = best_of_made(sample, kept);
  if (best.slot == kNone || !(best.least >= -kHeld - best.rounding)) return;
  for (std::size_t f = 0; f < facts_.size(); ++f)
    widen_by(mesh_.fields[f].values[sample], error_of(best, sample, kept, f), facts_[f][node]);
}

void FieldMeasurer::collapse(std::uint32_t node) {
  const std::uint32_t removed = mesh_vertices_[hierarchy_.head().shape.n_base_vertices + node];
  const std::uint32_t kept = mesh_vertices_[hierarchy_.links(node).target()];
  samples_.assign(1, removed);
  made_.assign(live_.star(removed).begin(), live_.star(removed).end());
  for (const std::uint32_t slot : made_) {
    for (std::uint32_t s = first_sample_[slot]; s != kNone; s = next_sample_[s])
      samples_.push_back(s);
    first_sample_[slot] = kNone;
    corner_sets_[slot] = {};
    for (const std::uint32_t v : live_.corners(slot))
      for (std::size_t f = 0; f < facts_.size(); ++f)
        facts_[f][node].widen(mesh_.fields[f].values[v]);
  }
  find_beside(removed);
  live_.collapse(removed, kept);
  std::erase_if(made_, [&](std::uint32_t slot) { return live_.is_gone(slot); });
  for (const std::uint32_t sample : samples_) assign(sample, node, kept);
  for (const std::uint32_t sample : samples_beside_) note_held(sample, node, kept);
}

void FieldMeasurer::nest(std::uint32_t node) {
  NodePage::Links links = hierarchy_.links(node);
  for (std::uint32_t k = links.n_discovered(); k > 0; --k) {
    const std::uint32_t child = links.next_node();
    for (std::vector<Facts>& of : facts_) {
      of[node].error = std::max(of[node].error, of[child].error);
      of[node].world_error = std::max(of[node].world_error, of[child].world_error);
      of[node].widen(of[child].low);
      of[node].widen(of[child].high);
    }
  }
}

std::vector<NumberedField> FieldMeasurer::take_fields() {
  const auto rounded_up = [](double x) {
    return std::nextafter(static_cast<float>(x), std::numeric_limits<float>::infinity());
  };
  std::vector<NumberedField> fields;
  for (std::size_t f = 0; f < facts_.size(); ++f) {
    const MeshField& from = mesh_.fields[f];
    NumberedField& field =
        fields.emplace_back(NumberedField{.name = from.name,
                                          .type = from.type,
                                          .values = {},
                                          .facts = {},
                                          .has_world_errors = has_world_errors_});
    for (const std::uint32_t v : mesh_vertices_) field.values.push_back(from.values[v]);
    field.range_reference = from.values.empty() ? 0 : std::ranges::min(from.values);
    for (const Facts& facts : facts_[f])
      field.facts.push_back({.error = facts.error == 0 ? 0 : rounded_up(facts.error),
                             .world_error = !has_world_errors_ ? StoredFacts{}.world_error
                                            : facts.world_error == 0
                                                ? 0
                                                : rounded_up(facts.world_error),
                             .low = -rounded_up(field.range_reference - facts.low),
                             .high = rounded_up(facts.high - field.range_reference)});
  }
  return fields;
}

/// By the mesh's numbers of vertices.
std::vector<RegionCell> region_cells(const TetraCut& cut,
                                     std::span<const std::uint32_t> mesh_vertices) {
  std::vector<RegionCell> cells;
  const std::vector<std::int64_t>& ids = cut.head().region_ids;
  if (ids.empty()) return cells;
  const auto slots = cut.slots();
  for (std::uint32_t slot = 0; slot < slots.size(); ++slot) {
    if (!cut.is_inside(slots[slot])) continue;
    Tetrahedron t = slots[slot].corners;
    for (std::uint32_t& v : t) v = mesh_vertices[v];
    cells.emplace_back(t, ids[cut.region(slot)]);
  }
  return cells;
}

}  // namespace

Result<void> check_same_mesh(const PackedHierarchy& hierarchy,
                             std::span<const std::uint32_t> mesh_vertices, const TetraMesh& mesh,
                             Progress& progress) {
  const HierarchyHead& head = hierarchy.head();
  const std::uint32_t last = mesh_vertices.empty() ? 0 : std::ranges::max(mesh_vertices);
  if (mesh.positions.size() <= last || mesh.tetrahedra.size() != head.n_cells)
    return fail("expected the mesh that was built, of {} vertices and {} cells, got {} and {}",
                head.n_vertices(), head.n_cells, mesh.positions.size(), mesh.tetrahedra.size());
  for (std::uint32_t v = 0; v < head.n_vertices(); ++v) {
    const Vec3d ours = hierarchy.position(v);
    const Vec3d& theirs = mesh.positions[mesh_vertices[v]];
    if (ours.v != theirs.v)
      return fail("expected the mesh that was built, with vertex {} at {}, {}, {}, got {}, {}, {}",
                  mesh_vertices[v], ours[0], ours[1], ours[2], theirs[0], theirs[1], theirs[2]);
  }
  TetraCut cut(hierarchy);
  Engine<TetraCut> engine(cut);
  engine.set_query(uniform_demand(0), {}, FocusChange::changed, ApplyOrder::nearest_first);
  engine.run([&] { return progress.is_cancelled() || cut.is_damaged(); });
  if (progress.is_cancelled()) return cancelled_error();
  LODE_CHECK(cut.check());
  std::vector<Tetrahedron> ours = cut.cells();
  for (Tetrahedron& t : ours)
    for (std::uint32_t& v : t) v = mesh_vertices[v];
  ours = in_order(ours);
  const std::vector<Tetrahedron> theirs = in_order(mesh.tetrahedra);
  const auto [a, b] = std::ranges::mismatch(ours, theirs);
  if (a != ours.end() && b != theirs.end())
    return fail("expected the mesh that was built, got one with a cell of vertices {}, {}, {}, {}",
                (*b)[0], (*b)[1], (*b)[2], (*b)[3]);
  return check_same_regions(region_cells(cut, mesh_vertices), region_cells(mesh));
}

Result<std::vector<NumberedField>> measure_fields(const PackedHierarchy& hierarchy,
                                                  std::span<const std::uint32_t> mesh_vertices,
                                                  const TetraMesh& mesh, Progress& progress) {
  LODE_CHECK(check_mesh(mesh));
  LODE_TRY(const std::vector<std::uint32_t> order, order_of_collapses(hierarchy));
  FieldMeasurer measurer(hierarchy, mesh_vertices, mesh);
  constexpr std::size_t kOften = 4096;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i % kOften == 0) {
      if (progress.is_cancelled()) return cancelled_error();
      progress.report("measuring fields",
                      static_cast<double>(i) / static_cast<double>(order.size()));
    }
    measurer.collapse(order[i]);
    measurer.nest(order[i]);
  }
  LODE_CHECK(hierarchy.check());
  if (measurer.has_lost_sample())
    return fail("expected nodes whose tetrahedra have volume, got one whose have none");
  return measurer.take_fields();
}

}  // namespace lode::tetra_mt
