// Does the collapses again, and notes what undoes them.
#include <algorithm>
#include <array>
#include <functional>
#include <optional>
#include <utility>

#include "lode/models/tetra_mt/base_order.h"
#include "lode/models/tetra_mt/face_labels.h"
#include "lode/models/tetra_mt/interfaces.h"
#include "lode/models/tetra_mt/live_tetrahedra.h"
#include "lode/models/tetra_mt/midpoint/coincident.h"
#include "lode/models/tetra_mt/midpoint/edge_collapser.h"
#include "lode/models/tetra_mt/midpoint/field_records.h"
#include "lode/models/tetra_mt/midpoint/hierarchy.h"
#include "lode/models/tetra_mt/midpoint/label_order.h"
#include "lode/models/tetra_mt/midpoint/star_order.h"

namespace lode::tetra_mt::midpoint {
namespace {

class HierarchyMaker {
 public:
  HierarchyMaker(const TetraMesh& mesh, const EdgeCollapses& collapses)
      : mesh_(mesh),
        collapses_(collapses),
        n_fields_(mesh.fields.size()),
        n_(static_cast<std::uint32_t>(mesh.positions.size())),
        first_scale_(scale_of(mesh.fields[0].values)) {}

  Result<Hierarchy> run(Threads threads) {
    if (std::uint64_t{n_} + collapses_.collapses.size() >= kNone)
      return fail("expected fewer than {} vertices and collapses, got {}", kNone,
                  std::uint64_t{n_} + collapses_.collapses.size());
    describe();
    start_leaves();
    std::vector<Tetrahedron> tetrahedra = mesh_.tetrahedra;
    LODE_CHECK(close_boundary(n_, tetrahedra, threads));
    regions_ = labels_of(mesh_, tetrahedra);
    LiveTetrahedra live(n_, n_, std::move(tetrahedra));
    find_labels(live);
    for (std::uint32_t k = 0; k < n_nodes(); ++k) {
      const EdgeCollapse& collapse = collapses_.collapses[k];
      LODE_CHECK(note_star(live, node_of(k), collapse));
      note_ends(k);
      live.collapse(collapse.removed, collapse.kept);
    }
    join_regions();
    take_base(live);
    find_radii();
    take_fields();
    return std::move(made_);
  }

 private:
  [[nodiscard]] std::uint32_t n_nodes() const {
    return static_cast<std::uint32_t>(collapses_.collapses.size());
  }
  /// That a collapse makes.
  [[nodiscard]] std::uint32_t node_of(std::uint32_t collapse) const {
    return order_.nodes[collapse] - n_;
  }
  /// Of a slot, as the hierarchy has it.
  [[nodiscard]] std::uint32_t region(std::uint32_t slot) const {
    if (regions_.empty()) return 0;
    return is_outside_label(regions_[slot]) ? patch_mark(regions_[slot]) : regions_[slot];
  }
  [[nodiscard]] bool is_outer(std::uint32_t slot) const { return slot >= mesh_.tetrahedra.size(); }
  [[nodiscard]] std::uint32_t label(std::uint32_t vertex) const {
    return vertex == n_ ? made_.outside() : labels_[vertex];
  }
  [[nodiscard]] Vec3d position(std::uint32_t vertex) const {
    return made_.position(labels_[vertex], codes_[vertex]);
  }
  void describe();
  void start_leaves();
  [[nodiscard]] std::optional<LeafOffset> offset_of(std::uint32_t v) const;
  void note_offsets();
  void note_coincident();
  void find_labels(const LiveTetrahedra& live);
  [[nodiscard]] Result<void> note_star(const LiveTetrahedra& live, std::uint32_t node,
                                       const EdgeCollapse& collapse);
  void note_regions(const LiveTetrahedra& live, std::uint32_t node, const EdgeCollapse& collapse);
  void note_ends(std::uint32_t collapse);
  void join_regions();
  void take_base(const LiveTetrahedra& live);
  void find_radii();
  [[nodiscard]] std::vector<EdgeFacts> facts_of(std::size_t field) const;
  void take_fields();
  void take_first(FurtherField&& records);

  const TetraMesh& mesh_;
  const EdgeCollapses& collapses_;
  std::size_t n_fields_;
  std::uint32_t n_;
  Scale first_scale_;                    ///< Of the first field.
  std::vector<std::uint32_t> regions_;   ///< By slot: labels_of().
  std::vector<std::uint32_t> labels_;    ///< By slot: of the vertex there now,
  std::vector<PositionCode> codes_;      ///< and its code.
  std::vector<std::uint8_t> is_turned_;  ///< By node: its first end is the one that went.
  LabelOrder order_;
  std::vector<StarTriangle> star_;
  /// By mixed node: what Hierarchy::mixed_regions says.
  std::vector<std::pair<std::uint32_t, std::vector<std::uint32_t>>> mixed_;
  std::vector<Vec3d> centres_;               ///< By node: where its vertex lies,
  std::vector<double> radii_;                ///< and how far what it changes reaches;
  std::vector<std::uint32_t> collapse_of_;   ///< likewise, what it undoes,
  std::vector<std::uint32_t> radius_codes_;  ///< and how far what it discovers reaches.
  Hierarchy made_;
};

void HierarchyMaker::describe() {
  made_.n_vertices = n_;
  made_.n_cells = mesh_.tetrahedra.size();
  made_.region_ids = mesh_.region_ids;
  made_.region_names = mesh_.region_names;
  made_.patches = mesh_.patches;
  made_.scales = Scales(mesh_);
  made_.wide.assign(n_ + std::size_t{n_nodes()}, kNone);
  made_.deep.resize(n_nodes());
  made_.nodes.resize(n_nodes());
  is_turned_.resize(n_nodes());
  centres_.resize(n_nodes());
  radii_.resize(n_nodes());
  if (n_ == 0) return;
  made_.boundary_deviation = collapses_.boundary_deviation;
  made_.record.boundary_tolerance = collapses_.boundary_tolerance;
  made_.box = {mesh_.positions[0], mesh_.positions[0]};
  for (const Vec3d& p : mesh_.positions)
    for (std::size_t i = 0; i < 3; ++i) {
      made_.box.lower[i] = std::min(made_.box.lower[i], p[i]);
      made_.box.upper[i] = std::max(made_.box.upper[i], p[i]);
    }
}

void HierarchyMaker::start_leaves() {
  for (const Vec3d& p : mesh_.positions) codes_.push_back(made_.scales.code(p));
}

/// Without rounding: what is off by half a step at most is a multiple of the last place of what it
/// is off from.
std::optional<LeafOffset> HierarchyMaker::offset_of(std::uint32_t v) const {
  LeafOffset offset;
  bool is_off = false;
  const auto note = [&](std::size_t axis, double coded, double exact) {
    if (const auto between = offset_between(coded, exact)) {
      offset.axes[axis] = *between;
      is_off = true;
    }
  };
  const Vec3d coded = made_.scales.position(codes_[v]);
  for (std::size_t axis = 0; axis < 3; ++axis) note(axis, coded[axis], mesh_.positions[v][axis]);
  const double value = mesh_.fields[0].values[v];
  note(3, first_scale_.value(first_scale_.code(value)), value);
  return is_off ? std::optional(offset) : std::nullopt;
}

void HierarchyMaker::find_labels(const LiveTetrahedra& live) {
  order_ = order_labels(mesh_, made_.scales, codes_, collapses_.collapses, live);
  labels_ = order_.leaves;
  made_.pages = std::move(order_.pages);
  made_.n_inner = n_nodes();
  made_.n_base_leaves = made_.pages.first_leaf(0);
  made_.page_counts = std::move(order_.counts);
  made_.page_levels = std::move(order_.levels);
  made_.mesh_vertices.resize(n_);
  for (std::uint32_t v = 0; v < n_; ++v) made_.mesh_vertices[labels_[v]] = v;
  collapse_of_.resize(n_nodes());
  for (std::uint32_t k = 0; k < n_nodes(); ++k) collapse_of_[node_of(k)] = k;
  note_offsets();
  note_coincident();
}

void HierarchyMaker::note_offsets() {
  for (std::uint32_t leaf = 0; leaf < n_; ++leaf) {
    const std::optional<LeafOffset> offset = offset_of(made_.mesh_vertices[leaf]);
    if (!offset) continue;
    made_.exact.add(leaf, *offset);
    if (leaf < made_.n_base_leaves) made_.base_exact.add(leaf, *offset);
  }
}

void HierarchyMaker::note_coincident() {
  const std::vector<std::uint32_t> order = by_place(mesh_.positions);
  for (const CoincidentRun& run : coincident_runs(mesh_.positions, order))
    for (std::size_t i = run.begin; i < run.end; ++i)
      made_.coincident_leaves.push_back(labels_[order[i]]);
  made_.n_coincident_leaves = static_cast<std::uint32_t>(made_.coincident_leaves.size());
}

/// Which tetrahedra come of which end. Those with both ends go.
Result<void> HierarchyMaker::note_star(const LiveTetrahedra& live, std::uint32_t node,
                                       const EdgeCollapse& collapse) {
  star_.clear();
  const std::uint32_t made = n_ + node;
  const std::uint32_t first =
      labels_[collapse.kept] > labels_[collapse.removed] ? collapse.kept : collapse.removed;
  const std::uint32_t second = first == collapse.kept ? collapse.removed : collapse.kept;
  const Place place = first == collapse.kept ? collapse.position : turned(collapse.position);
  centres_[node] = made_.scales.position(merged(codes_[first], codes_[second], place));
  double reach =
      std::max(length(position(first) - centres_[node]), length(position(second) - centres_[node]));
  for (const std::uint32_t end : {first, second})
    for (const std::uint32_t slot : live.star(end)) {
      Tetrahedron t = live.corners(slot);
      const bool is_between = std::ranges::find(t, end == first ? second : first) != t.end();
      if (is_between) continue;
      const auto at = static_cast<std::size_t>(std::ranges::find(t, end) - t.begin());
      std::array<std::uint32_t, 3> face = others(t, at);
      for (std::uint32_t& v : face) {
        if (v != n_) reach = std::max(reach, length(position(v) - centres_[node]));
        v = label(v);
      }
      star_.push_back({star_key(face), face, slot, end == second});
    }
  radii_[node] = reach;
  sort_star(star_);
  if (star_.size() > kMaxStar)
    return fail("vertex {}: expected at most {} tetrahedra, got {}", made, kMaxStar, star_.size());
  NodeRecord& record = made_.nodes[node];
  std::uint64_t mask = 0;
  for (std::size_t i = 0; i < star_.size(); ++i) {
    if (star_[i].is_second) mask |= std::uint64_t{1} << i;
    if (i > 0 && star_[i].key == star_[i - 1].key)
      return fail("vertex {}: expected different tetrahedra, got two of the same corners", made);
  }
  mask |= static_cast<std::uint64_t>(place) << 60;
  record.mask = {static_cast<std::uint32_t>(mask), static_cast<std::uint32_t>(mask >> 32)};
  if (made_.has_regions()) note_regions(live, node, {first, second, place});
  return {};
}

/// Collapses leave tetrahedra their slots, which are the mesh's: so their regions are known.
void HierarchyMaker::note_regions(const LiveTetrahedra& live, std::uint32_t node,
                                  const EdgeCollapse& collapse) {
  std::array<std::uint32_t, 2> common{kNone, kNone};  // of those inside, and outside
  bool is_common = true;
  const auto look_at = [&](std::uint32_t slot) {
    std::uint32_t& there = common[is_outer(slot) ? 1 : 0];
    if (there == kNone) there = region(slot);
    is_common = is_common && region(slot) == there;
  };
  for (const StarTriangle& triangle : star_) look_at(triangle.slot);
  std::vector<std::pair<std::uint64_t, std::uint32_t>> between;
  for (const std::uint32_t slot : live.star(collapse.kept)) {
    const Tetrahedron& t = live.corners(slot);
    if (std::ranges::find(t, collapse.removed) == t.end()) continue;
    look_at(slot);
    std::array<std::uint32_t, 2> edge{};
    std::size_t n = 0;
    for (const std::uint32_t v : t)
      if (v != collapse.kept && v != collapse.removed) edge[n++] = label(v);
    between.emplace_back(edge_key(edge[0], edge[1]), region(slot));
  }
  if (is_common) return;
  std::ranges::sort(between);
  auto& regions = mixed_.emplace_back(node, std::vector<std::uint32_t>()).second;
  for (const auto& [edge, region_there] : between) regions.push_back(region_there);
}

void HierarchyMaker::join_regions() {
  std::ranges::sort(mixed_);
  if (!mixed_.empty()) made_.mixed_begins.push_back(0);
  for (const auto& [node, regions] : mixed_) {
    made_.mixed_nodes.push_back(node);
    made_.mixed_regions.insert(made_.mixed_regions.end(), regions.begin(), regions.end());
    made_.mixed_begins.push_back(made_.mixed_regions.size());
  }
}

void HierarchyMaker::note_ends(std::uint32_t collapse) {
  const auto [kept, removed, position] = collapses_.collapses[collapse];
  const std::uint32_t node = node_of(collapse);
  const bool is_kept_first = labels_[kept] > labels_[removed];
  const std::uint32_t first = is_kept_first ? kept : removed;
  const std::uint32_t second = is_kept_first ? removed : kept;
  NodeRecord& record = made_.nodes[node];
  for (std::size_t i = 0; i < 3; ++i)
    record.difference[i] = difference(codes_[first][i], codes_[second][i]);
  is_turned_[node] = is_kept_first ? 0 : 1;
  made_.deep[node] = labels_[first];
  made_.wide[labels_[first]] = labels_[second];
  made_.wide[labels_[second]] = n_ + node;
  codes_[kept] = merged(codes_[first], codes_[second], record.placement().position);
  labels_[kept] = n_ + node;
}

void HierarchyMaker::take_base(const LiveTetrahedra& live) {
  for (std::uint32_t slot = 0; slot < live.n_slots(); ++slot) {
    if (live.is_gone(slot)) continue;
    Tetrahedron t = live.corners(slot);
    for (std::uint32_t& v : t) v = label(v);
    made_.base.push_back(t);
    if (made_.has_regions()) made_.base_regions.push_back(region(slot));
    if (!is_outer(slot)) ++made_.n_base_cells;
  }
  std::vector<std::pair<std::uint32_t, std::uint32_t>> there;
  for (std::uint32_t v = 0; v < n_; ++v)
    if (made_.wide[labels_[v]] == kNone) there.emplace_back(labels_[v], v);
  std::ranges::sort(there);
  for (const auto& [root, v] : there) {
    made_.roots.push_back(root);
    const PositionCode& at = codes_[v];
    made_.root_codes.push_back({at[0], at[1], at[2], 0});
  }
  // From one of the first vertices on, wherever its slot is.
  std::vector<std::pair<Tetrahedron, std::size_t>> sorted;
  for (std::size_t i = 0; i < made_.base.size(); ++i) {
    sorted.emplace_back(made_.base[i], i);
    std::ranges::sort(sorted.back().first, std::greater());
  }
  std::ranges::sort(sorted);
  BaseTetrahedra base;
  for (const auto& [corners, i] : sorted) {
    base.corners.push_back(made_.base[i]);
    base.makers.push_back(kNone);
    if (made_.has_regions()) base.regions.push_back(made_.base_regions[i]);
  }
  base = in_base_order(base);
  made_.base = std::move(base.corners);
  made_.base_regions = std::move(base.regions);
}

/// Nested along the forest: children have smaller labels, so they are known. Balls are those that
/// codes say.
void HierarchyMaker::find_radii() {
  made_.radii = RadiusCodes(2 * length(made_.box.upper - made_.box.lower));
  radius_codes_.resize(n_nodes());
  for (std::uint32_t node = 0; node < n_nodes(); ++node) {
    double radius = radii_[node];
    const auto [first, second] = made_.children(node);
    for (const std::uint32_t child : {first, second}) {
      if (made_.is_leaf(child)) continue;
      const std::uint32_t below = child - n_;
      radius = std::max(radius, length(centres_[below] - centres_[node]) +
                                    made_.radii.radius(radius_codes_[below]));
    }
    radius_codes_[node] = made_.radii.code(radius * (1 + 0x1p-40));
  }
}

/// By node.
std::vector<EdgeFacts> HierarchyMaker::facts_of(std::size_t field) const {
  std::vector<EdgeFacts> facts;
  for (std::uint32_t node = 0; node < n_nodes(); ++node) {
    facts.push_back(collapses_.facts[std::size_t{collapse_of_[node]} * n_fields_ + field]);
    if (is_turned_[node] != 0) facts.back().value = turned(facts.back().value);
  }
  return facts;
}

void HierarchyMaker::take_fields() {
  std::vector<Children> children;
  for (std::uint32_t node = 0; node < n_nodes(); ++node) children.push_back(made_.children(node));
  FieldTrees trees{made_.mesh_vertices, children, made_.roots, made_.n_base_leaves};
  if (collapses_.has_world_errors) trees.world_codes = WorldCodes(made_.box.lower, made_.box.upper);
  for (std::size_t f = 0; f < n_fields_; ++f) {
    const MeshField& field = mesh_.fields[f];
    FieldRecords records = make_field(trees, field, facts_of(f),
                                      base_error_of(collapses_.errors, f, n_fields_, field));
    made_.fields.push_back(std::move(records.head));
    made_.world_codes.push_back(std::move(records.world_codes));
    if (f == 0)
      take_first(std::move(records.records));
    else
      made_.further.push_back(std::move(records.records));
  }
}

/// Lies with the nodes, and the balls with it.
void HierarchyMaker::take_first(FurtherField&& records) {
  const auto with_ball = [&](std::uint32_t facts, std::uint32_t node) {
    return NodeCodes::with_ball_of(facts, NodeCodes::word({.radius = radius_codes_[node]}));
  };
  for (std::uint32_t node = 0; node < n_nodes(); ++node) {
    const FieldRecord& from = records.nodes[node];
    NodeRecord& record = made_.nodes[node];
    record.difference[3] = from.difference;
    record.mask[1] |= static_cast<std::uint32_t>(from.place()) << 30;
    record.facts = with_ball(from.facts(), node);
  }
  for (std::size_t i = 0; i < made_.roots.size(); ++i) {
    const std::uint32_t root = made_.roots[i];
    made_.root_codes[i][3] = records.roots.codes[i];
    made_.root_facts.push_back(made_.is_leaf(root) ? 0
                                                   : with_ball(records.roots.facts[i], root - n_));
  }
}

}  // namespace

Result<Hierarchy> make_hierarchy(const TetraMesh& mesh, const EdgeCollapses& collapses,
                                 Threads threads) {
  return HierarchyMaker(mesh, collapses).run(threads);
}

}  // namespace lode::tetra_mt::midpoint
