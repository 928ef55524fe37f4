#include "lode/models/diamond/file_extract.h"

#include <chrono>
#include <memory>

#include "lode/models/diamond/brick_isosurface.h"
#include "lode/models/diamond/brick_work.h"
#include "lode/models/diamond/normals.h"

namespace lode::diamond {
namespace {

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

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
                 const IsosurfaceQuery& query)
      : field_(field),
        query_(query),
        frame_(LatticeFrame::of(field.info.grid)),
        selection_(field, query.isovalue, query.tolerance),
        brick_dims_(brick_counts<D>(field.shape)),
        part_(field, blocks, query.threads) {}

  Result<IsosurfaceReport> run(Surface& surface, Progress& progress) {
    const auto start = std::chrono::steady_clock::now();
    if (query_.replaces) surface.clear();
    surface.origin = frame_.surface_origin;
    if (!field_.shape.has_cells()) return IsosurfaceReport();
    CoarseTraversal<D, CoarseField<D>>(selection_, cut_).run();
    work_ = work_of(cut_);
    parts_.resize(work_.size() + 1);
    normals_.resize(parts_.size());
    stats_ = cut_.stats;
    march_coarse();
    for (std::size_t i = 0; i < work_.size();) {
      if (progress.is_cancelled()) return cancelled_error();
      std::size_t end = i;
      while (end < work_.size() && chunk_of(end) == chunk_of(i)) ++end;
      LODE_CHECK(march_chunk(i, end));
      i = end;
      progress.report("extracting", static_cast<double>(i) / static_cast<double>(work_.size()));
    }
    const double select_seconds = seconds_since(start);
    const auto marched = std::chrono::steady_clock::now();
    LODE_CHECK(join(surface));
    IsosurfaceReport report = report_of<D>(parts_, stats_, frame_);
    report.select_seconds = select_seconds;
    report.geometry_seconds = seconds_since(marched);
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
  [[nodiscard]] std::size_t chunk_of(std::size_t work) const {
    return chunk_of_brick<D>(field_.shape, brick_of(work));
  }

  void march_coarse() {
    SimplexIsosurface<D> mapper(frame_, query_.isovalue, parts_[0].part);
    for (const ActiveSimplex<D>& s : cut_.leaves)
      mapper.add(to_lattice<D>(field_.axes, s.vertex, s.value));
    find_shared<D>(parts_[0], [](const EdgePoint&) { return true; });
    find_normals(0, nullptr, {});
  }

  /// Whether a brick has nodes of level kKeptLevel that are refined: only then finer ones matter.
  [[nodiscard]] bool is_fine(const Index<D>& brick) const {
    if (!field_.is_needed()) return true;
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
          field_.shape.reaches_across(q * (1 << kKeptLevel), kKeptLevel))
        return true;
    }
    return false;
  }

  /// Of work begin .. end - 1, all in one chunk.
  Result<void> march_chunk(std::size_t begin, std::size_t end) {
    std::vector<Index<D>> fine;
    std::vector<Index<D>> coarse;
    for (std::size_t i = begin; i < end; ++i) {
      const Index<D> brick = brick_of(i);
      (is_fine(brick) ? fine : coarse).push_back(brick);
    }
    LODE_CHECK(
        part_.load(point_of<D>(chunk_counts<D>(field_.shape), chunk_of(begin)), fine, coarse));
    const Selection<D> selection(part_.model(), query_.isovalue, query_.tolerance);
    std::vector<TraversalStats> stats(end - begin);
    std::vector<std::unique_ptr<Worker>> workers(as_size(n_workers(query_.threads)));
    parallel_for(end - begin, query_.threads, 1, [&](std::size_t i, int number) {
      auto& worker = workers[as_size(number)];
      if (!worker) worker = std::make_unique<Worker>(selection, *this);
      march_brick(*worker, begin + i, stats[i]);
      find_normals(begin + i + 1, &part_.samples(), part_.origin());
    });
    for (const TraversalStats& s : stats) stats_.join(s);
    return {};
  }

  void march_brick(Worker& worker, std::size_t i, TraversalStats& stats) {
    const Index<D> origin = part_.origin();
    Index<D> local = brick_of(i);
    for (std::size_t a = 0; a < as_size(D); ++a) local[a] -= origin[a] / kBrickEdge<D>;
    worker.traversal.open(local);
    worker.mapper.open(worker.traversal, field_.axes, origin, parts_[i + 1].part);
    for (std::size_t s = work_[i].begin; s < work_[i].end; ++s) {
      Simplex<D> simplex = cut_.brick_simplices[s].second;
      for (Index<D>& v : simplex.v) v = v - origin;
      worker.traversal.visit(simplex, stats,
                             [&](const BrickSimplex<D>& leaf) { worker.mapper.add(leaf); });
    }
    find_shared<D>(parts_[i + 1],
                   [&](const EdgePoint& p) { return is_on_brick_border<D>(field_.axes, p); });
  }

  void find_normals(std::size_t part, const FlatField<D>* samples, const Index<D>& origin) {
    if (!query_.with_normals) return;
    visit_storage_type(field_.storage, [&]<typename T>() {
      const PartNormals<D, T> normals(field_, samples, origin);
      normals_[part].reserve(parts_[part].part.points.size());
      for (const EdgePoint& point : parts_[part].part.points)
        normals_[part].push_back(normals.at(point));
    });
  }

  Result<void> join(Surface& surface) {
    const PartsOfBricks<D> parts_of_bricks(field_.axes, brick_dims_, work_);
    std::vector<VertexOrigin> origins;
    const std::size_t first_new = surface.positions.size();
    LODE_CHECK(stitch<D>(
        parts_,
        [&](LatticeKey key, std::vector<std::uint32_t>& out) {
          parts_of_bricks.candidates(key, out);
        },
        frame_, query_.threads, surface, query_.with_normals ? &origins : nullptr));
    if (!query_.with_normals) return {};
    surface.normals.resize(surface.positions.size());
    for (std::size_t v = first_new; v < origins.size(); ++v)
      surface.normals[v] = normals_[origins[v].part][origins[v].vertex];
    return {};
  }

  const CoarseField<D>& field_;
  IsosurfaceQuery query_;
  LatticeFrame frame_;
  Selection<D, CoarseField<D>> selection_;
  Index<D> brick_dims_;
  FilePart<D> part_;
  CoarseCut<D> cut_;
  std::vector<BrickWork<D>> work_;
  std::vector<StitchPart<D>> parts_;  ///< Everything coarser, then one per brick of work_.
  std::vector<std::vector<Vec3f>> normals_;
  TraversalStats stats_;
};

}  // namespace

template <int D>
Result<IsosurfaceReport> extract_from_file(const CoarseField<D>& field, store::BlockCache& blocks,
                                           const IsosurfaceQuery& query, Surface& surface,
                                           Progress& progress) {
  LODE_EXPECTS(!field.has_holes());
  return FileExtraction<D>(field, blocks, query).run(surface, progress);
}

template Result<IsosurfaceReport> extract_from_file<2>(const CoarseField<2>&, store::BlockCache&,
                                                       const IsosurfaceQuery&, Surface&, Progress&);
template Result<IsosurfaceReport> extract_from_file<3>(const CoarseField<3>&, store::BlockCache&,
                                                       const IsosurfaceQuery&, Surface&, Progress&);

}  // namespace lode::diamond
