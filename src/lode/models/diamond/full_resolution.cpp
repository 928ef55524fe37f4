#include "lode/models/diamond/full_resolution.h"

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <mutex>
#include <vector>

#include "lode/core/stopwatch.h"
#include "lode/models/diamond/slab_schedule.h"
#include "lode/models/diamond/slice_writer.h"

namespace lode::diamond {
namespace {

/// Slices of a slab: most samples are looked at in two, and those of a few slabs stay in the
/// caches.
constexpr std::int32_t kSlabEdge = 8;
static_assert(kBrickEdge<3> % kSlabEdge == 0);

/// As bricks, slabs share the samples between them; the last one has those at its end too.
std::int32_t n_slabs(std::int32_t n_slices) {
  return std::max(1, (n_slices - 1 + kSlabEdge - 1) / kSlabEdge);
}

class FullResolution {
 public:
  FullResolution(const Selection<3>& selection, const LatticeFrame& frame,
                 const IsosurfaceQuery& query, Surface& surface, Progress& progress)
      : model_(selection.model()),
        query_(query),
        surface_(surface),
        progress_(progress),
        finder_(selection, field_),
        n_rows_(as_size(field_.dims[1])),
        starts_(std::make_unique_for_overwrite<RowStart[]>(n_rows_ * as_size(field_.dims[2]))),
        bases_(as_size(field_.dims[2]) + 1),
        all_{model_,        frame,  selection.isovalue(), query.style, field_,
             starts_.get(), bases_, query.with_normals,   surface},
        writers_(as_size(n_workers(query.threads))),
        schedule_(as_size(n_slabs(field_.dims[2])),
                  [this](std::size_t slab) { return place(slab); }) {
    if (!query.replaces) bases_[0] = {surface.positions.size(), surface.triangles.size()};
  }

  /// At first as much is written as the surface has elements for: all, where it replaces one that
  /// is no smaller.
  Result<FullResolutionReport> run() {
    const Stopwatch watch;
    if (query_.replaces) surface_.lines.clear();
    work();
    if (!progress_.is_cancelled()) LODE_CHECK(make_room());
    if (!progress_.is_cancelled() && !schedule_.is_complete()) work();
    if (progress_.is_cancelled()) return cancelled_error();
    return report(watch.seconds());
  }

 private:
  using Step = SlabSchedule::Step;
  static constexpr std::uint64_t kMostNumbers = std::numeric_limits<std::uint32_t>::max();

  void work() {
    parallel_for(writers_.size(), query_.threads, 1, [this](std::size_t, int worker) {
      schedule_.work([&](const SlabSchedule::Task& task) {
        if (!progress_.is_cancelled()) run(task, as_size(worker));
      });
    });
  }

  void run(const SlabSchedule::Task& task, std::size_t worker) {
    const Stopwatch watch;
    const std::int32_t begin = static_cast<std::int32_t>(task.slab) * kSlabEdge;
    switch (task.step) {
      case Step::find: finder_.find(begin, end_of(task.slab)); break;
      case Step::count:
        for (std::int32_t z = begin; z < end_of(task.slab); ++z) {
          const SliceCounts n =
              count_slice(field_, z, query_.style, &starts_[as_size(z) * n_rows_]);
          bases_[as_size(z) + 1] = {n.vertices, n.triangles};
        }
        break;
      case Step::write: write(task.slab, worker); break;
    }
    const std::lock_guard lock(mutex_);
    (task.step == Step::write ? write_seconds_ : sign_seconds_) += watch.seconds();
  }

  [[nodiscard]] std::int32_t end_of(std::size_t slab) const {
    const auto next = static_cast<std::int32_t>(slab) + 1;
    return next == n_slabs(field_.dims[2]) ? field_.dims[2] : next * kSlabEdge;
  }

  /// Makes sums of its slices' numbers. Whether there is room for all that they count.
  bool place(std::size_t slab) {
    const auto end = as_size(end_of(slab));
    for (auto z = slab * as_size(kSlabEdge); z < end; ++z) {
      bases_[z + 1].vertices += bases_[z].vertices;
      bases_[z + 1].triangles += bases_[z].triangles;
    }
    return has_room(bases_[end]);
  }

  [[nodiscard]] bool has_room(const SliceBase& end) const {
    if (!query_.replaces || std::max(end.vertices, end.triangles) > kMostNumbers) return false;
    return end.triangles <= surface_.triangles.size() &&
           end.vertices <= surface_.positions.size() &&
           (!query_.with_isovalues || end.vertices <= surface_.isovalues.size()) &&
           (!query_.with_normals || end.vertices <= surface_.normals.size());
  }

  Result<void> make_room() {
    const auto [n_vertices, n_triangles] = bases_.back();
    if (std::max(n_vertices, n_triangles) > kMostNumbers)
      return fail("the surface has {} vertices and {} triangles, more than {}: give it a tolerance",
                  n_vertices, n_triangles, kMostNumbers);
    resize_large(surface_.positions, n_vertices);
    resize_large(surface_.triangles, n_triangles);
    resize_large(surface_.normals, query_.with_normals ? n_vertices : 0);
    if (query_.with_isovalues) resize_large(surface_.isovalues, n_vertices);
    schedule_.make_room();
    return {};
  }

  void write(std::size_t slab, std::size_t worker) {
    auto& writer = writers_[worker];
    if (!writer)
      visit_storage_type(model_.storage,
                         [&]<typename T>() { writer = std::make_unique<SliceWriterOf<T>>(all_); });
    const std::int32_t begin = static_cast<std::int32_t>(slab) * kSlabEdge;
    for (std::int32_t z = begin; z < end_of(slab); ++z) writer->write(z);
    if (query_.with_isovalues)
      std::fill(surface_.isovalues.data() + bases_[as_size(begin)].vertices,
                surface_.isovalues.data() + bases_[as_size(end_of(slab))].vertices,
                static_cast<float>(query_.isovalue));
  }

  /// The steps run together: each has its share of the time.
  [[nodiscard]] FullResolutionReport report(double seconds) const {
    FullResolutionReport report;
    const double all_seconds = sign_seconds_ + write_seconds_;
    if (all_seconds > 0) {
      report.sign_seconds = seconds * sign_seconds_ / all_seconds;
      report.write_seconds = seconds * write_seconds_ / all_seconds;
    }
    report.n_bricks_read = finder_.n_met();
    for (const auto& writer : writers_) {
      if (!writer) continue;
      const EdgeExtremes& e = writer->extremes();
      report.largest_step = std::max(report.largest_step, e.largest_step);
      report.largest_snap = std::max(report.largest_snap, e.largest_snap);
    }
    return report;
  }

  const Model<3>& model_;
  const IsosurfaceQuery& query_;
  Surface& surface_;
  Progress& progress_;
  SignField field_;
  SignFinder finder_;  ///< Sizes the field.
  std::size_t n_rows_;
  std::unique_ptr<RowStart[]> starts_;
  std::vector<SliceBase> bases_;
  FullSurface all_;
  std::vector<std::unique_ptr<SliceWriter>> writers_;  ///< By worker.
  SlabSchedule schedule_;
  std::mutex mutex_;
  double sign_seconds_ = 0;  ///< Of all workers.
  double write_seconds_ = 0;
};

}  // namespace

Result<FullResolutionReport> extract_full_resolution(const Selection<3>& selection,
                                                     const LatticeFrame& frame,
                                                     const IsosurfaceQuery& query, Surface& surface,
                                                     Progress& progress) {
  surface.origin = frame.surface_origin;
  return FullResolution(selection, frame, query, surface, progress).run();
}

}  // namespace lode::diamond
