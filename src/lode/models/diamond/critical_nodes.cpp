#include "lode/models/diamond/critical_nodes.h"

#include <mutex>
#include <vector>

#include "lode/models/diamond/brick_work.h"
#include "lode/models/diamond/kept_nodes.h"
#include "lode/models/diamond/persistent_nodes.h"
#include "lode/models/diamond/selection.h"
#include "lode/models/diamond/side_box.h"

namespace lode::diamond {
namespace {

/// `Field`: has the nodes of levels kKeptLevel and coarser, and their samples. Finer nodes are
/// found brick by brick, coarser ones on the grid of that level.
template <typename Field>
class CriticalSearch {
 public:
  CriticalSearch(const Field& field, const CriticalQuery& query, const Progress& progress)
      : field_(field),
        query_(query),
        progress_(progress),
        selection_(field, query.isovalue, 0),
        critical_{NodeSet<3>(field.shape)} {}

  /// Whether finer nodes with a centre in a brick may be critical.
  [[nodiscard]] bool is_met(const Index<3>& brick) const {
    if (field_.shape.n_levels <= kKeptLevel) return true;
    return any_kept_node<3>(field_.shape, brick, [&](const Index<3>&, std::size_t at) {
      return selection_.is_active(kKeptLevel, at);
    });
  }

  void find_coarse() {
    const int n_levels = field_.shape.n_levels - kKeptLevel;
    if (n_levels <= 0) return;
    LatticeBox<3> all{{}, {}};
    for (std::size_t i = 0; i < 3; ++i)
      all.upper[i] = ((field_.shape.dims[i] - 1) >> kKeptLevel) + 1;
    SideBox sides(query_.isovalue);
    sides.open(all.upper, all);
    parallel_for(sides.n_rows(), query_.threads, 64,
                 [&](std::size_t row, int) { sides.fill_row(field_, row, kStep); });
    const auto n_layers = as_size(all.upper[2]);
    parallel_for(n_layers, query_.threads, 1, [&](std::size_t z, int) {
      if (progress_.is_cancelled()) return;
      LatticeBox<3> layer = all;
      layer.lower[2] = static_cast<std::int32_t>(z);
      layer.upper[2] = layer.lower[2] + 1;
      std::vector<Index<3>> found;
      for (int level = 0; level < n_levels; ++level) sides.find(level, layer, found);
      for (Index<3>& centre : found) centre = centre * kStep;
      add(found, {});
    });
  }

  /// The finer ones of some bricks of a part of the field that begins at `origin`: their samples
  /// and those round them are there.
  template <typename Samples>
  void find_fine(const Samples& samples, std::span<const Index<3>> bricks, const Index<3>& origin) {
    const int n_levels = std::min(field_.shape.n_levels, kKeptLevel);
    const Index<3>& dims = samples.shape.dims;
    std::vector<SideBox> workers(as_size(n_workers(query_.threads)), SideBox(query_.isovalue));
    parallel_for(bricks.size(), query_.threads, 1, [&](std::size_t i, int number) {
      if (progress_.is_cancelled()) return;
      const LatticeBox<3> brick = own_centres(bricks[i], dims);
      LatticeBox<3> round;
      for (std::size_t a = 0; a < 3; ++a) {
        round.lower[a] = std::max(brick.lower[a] - kReach, 0);
        round.upper[a] = std::min(brick.upper[a] + kReach, dims[a]);
      }
      SideBox& sides = workers[as_size(number)];
      sides.open(dims, round);
      for (std::size_t row = 0; row < sides.n_rows(); ++row) sides.fill_row(samples, row, 1);
      std::vector<Index<3>> found;
      for (int level = 0; level < n_levels; ++level) sides.find(level, brick, found);
      add(found, origin);
    });
  }

  [[nodiscard]] const NodeSet<3>& nodes() const { return critical_.nodes; }
  [[nodiscard]] CriticalNodes take() { return std::move(critical_); }

 private:
  static constexpr std::int32_t kStep = 1 << kKeptLevel;
  /// Of the stars of finer nodes.
  static constexpr std::int32_t kReach = kStep / 2;
  static_assert(kReach <= FilePart<3>::kMargin);

  void add(const std::vector<Index<3>>& found, const Index<3>& origin) {
    if (found.empty()) return;
    const std::lock_guard lock(mutex_);  // a set, whatever the order
    critical_.n_critical += found.size();
    for (const Index<3>& centre : found)
      critical_.nodes.insert(centre + origin, [&](const Index<3>&) { ++critical_.n_nodes; });
  }

  const Field& field_;
  CriticalQuery query_;
  const Progress& progress_;
  Selection<3, Field> selection_;
  std::mutex mutex_;
  CriticalNodes critical_;
};

}  // namespace

Result<CriticalNodes> find_critical_nodes(const Model<3>& model, const CriticalQuery& query,
                                          Progress& progress) {
  if (query.persistence > 0) return find_persistent_nodes(model, query, progress);
  CriticalSearch<Model<3>> search(model, query, progress);
  if (!model.shape.has_cells()) return search.take();
  search.find_coarse();
  std::vector<Index<3>> bricks;
  for (std::size_t i = 0; i < model.n_bricks(); ++i) {
    const Index<3> brick = point_of<3>(model.brick_dims, i);
    if (search.is_met(brick)) bricks.push_back(brick);
  }
  search.find_fine(model, bricks, {});
  if (progress.is_cancelled()) return cancelled_error();
  return search.take();
}

Result<CriticalNodes> find_critical_nodes(const CoarseField<3>& field, store::BlockCache& blocks,
                                          const CriticalQuery& query, Progress& progress) {
  if (query.persistence > 0) return find_persistent_nodes(field, blocks, query, progress);
  CriticalSearch<CoarseField<3>> search(field, query, progress);
  if (!field.shape.has_cells()) return search.take();
  search.find_coarse();
  const Index<3> brick_dims = brick_counts<3>(field.shape);
  std::vector<std::vector<Index<3>>> bricks(n_points<3>(chunk_counts<3>(field.shape)));
  for (std::size_t i = 0; i < n_points<3>(brick_dims); ++i) {
    const Index<3> brick = point_of<3>(brick_dims, i);
    if (search.is_met(brick)) bricks[chunk_of_brick<3>(field.shape, brick)].push_back(brick);
  }
  FilePart<3> part(field, blocks, query.threads);
  for (std::size_t chunk = 0; chunk < bricks.size(); ++chunk) {
    if (progress.is_cancelled()) return cancelled_error();
    if (bricks[chunk].empty()) continue;
    const auto position = [&](std::size_t number) {
      return point_of<3>(chunk_counts<3>(field.shape), number);
    };
    LODE_CHECK(part.load_samples(position(chunk), bricks[chunk]));
    if (chunk + 1 < bricks.size()) part.will_load(position(chunk + 1), bricks[chunk + 1]);
    search.find_fine(part.samples(), part.fine(), part.origin());
    if (search.nodes().n_bytes() > query.max_bytes)
      return fail(
          "keeping the topology: expected at most {} MB for the nodes that it takes, got {} MB "
          "after {} of {} chunks: a higher memory limit, or a persistence, leaves room for them",
          query.max_bytes / 1'000'000, search.nodes().n_bytes() / 1'000'000 + 1, chunk + 1,
          bricks.size());
    progress.report("finding critical nodes",
                    static_cast<double>(chunk + 1) / static_cast<double>(bricks.size()));
  }
  if (progress.is_cancelled()) return cancelled_error();
  return search.take();
}

}  // namespace lode::diamond
