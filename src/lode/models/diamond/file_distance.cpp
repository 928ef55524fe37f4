// Distances of files' surfaces, window by window.

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "lode/models/diamond/distance_cut.h"
#include "lode/models/diamond/kept_nodes.h"
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
        brick_dims_(brick_counts<3>(field.shape)),
        n_chunks_(chunk_counts<3>(field.shape)),
        part_(field, blocks, query_.surface.threads),
        bricks_(n_points<3>(brick_dims_)) {
    find_reach();
  }

  Result<DistanceCut> run() {
    find_met();
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

  struct Brick {
    bool is_met = false;   ///< By the surface, perhaps.
    bool is_open = false;  ///< What it sees of the cut has changed since it was held,
    bool is_held = false;  ///< as it has been.
  };

  [[nodiscard]] Brick& at(const Index<3>& brick) {
    return bricks_[linear_index<3>(brick_dims_, brick)];
  }
  [[nodiscard]] const Brick& at(const Index<3>& brick) const {
    return bricks_[linear_index<3>(brick_dims_, brick)];
  }

  /// How many steps of the lattice an axis's coordinate may change by within the distance; no more
  /// than matters. Round a window a brick is seen; what an own triangle is proven by may be as far
  /// from it as the other end of that.
  void find_reach() {
    const RegularGrid& grid = field_.info.grid;
    const Vec3d first = grid.to_index({});
    for (std::size_t i = 0; i < 3; ++i) {
      double squared = 0;
      for (std::size_t j = 0; j < 3; ++j) {
        Vec3d p;
        p[j] = 1;
        const double change = grid.to_index(p)[i] - first[i];
        squared += change * change;
      }
      const double steps = std::ceil(std::sqrt(squared) * query_.max_distance * (1 + 1e-6)) + 1;
      const auto at_most = [&](std::int32_t most) {
        return static_cast<std::int32_t>(std::min<double>(most, steps));
      };
      seen_[i] = at_most(kBrickEdge<3>);
      reach_[i] = at_most(kChunkEdge<3> + kBrickEdge<3>);
    }
  }

  void find_met() {
    for (std::size_t i = 0; i < bricks_.size(); ++i) {
      bricks_[i].is_met =
          !field_.is_needed() || any_kept_node<3>(field_.shape, point_of<3>(brick_dims_, i),
                                                  [&](const Index<3>&, std::size_t node) {
                                                    return selection_.is_active(kKeptLevel, node);
                                                  });
      bricks_[i].is_open = bricks_[i].is_met;
    }
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
      open_near(p);
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

  [[nodiscard]] LatticeBox<3> bricks_of(const Index<3>& chunk) const {
    constexpr std::int32_t kBricks = kChunkEdge<3> / kBrickEdge<3>;
    LatticeBox<3> box{chunk * kBricks, (chunk + all_equal<3>(1)) * kBricks};
    for (std::size_t i = 0; i < 3; ++i) box.upper[i] = std::min(box.upper[i], brick_dims_[i]);
    return box;
  }
  /// With a brick more on all sides.
  [[nodiscard]] LatticeBox<3> widened(LatticeBox<3> box) const {
    for (std::size_t i = 0; i < 3; ++i) {
      box.lower[i] = std::max(box.lower[i] - 1, 0);
      box.upper[i] = std::min(box.upper[i] + 1, brick_dims_[i]);
    }
    return box;
  }
  template <typename Is>
  [[nodiscard]] static std::vector<Index<3>> those_in(const LatticeBox<3>& box, const Is& is) {
    std::vector<Index<3>> bricks;
    const Index<3> n = box.upper - box.lower;
    for (std::size_t i = 0; i < n_points<3>(n); ++i)
      if (const Index<3> brick = box.lower + point_of<3>(n, i); is(brick)) bricks.push_back(brick);
    return bricks;
  }
  [[nodiscard]] std::vector<Index<3>> open_in(const LatticeBox<3>& box) const {
    return those_in(box, [&](const Index<3>& brick) { return at(brick).is_open; });
  }
  [[nodiscard]] std::vector<Index<3>> met_in(const LatticeBox<3>& box) const {
    return those_in(box, [&](const Index<3>& brick) { return at(brick).is_met; });
  }

  /// Each in its turn; whether there were any.
  Result<bool> hold_open_chunks(bool is_guessed) {
    bool was_open = false;
    for (std::size_t i = 0; i < n_points<3>(n_chunks_); ++i) {
      const Index<3> chunk = point_of<3>(n_chunks_, i);
      if (open_in(bricks_of(chunk)).empty()) continue;
      was_open = true;
      LODE_CHECK(hold_chunk(chunk, is_guessed));
    }
    return was_open;
  }

  /// Holds both surfaces against each other in the open bricks of a chunk until nothing fails
  /// there.
  Result<void> hold_chunk(const Index<3>& chunk, bool is_guessed) {
    const LatticeBox<3> all = bricks_of(chunk);
    LODE_CHECK(part_.load(chunk, met_in(widened(all)), {}));
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
      const std::vector<Index<3>> own = open_in(box);
      if (own.empty()) continue;
      const bool is_single = box.edge(0) == 1 && box.edge(1) == 1 && box.edge(2) == 1;
      const auto n_most = static_cast<std::size_t>(query_.window_bytes / kBytesPerFacet);
      PartWindow window({field_, part_}, query_.surface, bricks_in(box), query_.wanted,
                        [this](const Index<3>& centre) { open_near(centre); });
      if (!window.find_full(is_single ? kEndless : n_most, progress_)) {
        halve(box, waiting);
        continue;
      }
      for (const Index<3>& brick : own) at(brick).is_held = true;
      report_.n_full_triangles += window.n_first();
      window.set_share_done(share_closed());
      LODE_CHECK(search(window));
      for (const Index<3>& brick : own) at(brick).is_open = false;
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
      return is_inside && at(brick).is_open;
    };
    PartWindow::Bricks bricks;
    bricks.near = {box.upper * kBrickEdge<3>, box.lower * kBrickEdge<3>};
    for (const Index<3>& brick : met_in(widened(box))) {
      if (is_own(brick)) {
        (at(brick).is_held ? bricks.again : bricks.fresh).push_back(local(brick));
        for (std::size_t i = 0; i < 3; ++i) {
          const std::int32_t lower = brick[i] * kBrickEdge<3> - seen_[i];
          bricks.near.lower[i] = std::min(bricks.near.lower[i], lower);
          bricks.near.upper[i] =
              std::max(bricks.near.upper[i], lower + kBrickEdge<3> + 2 * seen_[i]);
        }
      } else if (!those_in(widened({brick, brick + all_equal<3>(1)}), is_own).empty()) {
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

  /// Bricks that see how a new node changes the cut are open.
  void open_near(const Index<3>& centre) {
    const std::int32_t h = std::int32_t{1} << common_exponent<3>(centre);
    LatticeBox<3> near;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::int32_t reach = h + reach_[i];
      near.lower[i] = std::min(std::max(centre[i] - reach, 0) / kBrickEdge<3>, brick_dims_[i] - 1);
      near.upper[i] = std::min((centre[i] + reach) / kBrickEdge<3>, brick_dims_[i] - 1) + 1;
    }
    const Index<3> n = near.upper - near.lower;
    for (std::size_t i = 0; i < n_points<3>(n); ++i) {
      Brick& brick = at(near.lower + point_of<3>(n, i));
      brick.is_open = brick.is_met;
    }
  }

  [[nodiscard]] double share_closed() const {
    const auto n = std::ranges::count_if(bricks_, [](const Brick& brick) { return brick.is_open; });
    return 1 - static_cast<double>(n) / static_cast<double>(bricks_.size());
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
  Index<3> brick_dims_;
  Index<3> n_chunks_;
  Index<3> seen_;   ///< Of full resolution, round a window.
  Index<3> reach_;  ///< Round a new node's star.
  FilePart<3> part_;
  std::vector<Brick> bricks_;
  DistanceCutReport report_;
};

}  // namespace

Result<DistanceCut> find_distance_cut(const CoarseField<3>& field, store::BlockCache& blocks,
                                      FileDistanceQuery query, Progress& progress) {
  LODE_EXPECTS(field.shape.n_levels > kBrickLevel<3>);
  return FileDistance(field, blocks, std::move(query), progress).run();
}

}  // namespace lode::diamond
