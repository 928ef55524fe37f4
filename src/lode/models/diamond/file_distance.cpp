// Distances of files' surfaces, window by window.

#include <cmath>
#include <limits>
#include <vector>

#include "lode/models/diamond/distance_cut.h"
#include "lode/models/diamond/kept_nodes.h"
#include "lode/models/diamond/open_bricks.h"
#include "lode/models/diamond/part_window.h"
#include "lode/models/diamond/read_region.h"
#include "lode/models/diamond/sample_scale.h"
#include "lode/models/diamond/selection.h"
#include "lode/models/diamond/world_block.h"

namespace lode::diamond {
namespace {

class FileDistance {
 public:
  FileDistance(const CoarseField<3>& field, store::BlockCache& blocks, FileDistanceQuery query,
               Progress& progress)
      : field_(field),
        blocks_(blocks),
        query_(std::move(query)),
        progress_(progress),
        selection_(field, query_.surface.isovalue, query_.surface.tolerance),
        n_chunks_(chunk_counts<3>(field.shape)),
        bricks_(field.shape, field.info.grid, query_.max_distance,
                [this](const Index<3>& brick) { return is_met(brick); }),
        part_(field, blocks, query_.surface.threads) {}

  Result<DistanceCut> run() {
    refine_coarse();
    const bool has_worlds = diamond::has_worlds(blocks_.reader());
    if (has_worlds) LODE_CHECK(guess(coarse_blocks<3>(field_.shape), selection_, {}));
    LODE_TRY(bool was_open, hold_open_chunks(has_worlds));
    while (was_open) {
      LODE_TRY(was_open, hold_open_chunks(false));
    }
    return DistanceCut{std::move(query_.wanted), report_};
  }

 private:
  /// Of full resolution, with what holding it takes: grid and state of it, and of those of the cut
  /// there.
  static constexpr std::uint64_t kBytesPerFacet = 150;
  static constexpr std::size_t kEndless = std::numeric_limits<std::size_t>::max();

  [[nodiscard]] bool is_met(const Index<3>& brick) const {
    return !field_.is_needed() ||
           any_kept_node<3>(field_.shape, brick, [&](const Index<3>&, std::size_t node) {
             return selection_.is_active(kKeptLevel, node);
           });
  }

  /// All nodes larger than bricks that the surface may cross.
  void refine_coarse() {
    for (int level = kBrickLevel<3> + 1; level < field_.shape.n_levels; ++level) {
      const Index<3> dims = field_.shape.grid_dims(level);
      for (std::size_t i = 0; i < n_points<3>(dims); ++i) {
        const Index<3> centre = point_of<3>(dims, i) * (std::int32_t{1} << level);
        if (common_exponent<3>(centre) == level && field_.shape.is_sample(centre) &&
            selection_.is_active(level, i))
          want(centre);
      }
    }
  }

  void want(const Index<3>& centre) {
    query_.wanted.insert(centre, [&](const Index<3>& p) {
      bricks_.open_near(p);
      ++report_.n_nodes;
    });
  }

  /// As the model in memory begins, from the world errors of some of the file's blocks. `selection`
  /// is of a lattice that begins at `origin`.
  template <typename Selected>
  Result<void> guess(const std::vector<BlockGroup<3>>& groups, const Selected& selection,
                     const Index<3>& origin) {
    const double edge = WorldScales<3>(field_).in_double.edge;
    for (const BlockGroup<3>& group : groups) {
      const Region<3>& r = group.region;
      if (group.is_samples || count_points(r) == 0) continue;
      LODE_TRY(const std::size_t block,
               find_region<3>(blocks_.reader(), r, Kind::worlds, sizeof(WorldCode)));
      LODE_TRY(const auto bytes, blocks_.block(block));
      const Index<3> dims = field_.shape.grid_dims(r.level);
      const Index<3> dims_here = selection.model().shape.grid_dims(r.level);
      for_each_value<WorldCode>(r, dims, bytes->data(), [&](std::size_t i, WorldCode code) {
        const double estimate = static_cast<double>(decode_world(code)) * std::ldexp(edge, r.level);
        if (!(estimate > kFarOffDistances * query_.max_distance)) return;
        const Index<3> centre = point_of<3>(dims, i) * (std::int32_t{1} << r.level);
        if (common_exponent<3>(centre) != r.level || !field_.shape.is_sample(centre)) return;
        Index<3> q = centre - origin;
        for (std::int32_t& x : q.v) x >>= r.level;
        if (selection.is_active(r.level, linear_index<3>(dims_here, q))) want(centre);
      });
    }
    return {};
  }

  /// Each in its turn; whether there were any.
  Result<bool> hold_open_chunks(bool is_guessed) {
    bool was_open = false;
    for (std::size_t i = 0; i < n_points<3>(n_chunks_); ++i) {
      const Index<3> chunk = point_of<3>(n_chunks_, i);
      if (bricks_.open_in(bricks_.of_chunk(chunk)).empty()) continue;
      was_open = true;
      LODE_CHECK(hold_chunk(chunk, is_guessed));
    }
    return was_open;
  }

  /// Holds both surfaces against each other in the open bricks of a chunk until nothing fails
  /// there.
  Result<void> hold_chunk(const Index<3>& chunk, bool is_guessed) {
    const LatticeBox<3> all = bricks_.of_chunk(chunk);
    LODE_CHECK(part_.load(chunk, bricks_.met_in(bricks_.widened(all)), {}));
    part_.fill_beside();
    if (is_guessed) {
      const Selection<3> selection(part_.model(), query_.surface.isovalue,
                                   query_.surface.tolerance);
      LODE_CHECK(guess(chunk_blocks<3>(field_.shape, chunk), selection, part_.origin()));
    }
    std::vector<LatticeBox<3>> waiting{all};
    while (!waiting.empty()) {
      const LatticeBox<3> box = waiting.back();
      waiting.pop_back();
      const std::vector<Index<3>> own = bricks_.open_in(box);
      if (own.empty()) continue;
      const bool is_single = box.edge(0) == 1 && box.edge(1) == 1 && box.edge(2) == 1;
      const auto n_most = static_cast<std::size_t>(query_.window_bytes / kBytesPerFacet);
      PartWindow window({field_, part_}, query_.surface, bricks_in(box), query_.wanted,
                        [this](const Index<3>& centre) { bricks_.open_near(centre); });
      if (!window.find_full(is_single ? kEndless : n_most, progress_)) {
        halve(box, waiting);
        continue;
      }
      for (const Index<3>& brick : own) bricks_.set_held(brick);
      report_.n_full_triangles += window.n_first();
      window.set_share_done(bricks_.share_closed());
      LODE_CHECK(search(window));
      for (const Index<3>& brick : own) bricks_.close(brick);
      LODE_CHECK(check_memory());
    }
    return {};
  }

  Result<void> search(PartWindow& window) {
    LODE_TRY(const auto held,
             search_distance(window, query_.max_distance, query_.surface.threads, progress_));
    report_.proven = std::max(report_.proven, held.proven);
    report_.n_rounds += held.n_rounds;
    report_.n_nodes += held.n_nodes;
    report_.n_lost += held.n_lost;
    report_.lost_size = std::max(report_.lost_size, held.lost_size);
    return {};
  }

  /// The open ones and those round them, as the part numbers them.
  [[nodiscard]] PartWindow::Bricks bricks_in(const LatticeBox<3>& box) const {
    const Index<3> first = part_.origin();
    const auto local = [&](Index<3> brick) {
      for (std::size_t i = 0; i < 3; ++i) brick[i] -= first[i] / kBrickEdge<3>;
      return brick;
    };
    const auto is_own = [&](const Index<3>& brick) {
      bool is_inside = true;
      for (std::size_t i = 0; i < 3; ++i)
        is_inside = is_inside && brick[i] >= box.lower[i] && brick[i] < box.upper[i];
      return is_inside && bricks_.at(brick).is_open;
    };
    PartWindow::Bricks bricks;
    bricks.near = {box.upper * kBrickEdge<3>, box.lower * kBrickEdge<3>};
    for (const Index<3>& brick : bricks_.met_in(bricks_.widened(box))) {
      if (is_own(brick)) {
        (bricks_.at(brick).is_held ? bricks.again : bricks.fresh).push_back(local(brick));
        for (std::size_t i = 0; i < 3; ++i) {
          const std::int32_t lower = brick[i] * kBrickEdge<3> - bricks_.seen()[i];
          bricks.near.lower[i] = std::min(bricks.near.lower[i], lower);
          bricks.near.upper[i] =
              std::max(bricks.near.upper[i], lower + kBrickEdge<3> + 2 * bricks_.seen()[i]);
        }
      } else if (!OpenBricks::those_in(bricks_.widened({brick, brick + all_equal<3>(1)}), is_own)
                      .empty()) {
        bricks.round.push_back(local(brick));
      }
    }
    bricks.near = {bricks.near.lower - first, bricks.near.upper - first};
    return bricks;
  }

  /// Along the longest axis; no single brick.
  static void halve(const LatticeBox<3>& box, std::vector<LatticeBox<3>>& out) {
    int axis = 0;
    for (int i = 1; i < 3; ++i)
      if (box.edge(i) > box.edge(axis)) axis = i;
    LatticeBox<3> lower = box;
    LatticeBox<3> upper = box;
    const auto a = as_size(axis);
    upper.lower[a] = lower.upper[a] = (box.lower[a] + box.upper[a]) / 2;
    out.push_back(upper);
    out.push_back(lower);
  }

  [[nodiscard]] Result<void> check_memory() const {
    if (query_.wanted.n_bytes() <= query_.node_bytes) return {};
    return fail(
        "max_distance: expected at most {} MB for the nodes that it takes, got {} MB: a higher "
        "memory limit or a larger distance leaves room for them",
        query_.node_bytes / 1'000'000, query_.wanted.n_bytes() / 1'000'000 + 1);
  }

  const CoarseField<3>& field_;
  store::BlockCache& blocks_;
  FileDistanceQuery query_;
  Progress& progress_;
  Selection<3, CoarseField<3>> selection_;
  Index<3> n_chunks_;
  OpenBricks bricks_;
  FilePart<3> part_;
  DistanceCutReport report_;
};

}  // namespace

Result<DistanceCut> find_distance_cut(const CoarseField<3>& field, store::BlockCache& blocks,
                                      FileDistanceQuery query, Progress& progress) {
  LODE_EXPECTS(field.shape.n_levels > kBrickLevel<3>);
  return FileDistance(field, blocks, std::move(query), progress).run();
}

}  // namespace lode::diamond
