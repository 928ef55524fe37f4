// Does the collapses again, and notes what undoes them.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <utility>

#include "lode/models/tetra_mt/face_labels.h"
#include "lode/models/tetra_mt/interfaces.h"
#include "lode/models/tetra_mt/live_tetrahedra.h"
#include "lode/models/tetra_mt/midpoint/edge_collapser.h"
#include "lode/models/tetra_mt/midpoint/hierarchy.h"
#include "lode/models/tetra_mt/midpoint/label_order.h"
#include "lode/models/tetra_mt/midpoint/star_order.h"

namespace lode::tetra_mt::midpoint {
namespace {

bool is_same(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}
/// What with_offset() takes to come from one to the other, which differs.
double between(double coded, double exact) { return exact == coded ? exact : exact - coded; }

class HierarchyMaker {
 public:
  HierarchyMaker(const TetraMesh& mesh, const EdgeCollapses& collapses)
      : mesh_(mesh),
        collapses_(collapses),
        n_fields_(mesh.fields.size()),
        n_(static_cast<std::uint32_t>(mesh.positions.size())) {}

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
    for (std::size_t field = 0; field < n_fields_; ++field) find_facts(field);
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
  [[nodiscard]] ForestField described(std::size_t field) const;
  void start_leaves();
  [[nodiscard]] std::optional<LeafOffset> offset_of(std::uint32_t v) const;
  void note_offsets();
  void find_labels(const LiveTetrahedra& live);
  [[nodiscard]] Result<void> note_star(const LiveTetrahedra& live, std::uint32_t node,
                                       const EdgeCollapse& collapse);
  void note_regions(const LiveTetrahedra& live, std::uint32_t node, const EdgeCollapse& collapse);
  void note_ends(std::uint32_t collapse);
  void join_regions();
  void take_base(const LiveTetrahedra& live);
  void find_radii();
  void find_facts(std::size_t field);

  const TetraMesh& mesh_;
  const EdgeCollapses& collapses_;
  std::size_t n_fields_;
  std::uint32_t n_;
  std::vector<std::uint32_t> regions_;  ///< By slot: labels_of().
  std::vector<std::uint32_t> labels_;   ///< By slot: of the vertex there now,
  std::vector<PositionCode> codes_;     ///< and its codes,
  std::vector<std::int32_t> values_;    ///< those of values by field, too.
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
  made_.further.resize(n_fields_ - 1);
  for (FurtherField& field : made_.further) field.nodes.resize(n_nodes());
  for (std::size_t f = 0; f < n_fields_; ++f) made_.fields.push_back(described(f));
  centres_.resize(n_nodes());
  radii_.resize(n_nodes());
  if (n_ == 0) return;
  made_.boundary_deviation = collapses_.boundary_deviation;
  made_.box = {mesh_.positions[0], mesh_.positions[0]};
  for (const Vec3d& p : mesh_.positions)
    for (std::size_t i = 0; i < 3; ++i) {
      made_.box.lower[i] = std::min(made_.box.lower[i], p[i]);
      made_.box.upper[i] = std::max(made_.box.upper[i], p[i]);
    }
}

ForestField HierarchyMaker::described(std::size_t field) const {
  const MeshField& from = mesh_.fields[field];
  ForestField made{.name = from.name, .type = from.type, .scale = scale_of(from.values)};
  if (n_ == 0) return made;
  made.low = std::ranges::min(from.values);
  made.high = std::ranges::max(from.values);
  constexpr double kRounded = 1 + 0x1p-23;  // Shares are rounded to the nearest float32.
  for (std::size_t v = 0; v < n_; ++v) {
    const auto error = static_cast<double>(collapses_.errors[v * n_fields_ + field]);
    made.base_error =
        std::max(made.base_error, kRounded * std::abs(error) * (made.high - made.low));
  }
  return made;
}

void HierarchyMaker::start_leaves() {
  for (std::uint32_t v = 0; v < n_; ++v) {
    codes_.push_back(made_.scales.code(mesh_.positions[v]));
    for (std::size_t f = 0; f < n_fields_; ++f)
      values_.push_back(made_.fields[f].scale.code(mesh_.fields[f].values[v]));
  }
}

/// Without rounding: what is off by half a step at most is a multiple of the last place of what it
/// is off from.
std::optional<LeafOffset> HierarchyMaker::offset_of(std::uint32_t v) const {
  LeafOffset offset;
  bool is_off = false;
  for (std::size_t axis = 0; axis < 4; ++axis) {
    const double exact = axis < 3 ? mesh_.positions[v][axis] : mesh_.fields[0].values[v];
    const double coded = axis < 3 ? made_.scales.axes()[axis].value(codes_[v][axis])
                                  : made_.fields[0].scale.value(values_[v * n_fields_]);
    if (is_same(exact, coded)) continue;
    is_off = true;
    offset.axes[axis] = between(coded, exact);
  }
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
}

void HierarchyMaker::note_offsets() {
  for (std::uint32_t leaf = 0; leaf < n_; ++leaf) {
    const std::uint32_t v = made_.mesh_vertices[leaf];
    const bool is_root = leaf < made_.n_base_leaves;
    if (const std::optional<LeafOffset> offset = offset_of(v)) {
      made_.exact.add(leaf, *offset);
      if (is_root) made_.base_exact.add(leaf, *offset);
    }
    for (std::size_t f = 1; f < n_fields_; ++f) {
      const double exact = mesh_.fields[f].values[v];
      const double coded = made_.fields[f].scale.value(values_[v * n_fields_ + f]);
      if (is_same(exact, coded)) continue;
      FurtherField& field = made_.further[f - 1];
      field.exact.add(leaf, between(coded, exact));
      if (is_root) field.roots.exact.add(leaf, between(coded, exact));
    }
  }
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
  for (std::size_t f = 0; f < n_fields_; ++f) {
    const Place given = collapses_.facts[collapse * n_fields_ + f].value;
    const Place place = is_kept_first ? given : turned(given);
    const std::int32_t a = values_[first * n_fields_ + f];
    const std::int32_t b = values_[second * n_fields_ + f];
    if (f == 0) {
      record.difference[3] = difference(a, b);
      record.mask[1] |= static_cast<std::uint32_t>(place) << 30;
    } else {
      made_.further[f - 1].nodes[node] = {difference(a, b), 0, place};
    }
    values_[kept * n_fields_ + f] = merged(a, b, place);
  }
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
    made_.root_codes.push_back({at[0], at[1], at[2], values_[v * n_fields_]});
    for (std::size_t f = 1; f < n_fields_; ++f)
      made_.further[f - 1].roots.codes.push_back(values_[v * n_fields_ + f]);
  }
  // Near ones are near in files.
  std::vector<std::pair<Tetrahedron, std::size_t>> sorted;
  for (std::size_t i = 0; i < made_.base.size(); ++i) {
    sorted.emplace_back(made_.base[i], i);
    std::ranges::sort(sorted.back().first, std::greater());
  }
  std::ranges::sort(sorted);
  const std::vector<Tetrahedron> base = std::exchange(made_.base, {});
  const std::vector<std::uint32_t> regions = std::exchange(made_.base_regions, {});
  for (const auto& [corners, i] : sorted) {
    made_.base.push_back(base[i]);
    if (made_.has_regions()) made_.base_regions.push_back(regions[i]);
  }
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

/// Likewise.
void HierarchyMaker::find_facts(std::size_t field) {
  double largest_error = 0;
  for (std::size_t k = 0; k < n_nodes(); ++k)
    largest_error = std::max(largest_error, collapses_.facts[k * n_fields_ + field].error);
  made_.fields[field].codes = NodeCodes(mesh_.fields[field].values, largest_error);
  const NodeCodes& codes = made_.fields[field].codes;
  std::vector<std::uint32_t> words(n_nodes());
  for (std::uint32_t node = 0; node < n_nodes(); ++node) {
    const EdgeFacts& own = collapses_.facts[std::size_t{collapse_of_[node]} * n_fields_ + field];
    NodeCodes::Parts all{codes.error_code(own.error), codes.low_code(own.low),
                         codes.high_code(own.high), radius_codes_[node]};
    const auto [first, second] = made_.children(node);
    for (const std::uint32_t child : {first, second}) {
      if (made_.is_leaf(child)) continue;
      const NodeCodes::Parts below = NodeCodes::parts(words[child - n_]);
      all.error = std::max(all.error, below.error);
      all.low = std::min(all.low, below.low);
      all.high = std::max(all.high, below.high);
    }
    words[node] = NodeCodes::word(all);
    if (field == 0) {
      made_.nodes[node].facts = words[node];
    } else {
      FieldRecord& record = made_.further[field - 1].nodes[node];
      record = {record.difference, words[node], record.place()};
    }
  }
  for (const std::uint32_t root : made_.roots) {
    const std::uint32_t word = made_.is_leaf(root) ? 0 : words[root - n_];
    if (field == 0)
      made_.root_facts.push_back(word);
    else
      made_.further[field - 1].roots.facts.push_back(NodeCodes::without_ball(word));
  }
}

}  // namespace

Result<Hierarchy> make_hierarchy(const TetraMesh& mesh, const EdgeCollapses& collapses,
                                 Threads threads) {
  return HierarchyMaker(mesh, collapses).run(threads);
}

}  // namespace lode::tetra_mt::midpoint
