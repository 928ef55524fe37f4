#include "lode/models/terrain/insertions/replay.h"

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "lode/delaunay/lattice_side.h"
#include "lode/models/terrain/insertions/node_columns.h"
#include "lode/models/terrain/insertions/overlap.h"
#include "lode/models/terrain/insertions/recorder.h"
#include "lode/models/terrain/insertions/start_finder.h"
#include "lode/models/terrain/insertions/waiting_nodes.h"

namespace lode::insertions {
namespace {

using delaunay::InsertionRule;
using delaunay::LatticePoint;

/// Inserts nodes that a file has again.
class Replay {
 public:
  Replay(const HistoryFile& file, std::span<const Band> bands) : file_(file), bands_(bands) {}

  Result<History> run(Progress& progress) {
    LODE_TRY(columns_, NodeColumns::read(file_, bands_.size(), progress));
    begin_history();
    const InsertionRule rule = rule_of(history_.model);
    if (history_.is_of_points) {
      delaunay::PointMesh mesh(delaunay::ListedNodes(columns_.points), base_, rule);
      // Edges of triangles that are split stay without being cut.
      if (rule == InsertionRule::delaunay) mesh.cut(history_.lines);
      LODE_CHECK(insert(mesh, progress, [](std::uint32_t vertex) { return vertex; }));
    } else {
      const delaunay::LatticePacking packing(history_.frame.n_columns);
      const auto pack = [&](std::uint32_t vertex) { return packing.pack(columns_.points[vertex]); };
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
  /// Of the base, as far as the recorder does not make it again.
  void begin_history() {
    const History& base = file_.base();
    static_cast<terrain_file::Source&>(history_) = base;
    history_.model = base.model;
    history_.level_ends = base.level_ends;
    history_.max_error = base.max_error;
    history_.lines = base.lines;
    nodes_ = columns_.in_time();
    history_.heights = base.heights;
    history_.heights.reserve(columns_.heights.size());
    for (const std::uint32_t node : nodes_)
      history_.heights.push_back(columns_.heights[columns_.n_base + node]);
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
    // Beyond it is sooner to come down from the base.
    constexpr int kLongWalk = 256;
    WaitingNodes waiting(columns_);
    for (const Band& band : bands_) {
      const std::uint32_t nowhere = waiting.locate(mesh, band, kNone, kLongWalk,
                                                   [&](LatticePoint p) { return look_down(p); });
      if (nowhere != kNone) return not_insertable(nowhere);
      LODE_CHECK(insert_band(mesh, recorder, band, waiting, progress, number));
    }
    recorder.finish();
    return {};
  }

  /// The slot of the triangle that holds p, down the history from the base.
  [[nodiscard]] std::optional<std::uint32_t> look_down(LatticePoint p) const {
    const auto start = start_->find(delaunay::to_point(p));
    if (!start) return {};
    std::uint32_t t = *start;
    while (history_.triangles[t].death != kNone) t = part_with(history_.triangles[t].death, p);
    return slot_of_[t];
  }

  template <typename Mesh, typename Number>
  Result<void> insert_band(Mesh& mesh, Recorder& recorder, const Band& band, WaitingNodes& waiting,
                           Progress& progress, const Number& number) {
    constexpr std::uint32_t kPerReport = 1U << 16;
    for (std::uint32_t time = band.begin; time < band.end; ++time) {
      if (time % kPerReport == 0) {
        if (progress.is_cancelled()) return cancelled_error();
        progress.report("inserting", static_cast<double>(time) / columns_.n_nodes());
      }
      const std::uint32_t node = nodes_[time];
      const std::uint32_t vertex = columns_.n_base + node;
      const auto seed = waiting.find_seed(
          mesh, node, [&](std::uint32_t slot) { return recorder.triangle_in(slot); });
      std::span<const std::uint32_t> slots;
      const std::size_t n_before = mesh.triangles().size();
      if (!seed || !mesh.try_insert(number(vertex), *seed, slots)) return not_insertable(node);
      if (slots.size() != columns_.n_made[node])
        return fail("{}: node {}: expected it to make {} triangles, got {}", file_.path(), time,
                    columns_.n_made[node], slots.size());
      const std::size_t n_removed = slots.size() - (mesh.triangles().size() - n_before);
      recorder.add_node(mesh, columns_.points[vertex], slots, n_removed);
      waiting.hand_on(mesh, node, slots, n_removed);
      slot_of_.insert(slot_of_.end(), slots.begin(), slots.end());
    }
    return {};
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
    return columns_.not_insertable(file_, node);
  }

  /// Triangles are numbered by time.
  void take_errors() {
    const std::uint32_t n = file_.base().n_base_triangles();
    for (std::uint32_t t = 0; t < n; ++t)
      history_.triangles[t].error = file_.base().triangles[t].error;
    for (std::uint32_t node = 0; node < columns_.n_nodes(); ++node)
      for (std::uint32_t i = 0; i < columns_.n_made[node]; ++i)
        history_.triangles[history_.first_made[columns_.times[node]] + i].error =
            columns_.errors[columns_.first_error[node] + i];
  }

  const HistoryFile& file_;
  std::span<const Band> bands_;
  History history_;
  NodeColumns columns_;
  std::vector<std::uint32_t> nodes_;  ///< By time.
  std::vector<std::array<std::uint32_t, 3>> base_;
  std::optional<StartFinder> start_;
  std::vector<std::uint32_t> slot_of_;  ///< By triangle.
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
