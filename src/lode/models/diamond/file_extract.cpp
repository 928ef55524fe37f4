#include "lode/models/diamond/file_extract.h"

#include <algorithm>
#include <memory>

#include "lode/core/stopwatch.h"
#include "lode/models/diamond/brick_isosurface.h"
#include "lode/models/diamond/brick_work.h"
#include "lode/models/diamond/normals.h"

namespace lode::diamond {
namespace {

/// Normals at a part's points: along edges that coarse samples are at the ends of from these, else
/// from `samples`, whose lattice begins at `origin`.
template <int D, typename T>
class PartNormals {
 public:
  PartNormals(const CoarseField<D>& field, const FlatField<D>* samples, const Index<D>& origin)
      : coarse_(field), origin_(field.axes.to_grid(origin)) {
    if (samples != nullptr) fine_.emplace(*samples);
  }

  [[nodiscard]] Vec3f at(const EdgePoint& point) const {
    const Index3 first = to_point(point.first);
    const Index3 second = to_point(point.second);
    std::int32_t step = 0;
    for (std::size_t i = 0; i < 3; ++i) step = std::max(step, std::abs(first[i] - second[i]));
    if (step >= 1 << kKeptLevel) return coarse_.at(point);
    return fine_->at({to_key(first - origin_), to_key(second - origin_), point.t});
  }

 private:
  NormalSampler<D, T, CoarseField<D>> coarse_;
  std::optional<NormalSampler<D, T, FlatField<D>>> fine_;
  Index3 origin_;
};

template <int D>
class FileExtraction {
 public:
  FileExtraction(const CoarseField<D>& field, store::BlockCache& blocks,
                 const IsosurfaceQuery& query, SurfaceSink& surface)
      : field_(field),
        query_(query),
        frame_(LatticeFrame::of(field.info.grid)),
        selection_(field, query.isovalue, query.tolerance),
        brick_dims_(brick_counts<D>(field.shape)),
        part_(field, blocks, query.threads),
        stitcher_(frame_, surface.n_vertices(), query.threads),
        surface_(surface) {}

  Result<IsosurfaceReport> run(Progress& progress) {
    const Stopwatch watch;
    if (field_.shape.has_cells())
      CoarseTraversal<D, Selection<D, CoarseField<D>>>(selection_, cut_).run();
    work_ = work_of(cut_);
    parts_of_bricks_ = PartsOfBricks<D>(field_.axes, brick_dims_, work_);
    stats_ = cut_.stats;
    LODE_CHECK(join(march_coarse(), 0));
    Bricks bricks = bricks_of(0);
    for (std::size_t i = 0; i < work_.size();) {
      if (progress.is_cancelled()) return cancelled_error();
      const std::size_t end = end_of_chunk(i);
      LODE_CHECK(part_.load(chunk_at(i), bricks.fine, bricks.coarse));
      // The system reads the next chunk's blocks while this one is marched.
      bricks = bricks_of(end);
      if (end < work_.size()) part_.will_load(chunk_at(end), bricks.fine);
      const auto parts = march_chunk(i, end);
      LODE_CHECK(join(parts, i + 1));
      forget_below(end);
      i = end;
      progress.report("extracting", static_cast<double>(i) / static_cast<double>(work_.size()));
    }
    IsosurfaceReport report = report_of(largest_, stats_, frame_);
    report.geometry_seconds = joining_seconds_;
    report.select_seconds = watch.seconds() - joining_seconds_;
    return report;
  }

 private:
  struct Worker {
    Worker(const Selection<D>& selection, const FileExtraction& e)
        : traversal(selection), mapper(e.frame_, e.query_.isovalue) {}

    BrickTraversal<D> traversal;
    BrickIsosurface<D> mapper;
  };

  [[nodiscard]] Index<D> brick_of(std::size_t work) const {
    return point_of<D>(brick_dims_, work_[work].brick);
  }
  struct Bricks {
    std::vector<Index<D>> fine;
    std::vector<Index<D>> coarse;
  };
  /// Of the chunk that `begin` is in, from there on.
  [[nodiscard]] Bricks bricks_of(std::size_t begin) const {
    Bricks bricks;
    for (std::size_t i = begin, end = end_of_chunk(begin); i < end; ++i) {
      const Index<D> brick = brick_of(i);
      (is_fine(brick) ? bricks.fine : bricks.coarse).push_back(brick);
    }
    return bricks;
  }
  [[nodiscard]] Index<D> chunk_at(std::size_t work) const {
    return point_of<D>(chunk_counts<D>(field_.shape), chunk_of(work));
  }
  [[nodiscard]] std::size_t chunk_of(std::size_t work) const {
    return chunk_of_brick<D>(field_.shape, brick_of(work));
  }
  /// Behind the last work of the chunk that `begin` is in.
  [[nodiscard]] std::size_t end_of_chunk(std::size_t begin) const {
    std::size_t end = begin;
    while (end < work_.size() && chunk_of(end) == chunk_of(begin)) ++end;
    return end;
  }

  std::vector<StitchPart<D>> march_coarse() {
    std::vector<StitchPart<D>> parts(1);
    SimplexIsosurface<D> mapper(frame_, query_.isovalue, parts[0].part);
    for (const ActiveSimplex<D>& s : cut_.leaves)
      mapper.add(to_lattice<D>(field_.axes, s.vertex, s.value));
    find_shared<D>(parts[0], [](const EdgePoint&) { return true; });
    find_normals(parts[0], nullptr, {});
    return parts;
  }

  /// Whether finer nodes of a brick matter: nodes of level kKeptLevel are refined.
  [[nodiscard]] bool is_fine(const Index<D>& brick) const {
    return !field_.is_needed() || has_fine_node(brick);
  }

  [[nodiscard]] bool has_fine_node(const Index<D>& brick) const {
    const Index<D> dims = field_.shape.grid_dims(kKeptLevel);
    const std::int32_t n = kBrickEdge<D> >> kKeptLevel;
    const Index<D> edges = all_equal<D>(n + 1);
    for (std::size_t i = 0; i < n_points<D>(edges); ++i) {
      const Index<D> q = brick * n + point_of<D>(edges, i);
      std::int32_t odd = 0;
      bool exists = true;
      for (std::size_t a = 0; a < as_size(D); ++a) {
        odd |= q[a] & 1;
        exists = exists && q[a] < dims[a];
      }
      if (odd == 0 || !exists) continue;
      const std::size_t at = linear_index<D>(dims, q);
      if (!selection_.is_active(kKeptLevel, at)) continue;
      if (selection_.exceeds_tolerance(selection_.error(kKeptLevel, at)) ||
          field_.shape.reaches_across(q * (std::int32_t{1} << kKeptLevel), kKeptLevel))
        return true;
    }
    return false;
  }

  /// The parts of work begin .. end - 1, all in the chunk that is loaded.
  std::vector<StitchPart<D>> march_chunk(std::size_t begin, std::size_t end) {
    const Selection<D> selection(part_.model(), query_.isovalue, query_.tolerance);
    std::vector<StitchPart<D>> parts(end - begin);
    std::vector<TraversalStats> stats(end - begin);
    std::vector<std::unique_ptr<Worker>> workers(as_size(n_workers(query_.threads)));
    parallel_for(end - begin, query_.threads, 1, [&](std::size_t i, int number) {
      auto& worker = workers[as_size(number)];
      if (!worker) worker = std::make_unique<Worker>(selection, *this);
      march_brick(*worker, begin + i, parts[i], stats[i]);
      find_normals(parts[i], &part_.samples(), part_.origin());
    });
    for (const TraversalStats& s : stats) stats_.join(s);
    return parts;
  }

  void march_brick(Worker& worker, std::size_t i, StitchPart<D>& part, TraversalStats& stats) {
    const Index<D> origin = part_.origin();
    Index<D> local = brick_of(i);
    for (std::size_t a = 0; a < as_size(D); ++a) local[a] -= origin[a] / kBrickEdge<D>;
    worker.traversal.open(local);
    worker.mapper.open(worker.traversal, field_.axes, origin, part.part);
    for (std::size_t s = work_[i].begin; s < work_[i].end; ++s) {
      Simplex<D> simplex = cut_.brick_simplices[s].second;
      for (Index<D>& v : simplex.v) v = v - origin;
      worker.traversal.visit(simplex, stats,
                             [&](const BrickSimplex<D>& leaf) { worker.mapper.add(leaf); });
    }
    find_shared<D>(part, [&](const EdgePoint& p) { return is_on_brick_border<D>(field_.axes, p); });
  }

  void find_normals(StitchPart<D>& part, const FlatField<D>* samples, const Index<D>& origin) {
    if (!query_.with_normals) return;
    visit_storage_type(field_.storage, [&]<typename T>() {
      const PartNormals<D, T> normals(field_, samples, origin);
      part.normals.reserve(part.part.points.size());
      for (const EdgePoint& point : part.part.points) part.normals.push_back(normals.at(point));
    });
  }

  /// Passes on the surface of parts `first` and following: everything coarser than bricks, or those
  /// of a chunk's bricks.
  Result<void> join(const std::vector<StitchPart<D>>& parts, std::size_t first) {
    const Stopwatch watch;
    largest_.add(parts);
    const auto candidates = [&](LatticeKey key, std::vector<std::uint32_t>& out) {
      parts_of_bricks_.candidates(key, out);
      std::erase_if(out, [&](std::uint32_t part) { return part < first; });
      for (std::uint32_t& part : out) part -= static_cast<std::uint32_t>(first);
      std::erase_if(out, [&](std::uint32_t part) { return part >= parts.size(); });
    };
    const bool is_coarse = first == 0;
    LODE_TRY(SurfacePiece piece, stitcher_.join(parts, candidates, [&](LatticeKey key) {
      return is_coarse || is_on_chunk_border(key);
    }));
    LODE_CHECK(surface_.add(std::move(piece)));
    joining_seconds_ += watch.seconds();
    return {};
  }

  [[nodiscard]] bool is_on_chunk_border(LatticeKey doubled_midpoint) const {
    const Index3 doubled = to_point(doubled_midpoint);
    return std::any_of(field_.axes.axis.begin(), field_.axes.axis.end(),
                       [&](int axis) { return doubled[as_size(axis)] % (2 * kChunkEdge<D>) == 0; });
  }

  /// Vertices below all chunks from work `next` on, which they are ordered by, are not shared any
  /// more.
  void forget_below(std::size_t next) {
    if (next == work_.size()) return;
    const std::size_t last = as_size(D) - 1;
    const std::int32_t layer = point_of<D>(chunk_counts<D>(field_.shape), chunk_of(next))[last];
    if (layer == layer_) return;
    layer_ = layer;
    const auto axis = as_size(field_.axes.axis[last]);
    stitcher_.forget_all_but(
        [&](LatticeKey key) { return to_point(key)[axis] >= 2 * layer * kChunkEdge<D>; });
  }

  const CoarseField<D>& field_;
  IsosurfaceQuery query_;
  LatticeFrame frame_;
  Selection<D, CoarseField<D>> selection_;
  Index<D> brick_dims_;
  FilePart<D> part_;
  CoarseCut<D> cut_;
  std::vector<BrickWork<D>> work_;
  PartsOfBricks<D> parts_of_bricks_;
  PieceStitcher<D> stitcher_;
  SurfaceSink& surface_;
  std::int32_t layer_ = 0;  ///< Of chunks, that vertices are kept for.
  TraversalStats stats_;
  LargestSteps largest_;
  double joining_seconds_ = 0;
};

}  // namespace

template <int D>
Result<IsosurfaceReport> extract_from_file(const CoarseField<D>& field, store::BlockCache& blocks,
                                           const IsosurfaceQuery& query, SurfaceSink& surface,
                                           Progress& progress) {
  return FileExtraction<D>(field, blocks, query, surface).run(progress);
}

template Result<IsosurfaceReport> extract_from_file<2>(const CoarseField<2>&, store::BlockCache&,
                                                       const IsosurfaceQuery&, SurfaceSink&,
                                                       Progress&);
template Result<IsosurfaceReport> extract_from_file<3>(const CoarseField<3>&, store::BlockCache&,
                                                       const IsosurfaceQuery&, SurfaceSink&,
                                                       Progress&);

}  // namespace lode::diamond
