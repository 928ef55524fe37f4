#include "lode/models/diamond/full_resolution.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <vector>

#include "lode/core/parallel_fill.h"
#include "lode/core/stopwatch.h"
#include "lode/models/diamond/slab_schedule.h"
#include "lode/models/diamond/slice_writer.h"

namespace lode::diamond {
namespace {

/// How many threads have enough to do.
std::size_t n_useful(const Index<3>& dims, Threads threads) {
  constexpr std::size_t kSamplesPerThread = 1 << 16;
  const std::size_t n_samples = as_size(dims[0]) * as_size(dims[1]) * as_size(dims[2]);
  return std::clamp<std::size_t>(n_samples / kSamplesPerThread, 1, as_size(n_workers(threads)));
}

/// Of fewer slices than usual where threads would have nothing to do.
Slabs slabs_for(std::int32_t n_slices, std::size_t n_threads) {
  std::int32_t edge = Slabs::kUsualEdge;
  while (edge > 1 && n_threads > 1 && Slabs(n_slices, edge).n() < 4 * n_threads) edge /= 2;
  return {n_slices, edge};
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
        workers_(n_useful(field_.dims, query.threads)),
        slabs_(slabs_for(field_.dims[2], workers_.size())),
        schedule_(slabs_.n(), [this](std::size_t slab) { return place(slab); }) {
    if (!query.replaces) bases_[0] = {surface.positions.size(), surface.triangles.size()};
  }

  /// At first as much is written as the surface has elements for: all, where it replaces one that
  /// is no smaller.
  Result<FullResolutionReport> run() {
    if (query_.replaces) surface_.lines.clear();
    work();
    if (!progress_.is_cancelled()) LODE_CHECK(make_room());
    if (!progress_.is_cancelled() && !schedule_.is_complete()) work();
    if (progress_.is_cancelled()) return cancelled_error();
    return report(watch_.seconds());
  }

 private:
  using Step = SlabSchedule::Step;
  struct Worker {
    std::unique_ptr<SliceWriter> writer;
    double sign_seconds = 0;
    double write_seconds = 0;
  };
  static constexpr std::uint64_t kMostNumbers = std::numeric_limits<std::uint32_t>::max();

  void work() {
    const Threads threads{static_cast<int>(workers_.size())};
    parallel_for(workers_.size(), threads, 1, [this](std::size_t, int worker) {
      schedule_.work([&](const SlabSchedule::Task& task) {
        if (!progress_.is_cancelled()) run(task, workers_[as_size(worker)]);
      });
    });
  }

  void run(const SlabSchedule::Task& task, Worker& worker) {
    const Stopwatch watch;
    const std::int32_t begin = slabs_.begin(task.slab);
    const std::int32_t end = slabs_.end(task.slab);
    switch (task.step) {
      case Step::find: finder_.find(begin, end); break;
      case Step::count:
        for (std::int32_t z = begin; z < end; ++z) {
          const SliceCounts n =
              count_slice(field_, z, query_.style, &starts_[as_size(z) * n_rows_]);
          bases_[as_size(z) + 1] = {n.vertices, n.triangles};
        }
        break;
      case Step::write: write(task.slab, worker.writer); break;
    }
    (task.step == Step::write ? worker.write_seconds : worker.sign_seconds) += watch.seconds();
  }

  /// Makes sums of its slices' numbers. Whether there is room for all that they count.
  bool place(std::size_t slab) {
    const auto end = as_size(slabs_.end(slab));
    for (auto z = as_size(slabs_.begin(slab)); z < end; ++z) {
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

  void write(std::size_t slab, std::unique_ptr<SliceWriter>& writer) {
    if (!writer)
      visit_storage_type(model_.storage,
                         [&]<typename T>() { writer = std::make_unique<SliceWriterOf<T>>(all_); });
    const std::int32_t begin = slabs_.begin(slab);
    const std::int32_t end = slabs_.end(slab);
    for (std::int32_t z = begin; z < end; ++z) writer->write(z);
    if (!query_.with_isovalues) return;
    const std::uint64_t first = bases_[as_size(begin)].vertices;
    fill_by_copies(surface_.isovalues.data() + first, bases_[as_size(end)].vertices - first,
                   query_.isovalue);
  }

  /// The steps run together: each has its share of the time.
  [[nodiscard]] FullResolutionReport report(double seconds) const {
    FullResolutionReport report;
    report.n_bricks_read = finder_.n_met();
    for (const Worker& worker : workers_) {
      report.sign_seconds += worker.sign_seconds;
      report.write_seconds += worker.write_seconds;
      if (!worker.writer) continue;
      const EdgeExtremes& e = worker.writer->extremes();
      report.largest_step = std::max(report.largest_step, e.largest_step);
      report.largest_snap = std::max(report.largest_snap, e.largest_snap);
    }
    const double all_seconds = report.sign_seconds + report.write_seconds;
    const double share = all_seconds > 0 ? seconds / all_seconds : 0;
    report.sign_seconds *= share;
    report.write_seconds *= share;
    return report;
  }

  Stopwatch watch_;
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
  std::vector<Worker> workers_;
  Slabs slabs_;
  SlabSchedule schedule_;
};

}  // namespace

Result<FullResolutionReport> extract_full_resolution(const Selection<3>& selection,
                                                     const LatticeFrame& frame,
                                                     const IsosurfaceQuery& query, Surface& surface,
                                                     Progress& progress) {
  struct Emptied {
    Surface* surface;
    ~Emptied() {
      if (surface != nullptr) surface->clear();
    }
  } unless_done{&surface};  // of numbers of vertices that are not there
  surface.origin = frame.surface_origin;
  auto report = FullResolution(selection, frame, query, surface, progress).run();
  if (report) unless_done.surface = nullptr;
  return report;
}

}  // namespace lode::diamond
