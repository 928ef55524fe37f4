#include "lode/models/diamond/file_extract.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "lode/core/stopwatch.h"
#include "lode/models/diamond/brick_marcher.h"
#include "lode/models/diamond/chunk_work.h"
#include "lode/models/diamond/inner_gradients.h"
#include "lode/models/diamond/isovalue_list.h"
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
    if (samples == nullptr) return;
    fine_.emplace(*samples);
    if constexpr (D == 3)
      if (!samples->has_holes()) inner_.emplace(*samples);
  }

  void write(std::span<const EdgePoint> points, std::vector<Vec3f>& normals) const {
    normals.resize(points.size());
    write_normals(
        0, points.size(), coarse_.frame(), normals.data(), [&](std::size_t i, double* out) {
          put_gradient(
              points[i], [&](const Index3& p, std::int32_t step, double* at) { find(p, step, at); },
              out);
        });
  }

 private:
  void find(const Index3& p, std::int32_t step, double* out) const {
    if (step >= 1 << kKeptLevel) return coarse_.put(p, step, out);
    if constexpr (D == 3)
      if (inner_ && inner_->find(p - origin_, step, out)) return;
    fine_->put(p - origin_, step, out);
  }

  NormalSampler<D, T, CoarseField<D>> coarse_;
  std::optional<NormalSampler<D, T, FlatField<D>>> fine_;
  std::optional<InnerGradients<T>> inner_;  ///< Where there are no holes.
  Index3 origin_;
};

/// Of the isovalues' surfaces, ascending.
template <int D>
class FileExtraction {
 public:
  FileExtraction(const CoarseField<D>& field, store::BlockCache& blocks,
                 const IsovalueList& isovalues, const IsosurfaceQuery& query,
                 const SinkOfIsovalue& sink_of, const SeePart<D>& see_part)
      : field_(field),
        isovalues_(isovalues),
        query_(query),
        frame_(LatticeFrame::of(field.info.grid)),
        selection_(field, isovalues, query.cut_tolerance(), wanted()),
        part_(field, blocks, query.threads),
        sink_of_(sink_of),
        see_part_(see_part),
        largest_(isovalues.size()),
        surface_bytes_(isovalues.size()) {
    stitchers_.reserve(isovalues.size());
    for (std::size_t i = 0; i < isovalues.size(); ++i) {
      const SurfaceSink* const sink = sink_of(i);
      stitchers_.emplace_back(frame_, sink != nullptr ? sink->n_vertices() : 0, query.threads);
    }
  }

  Result<IsosurfaceReport> run(Progress& progress) {
    const Stopwatch watch;
    LODE_CHECK(check_style<D>(query_, field_.shape));
    if (field_.shape.has_cells()) CoarseTraversal<D, CoarseSelection>(selection_, cut_).run();
    work_ = ChunkWork<D>(field_, selection_, cut_);
    stats_ = cut_.stats;
    for (std::size_t i = 0; i < isovalues_.size(); ++i) {
      std::vector<StitchPart<D>> coarse(1);
      march_coarse<D>(cut_, isovalues_[i], field_.axes, frame_, coarse[0]);
      leave_out_weak(i, coarse[0]);
      find_normals(coarse[0], nullptr, {});
      LODE_CHECK(join(i, coarse, 0));
    }
    typename ChunkWork<D>::Bricks bricks = work_.bricks_of(0, needs_round());
    for (std::size_t i = 0; i < work_.size();) {
      if (progress.is_cancelled()) return cancelled_error();
      const std::size_t end = work_.end_of_chunk(i);
      LODE_CHECK(part_.load(work_.chunk_of(i), bricks.fine, bricks.coarse));
      // The system reads the next chunk's blocks while this one is marched.
      bricks = work_.bricks_of(end, needs_round());
      if (end < work_.size()) part_.will_load(work_.chunk_of(end), bricks.fine);
      LODE_TRY(std::vector<Pieces> pieces, march_chunk(i, end, progress));
      if (see_part_) see_part_(part_);
      LODE_CHECK(join_chunk(std::move(pieces), i));
      forget_below(end);
      i = end;
      progress.report("extracting", static_cast<double>(i) / static_cast<double>(work_.size()));
    }
    IsosurfaceReport report = report_of({}, stats_, frame_);
    for (const LargestSteps& largest : largest_)
      report.coordinate_slack =
          std::max(report.coordinate_slack, slack_of(frame_, largest.step, largest.snap));
    report.surface_bytes = *std::ranges::max_element(surface_bytes_);
    report.part_bytes = part_bytes_;
    report.deviation = deviation_;
    report.geometry_seconds = joining_seconds_;
    report.measure_seconds = measuring_seconds_;
    report.select_seconds = watch.seconds() - joining_seconds_ - measuring_seconds_;
    return report;
  }

 private:
  using CoarseSelection = typename ChunkWork<D>::CoarseSelection;
  using Pieces = std::vector<BrickPiece<D>>;

  [[nodiscard]] const NodeSet<D>* wanted() const {
    if constexpr (D == 3) return query_.wanted;
    return nullptr;
  }
  /// Whether which cells are cubes depends on bricks round the chunk: not all are.
  [[nodiscard]] bool needs_round() const {
    return query_.style == SurfaceStyle::cubes &&
           !CubeCells::are_all(field_.has_holes(), query_.style_limit());
  }

  /// By brick from number `begin` to before `end`, all in the chunk that is loaded.
  Result<std::vector<Pieces>> march_chunk(std::size_t begin, std::size_t end, Progress& progress) {
    std::optional<NodeSet<D>> wanted_here;
    if (wanted() != nullptr) wanted_here = wanted()->part(part_.model().shape, part_.origin());
    std::vector<Selection<D>> selections;
    for (std::size_t i = 0; i < isovalues_.size(); ++i)
      selections.emplace_back(part_.model(), isovalues_[i], query_.cut_tolerance(),
                              wanted_here ? &*wanted_here : nullptr);
    LODE_TRY(const std::vector<CubeCells> cubes, find_cubes(selections, begin, end, progress));
    // Asked here alone: it may let go of surfaces.
    std::vector<bool> has_sink;
    for (std::size_t i = 0; i < isovalues_.size(); ++i) has_sink.push_back(sink_of_(i) != nullptr);
    std::vector<Pieces> pieces(end - begin);
    std::vector<TraversalStats> stats(end - begin);
    std::vector<std::unique_ptr<BrickMarcher<D>>> workers(as_size(n_workers(query_.threads)));
    parallel_for(end - begin, query_.threads, 1, [&](std::size_t i, int number) {
      auto& worker = workers[as_size(number)];
      if (!worker) {
        worker = std::make_unique<BrickMarcher<D>>(selections, frame_);
        worker->set_cubes(cubes);
      }
      march_brick(*worker, begin + i, has_sink, pieces[i], stats[i]);
      for (BrickPiece<D>& piece : pieces[i])
        find_normals(piece.part, &part_.samples(), part_.origin());
    });
    for (const TraversalStats& s : stats) stats_.join(s);
    if (query_.with_deviation)
      for (const auto& worker : workers)
        if (worker) deviation_.distance = std::max(deviation_.distance, worker->farthest_move());
    return pieces;
  }

  /// In the style of cubes, of each isovalue that is wanted.
  Result<std::vector<CubeCells>> find_cubes(std::span<const Selection<D>> selections,
                                            std::size_t begin, std::size_t end,
                                            Progress& progress) {
    std::vector<CubeCells> cubes;
    if constexpr (D == 3) {
      if (query_.style == SurfaceStyle::tetra) return cubes;
      std::vector<CutBrick<D>> bricks;
      for (std::size_t i = begin; i < end; ++i) bricks.push_back(work_.local(i, part_.origin()));
      if (needs_round())
        for (const std::size_t i : work_.round(begin))
          bricks.push_back(work_.local(i, part_.origin()));
      for (std::size_t i = 0; i < selections.size(); ++i) {
        cubes.emplace_back();
        if (sink_of_(i) == nullptr) continue;
        std::optional<NodeSet<3>> weak;
        if (const auto* const all = query_.weak_of(isovalues_[i]);
            all != nullptr && !std::isinf(query_.style_distance))
          weak = all->part(part_.model().shape, part_.origin());
        LODE_TRY(cubes.back(),
                 cubes_of(selections[i], bricks, end - begin, weak ? &*weak : nullptr, progress));
      }
    }
    return cubes;
  }
  /// Those in the first bricks are measured, where that is asked for.
  Result<CubeCells> cubes_of(const Selection<3>& selection, std::span<const CutBrick<3>> bricks,
                             std::size_t n_own, const NodeSet<3>* weak, Progress& progress) {
    const CubeLimit limit = query_.style_limit();
    if (!query_.with_deviation && !needs_round()) return CubeCells::all(part_.model().shape);
    LODE_TRY(CubeCells cubes,
             CubeCells::find(selection, bricks, frame_, limit, weak, query_.threads, progress));
    cube_bytes_ =
        std::max(cube_bytes_, 2 * cubes.n_bytes() + (weak != nullptr ? weak->n_bytes() : 0));
    if (!query_.with_deviation) return cubes;
    const Stopwatch watch;
    deviation_.join(cubes.measure(selection, bricks.first(n_own), frame_, query_.threads));
    measuring_seconds_ += watch.seconds();
    return cubes;
  }

  void march_brick(BrickMarcher<D>& marcher, std::size_t i, const std::vector<bool>& has_sink,
                   Pieces& pieces, TraversalStats& stats) {
    const CutBrick<D> brick = work_.local(i, part_.origin());
    marcher.march(
        {brick.brick, part_.origin(), field_.axes}, brick.simplices,
        [&](std::size_t isovalue) { return has_sink[isovalue]; }, stats, pieces);
    for (BrickPiece<D>& piece : pieces) leave_out_weak(piece.isovalue, piece.part);
  }

  void leave_out_weak(std::size_t isovalue, StitchPart<D>& part) const {
    if constexpr (D == 3)
      if (const auto* const weak = query_.weak_of(isovalues_[isovalue]); weak != nullptr)
        leave_out(*weak, field_.axes, part);
  }

  void find_normals(StitchPart<D>& part, const FlatField<D>* samples, const Index<D>& origin) {
    if (!query_.with_normals) return;
    visit_storage_type(field_.storage, [&]<typename T>() {
      PartNormals<D, T>(field_, samples, origin).write(part.part.points, part.normals);
    });
  }

  /// Passes on a chunk's pieces, isovalue by isovalue.
  Result<void> join_chunk(std::vector<Pieces> pieces, std::size_t begin) {
    for (std::size_t isovalue = 0; isovalue < isovalues_.size(); ++isovalue) {
      std::vector<StitchPart<D>> parts(pieces.size());
      bool is_met = isovalues_.size() == 1;
      for (std::size_t i = 0; i < pieces.size(); ++i)
        for (BrickPiece<D>& piece : pieces[i])
          if (piece.isovalue == isovalue) {
            parts[i] = std::move(piece.part);
            is_met = true;
          }
      if (is_met) LODE_CHECK(join(isovalue, parts, begin + 1));
    }
    return {};
  }

  /// Passes on the surface of parts `first` and following: everything coarser than bricks, or those
  /// of a chunk's bricks.
  Result<void> join(std::size_t isovalue, const std::vector<StitchPart<D>>& parts,
                    std::size_t first) {
    const Stopwatch watch;
    largest_[isovalue].add(parts);
    part_bytes_ = std::max(part_bytes_, bytes_of(parts) + cube_bytes_);
    const auto candidates = [&](LatticeKey key, std::vector<std::uint32_t>& out) {
      work_.parts().candidates(key, out);
      std::erase_if(out, [&](std::uint32_t part) { return part < first; });
      for (std::uint32_t& part : out) part -= static_cast<std::uint32_t>(first);
      std::erase_if(out, [&](std::uint32_t part) { return part >= parts.size(); });
    };
    const bool is_coarse = first == 0;
    SurfaceSink* const sink = sink_of_(isovalue);
    if (sink == nullptr) return {};
    LODE_TRY(SurfacePiece piece, stitchers_[isovalue].join(parts, candidates, [&](LatticeKey key) {
      return is_coarse || is_on_chunk_border(key);
    }));
    surface_bytes_[isovalue] += piece.surface.n_bytes();
    LODE_CHECK(sink->add(std::move(piece)));
    joining_seconds_ += watch.seconds();
    return {};
  }

  [[nodiscard]] static std::uint64_t bytes_of(const std::vector<StitchPart<D>>& parts) {
    std::uint64_t n = 0;
    for (const StitchPart<D>& part : parts)
      n += capacity_bytes(part.part.points) + capacity_bytes(part.part.cells) +
           capacity_bytes(part.shared) + capacity_bytes(part.normals);
    return n;
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
    const std::int32_t layer = work_.chunk_of(next)[last];
    if (layer == layer_) return;
    layer_ = layer;
    const auto axis = as_size(field_.axes.axis[last]);
    for (PieceStitcher<D>& stitcher : stitchers_)
      stitcher.forget_all_but(
          [&](LatticeKey key) { return to_point(key)[axis] >= 2 * layer * kChunkEdge<D>; });
  }

  const CoarseField<D>& field_;
  const IsovalueList& isovalues_;
  IsosurfaceQuery query_;
  LatticeFrame frame_;
  CoarseSelection selection_;
  FilePart<D> part_;
  CoarseCut<D> cut_;
  ChunkWork<D> work_;
  std::vector<PieceStitcher<D>> stitchers_;  ///< By isovalue.
  const SinkOfIsovalue& sink_of_;
  const SeePart<D>& see_part_;
  std::int32_t layer_ = 0;  ///< Of chunks, that vertices are kept for.
  TraversalStats stats_;
  std::vector<LargestSteps> largest_;         ///< By isovalue.
  std::vector<std::uint64_t> surface_bytes_;  ///< Likewise.
  std::uint64_t part_bytes_ = 0;              ///< The most that one's parts of a chunk take.
  CubeDeviation deviation_;
  std::uint64_t cube_bytes_ = 0;  ///< The most that one's bits of a chunk take.
  double joining_seconds_ = 0;
  double measuring_seconds_ = 0;
};

}  // namespace

template <int D>
Result<IsosurfaceReport> extract_from_file(const CoarseField<D>& field, store::BlockCache& blocks,
                                           const IsovalueList& isovalues,
                                           const IsosurfaceQuery& query,
                                           const SinkOfIsovalue& sink_of, Progress& progress,
                                           const SeePart<D>& see_part) {
  return FileExtraction<D>(field, blocks, isovalues, query, sink_of, see_part).run(progress);
}

template Result<IsosurfaceReport> extract_from_file<2>(const CoarseField<2>&, store::BlockCache&,
                                                       const IsovalueList&, const IsosurfaceQuery&,
                                                       const SinkOfIsovalue&, Progress&,
                                                       const SeePart<2>&);
template Result<IsosurfaceReport> extract_from_file<3>(const CoarseField<3>&, store::BlockCache&,
                                                       const IsovalueList&, const IsosurfaceQuery&,
                                                       const SinkOfIsovalue&, Progress&,
                                                       const SeePart<3>&);

}  // namespace lode::diamond
