#include "lode/models/terrain/insertions/replay.h"

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "lode/delaunay/lattice_side.h"
#include "lode/models/terrain/insertions/overlap.h"
#include "lode/models/terrain/insertions/recorder.h"
#include "lode/models/terrain/insertions/start_finder.h"

namespace lode::insertions {
namespace {

using delaunay::InsertionRule;
using delaunay::LatticePoint;

/// Inserts nodes that a file has again.
class Replay {
 public:
  Replay(const HistoryFile& file, std::span<const Band> bands) : file_(file), bands_(bands) {}

  Result<History> run(Progress& progress) {
    LODE_CHECK(read_pages(progress));
    begin_history();
    const InsertionRule rule = rule_of(history_.model);
    if (history_.is_of_points) {
      delaunay::PointMesh mesh(delaunay::ListedNodes(points_), base_, rule);
      // Edges of triangles that are split stay without being cut.
      if (rule == InsertionRule::delaunay) mesh.cut(history_.lines);
      LODE_CHECK(insert(mesh, progress, [](std::uint32_t vertex) { return vertex; }));
    } else {
      const delaunay::LatticePacking packing(history_.frame.n_columns);
      const auto pack = [&](std::uint32_t vertex) { return packing.pack(points_[vertex]); };
      std::vector<std::array<std::uint32_t, 3>> packed;
      packed.reserve(base_.size());
      for (const auto& corner : base_)
        packed.push_back({pack(corner[0]), pack(corner[1]), pack(corner[2])});
      delaunay::LatticeMesh mesh(packing, packed, rule);
      LODE_CHECK(insert(mesh, progress, pack));
    }
    take_errors();
    return std::move(history_);
  }

 private:
  [[nodiscard]] std::uint32_t n_nodes() const { return bands_.empty() ? 0 : bands_.back().end; }
  [[nodiscard]] std::uint32_t n_base() const { return file_.base().n_base_vertices; }

  Result<void> read_pages(Progress& progress) {
    const std::size_t n_vertices = std::size_t{n_base()} + n_nodes();
    points_ = file_.base().vertices;
    points_.resize(n_vertices);
    heights_ = file_.base().heights;
    heights_.resize(n_vertices);
    n_made_.resize(n_nodes());
    begins_later_.resize(n_nodes());
    for (const Band& band : bands_)
      for (std::uint32_t page = band.first_page; page < band.first_page + band.n_pages; ++page) {
        if (progress.is_cancelled()) return cancelled_error();
        progress.report("reading", static_cast<double>(page) / static_cast<double>(n_pages()));
        LODE_CHECK(read_page(page));
      }
    return {};
  }

  [[nodiscard]] std::size_t n_pages() const {
    return bands_.back().first_page + bands_.back().n_pages;
  }

  Result<void> read_page(std::uint32_t page) {
    LODE_TRY(const PageNodes nodes, file_.read_nodes(page));
    for (std::size_t i = 0; i < nodes.times.size(); ++i) {
      const std::uint32_t time = nodes.times[i];
      // Pages have as many nodes as there are, so none is missing if none is there twice.
      if (n_made_[time] != 0)
        return fail("{}: page {}: expected node {} once, got it again", file_.path(), page, time);
      points_[n_base() + time] = nodes.points[i];
      heights_[n_base() + time] = nodes.heights[i];
      n_made_[time] = nodes.first_made[i + 1] - nodes.first_made[i];
      begins_later_[time] = nodes.begins_later[i];
    }
    order_.insert(order_.end(), nodes.times.begin(), nodes.times.end());
    add_way(nodes);
    LODE_TRY(const std::vector<float> errors, file_.read_errors(page));
    errors_.insert(errors_.end(), errors.begin(), errors.end());
    return {};
  }

  /// Appends a page's nodes to the way, each near the one before.
  void add_way(const PageNodes& nodes) {
    std::vector<std::pair<std::uint64_t, std::uint32_t>> way;
    way.reserve(nodes.times.size());
    for (std::size_t i = 0; i < nodes.times.size(); ++i)
      way.emplace_back(place_along_z(nodes.points[i]), nodes.times[i]);
    std::ranges::sort(way);
    for (const auto& [place, node] : way) way_.push_back(node);
  }

  /// Of the base, as far as the recorder does not make it again.
  void begin_history() {
    const History& base = file_.base();
    static_cast<terrain_file::Source&>(history_) = base;
    history_.model = base.model;
    history_.level_ends = base.level_ends;
    history_.max_error = base.max_error;
    history_.lines = base.lines;
    history_.heights = std::move(heights_);
    for (const Triangle& triangle : base.triangles) base_.push_back(triangle.corner);
    start_.emplace(base, base_);
  }

  /// number(vertex): in the mesh.
  template <typename Mesh, typename Number>
  Result<void> insert(Mesh& mesh, Progress& progress, const Number& number) {
    Recorder recorder(history_);
    recorder.start(mesh);
    slot_of_.resize(base_.size());
    for (std::uint32_t t = 0; t < slot_of_.size(); ++t) slot_of_[t] = t;
    slot_with_.resize(n_nodes());
    next_.resize(n_nodes());
    for (const Band& band : bands_) {
      LODE_CHECK(locate_band(mesh, band));
      LODE_CHECK(insert_band(mesh, recorder, band, progress, number));
    }
    recorder.finish();
    return {};
  }

  /// In which triangles the band's nodes are before any of it is inserted: on a way of short
  /// steps.
  template <typename Mesh>
  Result<void> locate_band(const Mesh& mesh, const Band& band) {
    first_in_.assign(mesh.triangles().size(), kNone);
    std::uint32_t slot = 0;
    for (std::uint32_t i = band.begin; i < band.end; ++i) {
      const std::uint32_t node = way_[i];
      const LatticePoint p = points_[n_base() + node];
      auto met = walk(mesh, slot, p);
      if (!met) met = look_down(p);
      if (!met) return not_insertable(node);
      put(node, slot = *met);
    }
    return {};
  }

  void put(std::uint32_t node, std::uint32_t slot) {
    slot_with_[node] = slot;
    next_[node] = std::exchange(first_in_[slot], node);
  }

  /// The slot of the triangle that holds p, down the history from the base.
  [[nodiscard]] std::optional<std::uint32_t> look_down(LatticePoint p) const {
    const auto start = start_->find(delaunay::to_point(p));
    if (!start) return {};
    std::uint32_t t = *start;
    while (history_.triangles[t].death != kNone) t = part_with(history_.triangles[t].death, p);
    return slot_of_[t];
  }

  /// Nodes that are to come after this one go on to the triangles that were made where they are.
  template <typename Mesh>
  void hand_on(const Mesh& mesh, std::uint32_t inserted, std::span<const std::uint32_t> slots,
               std::size_t n_removed) {
    first_in_.resize(mesh.triangles().size(), kNone);
    handed_on_.clear();
    for (const std::uint32_t slot : slots.first(n_removed))
      for (std::uint32_t node = std::exchange(first_in_[slot], kNone); node != kNone;
           node = next_[node])
        if (node != inserted) handed_on_.push_back(node);
    for (const std::uint32_t node : handed_on_) {
      const LatticePoint p = points_[n_base() + node];
      const auto with = std::ranges::find_if(slots, [&](std::uint32_t slot) {
        const auto& [a, b, c] = mesh.triangles()[slot].corner;
        return holds({mesh.nodes().unpack(a), mesh.nodes().unpack(b), mesh.nodes().unpack(c)}, p);
      });
      if (with != slots.end()) put(node, *with);
    }
  }

  /// The triangle that holds p, on a straight way from another; nothing where the outline stops it,
  /// or it gets long.
  template <typename Mesh>
  static std::optional<std::uint32_t> walk(const Mesh& mesh, std::uint32_t slot, LatticePoint p) {
    constexpr int kLongWalk = 256;
    for (int step = 0; step < kLongWalk; ++step) {
      const auto& corner = mesh.triangles()[slot].corner;
      std::uint32_t out = 0;
      for (; out < 3; ++out)
        if (delaunay::doubled_area(mesh.nodes().unpack(corner[out]),
                                   mesh.nodes().unpack(corner[(out + 1) % 3]), p) < 0)
          break;
      if (out == 3) return slot;
      const std::uint32_t twin = mesh.behind(slot, out);
      if (twin == delaunay::kNoHalfEdge) return {};
      slot = twin / 4;
    }
    return {};
  }

  template <typename Mesh, typename Number>
  Result<void> insert_band(Mesh& mesh, Recorder& recorder, const Band& band, Progress& progress,
                           const Number& number) {
    constexpr std::uint32_t kPerReport = 1U << 16;
    for (std::uint32_t node = band.begin; node < band.end; ++node) {
      if (node % kPerReport == 0) {
        if (progress.is_cancelled()) return cancelled_error();
        progress.report("inserting", static_cast<double>(node) / n_nodes());
      }
      const std::uint32_t vertex = n_base() + node;
      const LatticePoint p = points_[vertex];
      const auto seed = find_seed(mesh, recorder, node);
      std::span<const std::uint32_t> slots;
      const std::size_t n_before = mesh.triangles().size();
      if (!seed || !mesh.try_insert(number(vertex), slot_of_[*seed], slots))
        return not_insertable(node);
      if (slots.size() != n_made_[node])
        return fail("{}: node {}: expected it to make {} triangles, got {}", file_.path(), node,
                    n_made_[node], slots.size());
      const std::size_t n_removed = slots.size() - (mesh.triangles().size() - n_before);
      recorder.add_node(mesh, p, slots, n_removed);
      hand_on(mesh, node, slots, n_removed);
      slot_of_.insert(slot_of_.end(), slots.begin(), slots.end());
    }
    return {};
  }

  /// The triangle where removing begins: it is there and holds the vertex, which is no corner.
  template <typename Mesh>
  [[nodiscard]] std::optional<std::uint32_t> find_seed(const Mesh& mesh, const Recorder& recorder,
                                                       std::uint32_t node) const {
    const LatticePoint p = points_[n_base() + node];
    const std::uint32_t t = recorder.triangle_in(slot_with_[node]);
    const LatticeCorners corners = corners_of(t);
    if (!holds(corners, p) || std::ranges::find(corners, p) != corners.end()) return {};
    for (std::uint32_t i = 0; i < 3; ++i) {
      if (delaunay::doubled_area(corners[i], corners[(i + 1) % 3], p) != 0) continue;
      const std::uint32_t behind = mesh.behind(slot_of_[t], i);
      if (behind == delaunay::kNoHalfEdge) continue;
      const std::uint32_t other = recorder.triangle_in(behind / 4);
      return begins_later_[node] ? std::max(t, other) : std::min(t, other);
    }
    return t;
  }

  /// Of the triangles that a node makes the one that holds p, if it removed one that does.
  [[nodiscard]] std::uint32_t part_with(std::uint32_t node, LatticePoint p) const {
    const std::uint32_t first = history_.first_made[node];
    const std::uint32_t end = node + 1 < history_.first_made.size()
                                  ? history_.first_made[node + 1]
                                  : static_cast<std::uint32_t>(history_.triangles.size());
    for (std::uint32_t t = first; t + 1 < end; ++t)
      if (holds(corners_of(t), p)) return t;
    return end - 1;
  }

  [[nodiscard]] LatticeCorners corners_of(std::uint32_t t) const {
    const auto& [a, b, c] = history_.triangles[t].corner;
    return {history_.vertices[a], history_.vertices[b], history_.vertices[c]};
  }

  [[nodiscard]] Error not_insertable(std::uint32_t node) const {
    const LatticePoint p = points_[n_base() + node];
    return fail(
        "{}: node {}: expected column {}, row {} in a triangle of its time that it can be inserted "
        "into",
        file_.path(), node, p.x, p.y);
  }

  /// They are read page by page, and triangles are numbered by time.
  void take_errors() {
    const std::uint32_t n = file_.base().n_base_triangles();
    for (std::uint32_t t = 0; t < n; ++t)
      history_.triangles[t].error = file_.base().triangles[t].error;
    std::size_t at = 0;
    for (const std::uint32_t node : order_)
      for (std::uint32_t i = 0; i < n_made_[node]; ++i)
        history_.triangles[history_.first_made[node] + i].error = errors_[at++];
  }

  const HistoryFile& file_;
  std::span<const Band> bands_;
  History history_;
  std::vector<LatticePoint> points_;
  std::vector<double> heights_;
  std::vector<std::uint32_t> n_made_;
  std::vector<bool> begins_later_;
  std::vector<std::uint32_t> order_;  ///< Nodes, page by page.
  std::vector<float> errors_;         ///< In that order.
  std::vector<std::uint32_t> way_;    ///< Nodes, page by page, and in a page along a curve.
  std::vector<std::array<std::uint32_t, 3>> base_;
  std::optional<StartFinder> start_;
  std::vector<std::uint32_t> slot_of_;    ///< By triangle.
  std::vector<std::uint32_t> slot_with_;  ///< By node of the band at hand, what holds it.
  std::vector<std::uint32_t> first_in_;   ///< By slot, a node that it holds, or kNone,
  std::vector<std::uint32_t> next_;       ///< and by node the next one.
  std::vector<std::uint32_t> handed_on_;
};

}  // namespace

Result<History> replay(const HistoryFile& file, std::size_t n_bands, Progress& progress) {
  return Replay(file, file.bands().first(n_bands)).run(progress);
}

Result<LevelledHistory> open(const std::string& path, Progress& progress) {
  LODE_TRY(const HistoryFile file, HistoryFile::open(path));
  LODE_TRY(History history, replay(file, file.bands().size(), progress));
  return LevelledHistory{std::move(history), file.levels(), file.facts()};
}

}  // namespace lode::insertions
