#include "lode/models/terrain/insertions/mesh_replay.h"

#include <algorithm>
#include <array>
#include <bit>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "lode/delaunay/tin_links.h"
#include "lode/locate/tin_locator.h"
#include "lode/models/terrain/insertions/extract.h"
#include "lode/models/terrain/insertions/node_columns.h"
#include "lode/models/terrain/insertions/node_squares.h"
#include "lode/models/terrain/insertions/reach.h"
#include "lode/models/terrain/insertions/waiting_nodes.h"

namespace lode::insertions {
namespace {

using delaunay::LatticePoint;
using delaunay::LatticeTriangle;

/// By slot of the mesh, the corners of what is there, as the file's vertices.
using SlotVertices = std::vector<std::array<std::uint32_t, 3>>;

/// A mesh that nodes are inserted into, which keeps in its triangles when they were made: the
/// candidate is the node, or kNone, and the error's bits are the place among those made with it.
template <typename Mesh>
class MeshReplay {
 public:
  MeshReplay(const HistoryFile& file, const NodeColumns& columns, Mesh& mesh, SlotVertices vertices,
             std::size_t n_in_square)
      : file_(file),
        columns_(columns),
        mesh_(mesh),
        rule_(rule_of(file.base().model)),
        vertices_(std::move(vertices)),
        waiting_(columns),
        n_in_square_(n_in_square) {
    const std::size_t n_triangles = mesh_.triangles().size() + 2 * std::size_t{columns.n_nodes()};
    vertices_.reserve(n_triangles);
    for (std::uint32_t t = 0; t < mesh_.triangles().size(); ++t) set_birth(t, kNone, t);
  }

  /// number(vertex): in the mesh.
  template <typename Number>
  Result<void> insert_before(std::uint32_t time, Progress& progress, const Number& number) {
    for (const Band& band : file_.bands()) {
      if (band.begin >= time) break;
      const std::uint32_t nowhere = locate(band, time);
      if (nowhere != kNone) return not_insertable(nowhere);
      std::vector<std::uint32_t> nodes;
      for (std::uint32_t node = band.begin; node < band.end; ++node)
        if (columns_.times[node] < time) nodes.push_back(node);
      // A few are left after the first squares, and fewer after those across their corners.
      if (!mesh_.has_cuts())
        for (const bool is_shifted : {false, true}) {
          if (nodes.size() < 4 * n_in_square_) break;
          const NodeSquares squares(columns_, nodes, n_in_square_, is_shifted);
          LODE_CHECK(insert_by_squares(squares, progress, number, nodes));
        }
      LODE_CHECK(insert_in_time(nodes, progress, number));
    }
    return {};
  }

  /// Of what there is.
  [[nodiscard]] delaunay::Tin to_tin();

 private:
  void set_birth(std::uint32_t slot, std::uint32_t node, std::uint32_t place) {
    mesh_.triangle(slot).candidate = node;
    mesh_.triangle(slot).error = std::bit_cast<float>(place);
  }
  [[nodiscard]] std::uint64_t order_of(std::uint32_t slot) const {
    const LatticeTriangle& triangle = mesh_.triangles()[slot];
    const std::uint64_t time =
        triangle.candidate == kNone ? 0 : std::uint64_t{columns_.times[triangle.candidate]} + 1;
    return time << 32 | std::bit_cast<std::uint32_t>(triangle.error);
  }
  [[nodiscard]] LatticeCorners corners_of(std::uint32_t slot) const {
    const auto& [a, b, c] = mesh_.triangles()[slot].corner;
    return {mesh_.nodes().unpack(a), mesh_.nodes().unpack(b), mesh_.nodes().unpack(c)};
  }
  [[nodiscard]] Error not_insertable(std::uint32_t node) const {
    return columns_.not_insertable(file_, node);
  }

  /// As WaitingNodes::locate().
  [[nodiscard]] std::uint32_t locate(const Band& band, std::uint32_t time) {
    std::optional<delaunay::Tin> tin;
    std::optional<TinLocator> locator;
    // Across a mesh of a hundred million triangles; split triangles might send it round for ever.
    constexpr int kLongWalk = 1 << 15;
    return waiting_.locate(mesh_, band, time, kLongWalk, [&](LatticePoint p) {
      // Where the outline is in the way.
      if (!locator) locator.emplace(tin.emplace(tin_of_slots()));
      return locator->find(delaunay::to_point(p));
    });
  }
  /// Its triangles are the slots.
  [[nodiscard]] delaunay::Tin tin_of_slots() const {
    delaunay::Tin tin;
    tin.vertices = columns_.points;
    tin.triangles = vertices_;
    tin.twins.reserve(vertices_.size());
    for (const LatticeTriangle& triangle : mesh_.triangles()) tin.twins.push_back(triangle.twin);
    return tin;
  }

  [[nodiscard]] std::optional<std::uint32_t> find_seed(std::uint32_t node) const {
    return waiting_.find_seed(mesh_, node, [&](std::uint32_t slot) { return order_of(slot); });
  }

  template <typename Number>
  Result<void> insert_in_time(std::vector<std::uint32_t>& nodes, Progress& progress,
                              const Number& number) {
    std::ranges::sort(nodes, {}, [&](std::uint32_t node) { return columns_.times[node]; });
    for (const std::uint32_t node : nodes) {
      LODE_CHECK(check_in(progress));
      const auto seed = find_seed(node);
      std::span<const std::uint32_t> slots;
      const std::size_t n_before = mesh_.triangles().size();
      if (!seed || !mesh_.try_insert(number(columns_.n_base + node), *seed, slots))
        return not_insertable(node);
      LODE_CHECK(take_down(node, slots, slots.size() - (mesh_.triangles().size() - n_before)));
    }
    return {};
  }

  /// Leaves in `nodes` those that have to wait.
  template <typename Number>
  Result<void> insert_by_squares(const NodeSquares& squares, Progress& progress,
                                 const Number& number, std::vector<std::uint32_t>& nodes) {
    nodes.clear();
    states_.assign(mesh_.triangles().size(), kNone);
    for (const NodeSquares::Placed& placed : squares.nodes()) {
      const std::uint32_t square = placed.square;
      const std::uint32_t node = placed.node;
      LODE_CHECK(check_in(progress));
      const auto seed = find_seed(node);
      if (!seed) return not_insertable(node);
      const LatticeBox box = squares.box_of(square);
      std::span<const std::uint32_t> slots;
      const std::size_t n_before = mesh_.triangles().size();
      const auto inserted = mesh_.insert_if(
          number(columns_.n_base + node), *seed,
          [&](std::uint32_t slot) { return is_free(slot, square, box); }, slots);
      if (inserted == Mesh::Insertion::impossible) return not_insertable(node);
      if (inserted == Mesh::Insertion::refused) {
        for (const std::uint32_t slot : slots) states_[slot] = 2 * square;
        nodes.push_back(node);
        continue;
      }
      states_.resize(mesh_.triangles().size());
      for (const std::uint32_t slot : slots) states_[slot] = kNone;
      LODE_CHECK(take_down(node, slots, slots.size() - (mesh_.triangles().size() - n_before)));
    }
    return {};
  }

  /// Whether no node that is still to come removes the triangle before those of the square's that
  /// come now: none of other squares reaches it, and none of this one waits that does.
  [[nodiscard]] bool is_free(std::uint32_t slot, std::uint32_t square, const LatticeBox& box) {
    std::uint32_t& state = states_[slot];
    if (state >> 1 != square)
      state = 2 * square + (box.has(Reach(corners_of(slot), rule_).box()) ? 1 : 0);
    return (state & 1) != 0;
  }

  /// What an insertion has made.
  Result<void> take_down(std::uint32_t node, std::span<const std::uint32_t> slots,
                         std::size_t n_removed) {
    if (slots.size() != columns_.n_made[node])
      return fail("{}: node {}: expected it to make {} triangles, got {}", file_.path(),
                  columns_.times[node], columns_.n_made[node], slots.size());
    waiting_.hand_on(mesh_, node, slots, n_removed);
    border_.clear();
    for (const std::uint32_t slot : slots.first(n_removed))
      border_.insert(border_.end(), vertices_[slot].begin(), vertices_[slot].end());
    // Large fans are rare, and would take the square of their size.
    is_border_sorted_ = border_.size() > kLongBorder;
    if (is_border_sorted_)
      std::ranges::sort(border_, {}, [&](std::uint32_t v) { return in_rows(columns_.points[v]); });
    vertices_.resize(mesh_.triangles().size());
    for (std::uint32_t i = 0; i < slots.size(); ++i) {
      const LatticeCorners corners = corners_of(slots[i]);
      vertices_[slots[i]] = {border_vertex(corners[0]), border_vertex(corners[1]),
                             columns_.n_base + node};
      set_birth(slots[i], node, i);
    }
    return {};
  }
  [[nodiscard]] static std::pair<std::int32_t, std::int32_t> in_rows(LatticePoint p) {
    return {p.y, p.x};
  }
  [[nodiscard]] std::uint32_t border_vertex(LatticePoint p) const {
    if (is_border_sorted_)
      return *std::ranges::lower_bound(
          border_, in_rows(p), {}, [&](std::uint32_t v) { return in_rows(columns_.points[v]); });
    return *std::ranges::find_if(
        border_, [&](std::uint32_t vertex) { return columns_.points[vertex] == p; });
  }

  Result<void> check_in(Progress& progress) {
    constexpr std::uint32_t kPerReport = 1U << 16;
    if (n_seen_++ % kPerReport != 0) return {};
    if (progress.is_cancelled()) return cancelled_error();
    progress.report("inserting", std::min(1.0, static_cast<double>(n_seen_) / columns_.n_nodes()));
    return {};
  }

  [[nodiscard]] std::vector<std::uint32_t> slots_in_order() const;

  const HistoryFile& file_;
  const NodeColumns& columns_;
  Mesh& mesh_;
  delaunay::InsertionRule rule_;
  SlotVertices vertices_;
  WaitingNodes waiting_;
  std::size_t n_in_square_;
  /// By slot, of the square that looked at it last, twice its number, and one if it is free there.
  std::vector<std::uint32_t> states_;
  static constexpr std::size_t kLongBorder = 64;
  std::vector<std::uint32_t> border_;  ///< Corners of what a node removes, some twice.
  bool is_border_sorted_ = false;
  std::uint32_t n_seen_ = 0;
};

/// By when they were made.
template <typename Mesh>
std::vector<std::uint32_t> MeshReplay<Mesh>::slots_in_order() const {
  // Those of the base, then those of each node.
  const auto group_of = [&](const LatticeTriangle& triangle) {
    return triangle.candidate == kNone ? std::size_t{0}
                                       : std::size_t{columns_.times[triangle.candidate]} + 1;
  };
  std::vector<std::uint32_t> first(std::size_t{columns_.n_nodes()} + 2);
  for (const LatticeTriangle& triangle : mesh_.triangles()) ++first[group_of(triangle) + 1];
  for (std::size_t i = 1; i < first.size(); ++i) first[i] += first[i - 1];
  std::vector<std::uint32_t> slots(mesh_.triangles().size());
  std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
  for (std::uint32_t slot = 0; slot < slots.size(); ++slot)
    slots[next[group_of(mesh_.triangles()[slot])]++] = slot;
  for (std::size_t i = 0; i + 1 < first.size(); ++i)
    std::sort(slots.begin() + first[i], slots.begin() + first[i + 1],
              [&](std::uint32_t a, std::uint32_t b) { return order_of(a) < order_of(b); });
  return slots;
}

template <typename Mesh>
delaunay::Tin MeshReplay<Mesh>::to_tin() {
  if (mesh_.has_cuts()) mesh_.heal();
  const std::vector<std::uint32_t> slots = slots_in_order();
  std::vector<std::uint32_t> number(slots.size());
  for (std::uint32_t i = 0; i < slots.size(); ++i) number[slots[i]] = i;
  delaunay::Tin tin;
  tin.triangles.reserve(slots.size());
  tin.errors.reserve(slots.size());
  tin.twins.reserve(slots.size());
  for (const std::uint32_t slot : slots) {
    const LatticeTriangle& triangle = mesh_.triangles()[slot];
    const auto place = std::bit_cast<std::uint32_t>(triangle.error);
    tin.triangles.push_back(vertices_[slot]);
    tin.errors.push_back(triangle.candidate == kNone
                             ? file_.base().triangles[place].error
                             : columns_.errors[columns_.first_error[triangle.candidate] + place]);
    auto& twins = tin.twins.emplace_back(triangle.twin);
    for (std::uint32_t& twin : twins)
      if (twin != delaunay::kNoHalfEdge) twin = 4 * number[twin / 4] + twin % 4;
  }
  place_vertices(columns_.points, columns_.heights, tin);
  return tin;
}

/// On a mesh that has the base.
template <typename Mesh, typename Number>
Result<delaunay::Tin> replay(const HistoryFile& file, const NodeColumns& columns, Mesh mesh,
                             std::uint32_t time, std::size_t n_in_square, Progress& progress,
                             const Number& number) {
  SlotVertices vertices;
  for (const Triangle& triangle : file.base().triangles) vertices.push_back(triangle.corner);
  MeshReplay<Mesh> made(file, columns, mesh, std::move(vertices), n_in_square);
  LODE_CHECK(made.insert_before(time, progress, number));
  return made.to_tin();
}

}  // namespace

Result<delaunay::Tin> tin_at(const HistoryFile& file, std::uint32_t time, Progress& progress,
                             std::size_t n_in_square) {
  LODE_TRY(const NodeColumns columns, NodeColumns::read(file, file.n_bands_before(time), progress));
  const History& base = file.base();
  const delaunay::InsertionRule rule = rule_of(base.model);
  std::vector<std::array<std::uint32_t, 3>> corners;
  for (const Triangle& triangle : base.triangles) corners.push_back(triangle.corner);
  if (base.is_of_points) {
    delaunay::PointMesh mesh(delaunay::ListedNodes(columns.points), corners, rule);
    // Edges of triangles that are split stay without being cut.
    if (rule == delaunay::InsertionRule::delaunay) mesh.cut(base.lines);
    return replay(file, columns, std::move(mesh), time, n_in_square, progress,
                  [](std::uint32_t vertex) { return vertex; });
  }
  const delaunay::LatticePacking packing(base.frame.n_columns);
  const auto pack = [&](std::uint32_t vertex) { return packing.pack(columns.points[vertex]); };
  for (auto& [a, b, c] : corners) {
    a = pack(a);
    b = pack(b);
    c = pack(c);
  }
  return replay(file, columns, delaunay::LatticeMesh(packing, corners, rule), time, n_in_square,
                progress, pack);
}

}  // namespace lode::insertions
