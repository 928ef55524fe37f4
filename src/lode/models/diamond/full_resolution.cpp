#include "lode/models/diamond/full_resolution.h"

#include <chrono>
#include <limits>
#include <memory>

#include "lode/models/diamond/slice_writer.h"

namespace lode::diamond {
namespace {

/// One thread's, which looks at most samples twice: in two neighbouring slices.
constexpr std::size_t kSlicesAtOnce = 8;

class FullResolution {
 public:
  FullResolution(const Selection<3>& selection, const LatticeFrame& frame,
                 const IsosurfaceQuery& query, Surface& surface, Progress& progress)
      : selection_(selection),
        model_(selection.model()),
        frame_(frame),
        query_(query),
        surface_(surface),
        progress_(progress) {}

  Result<FullResolutionReport> run() {
    const auto start = std::chrono::steady_clock::now();
    field_ = sign_field(selection_, query_.threads, report_.n_bricks_read);
    count();
    LODE_CHECK(place());
    const auto counted = std::chrono::steady_clock::now();
    visit_storage_type(model_.storage, [&]<typename T>() { write<T>(); });
    if (progress_.is_cancelled()) return cancelled_error();
    const auto done = std::chrono::steady_clock::now();
    report_.sign_seconds = std::chrono::duration<double>(counted - start).count();
    report_.write_seconds = std::chrono::duration<double>(done - counted).count();
    return report_;
  }

 private:
  void count() {
    const auto n_rows = as_size(field_.dims[1]);
    starts_.resize(n_rows * as_size(field_.dims[2]) + 1);
    parallel_for(as_size(field_.dims[2]), query_.threads, kSlicesAtOnce, [&](std::size_t z, int) {
      if (progress_.is_cancelled()) return;
      for (std::size_t y = 0; y < n_rows; ++y) {
        const RowCounts n =
            count_row(CellRow(field_, static_cast<std::int32_t>(y), static_cast<std::int32_t>(z)),
                      query_.style);
        starts_[z * n_rows + y] = {n.vertices, n.triangles};
      }
    });
    starts_.back() = {};
  }

  /// Turns counts into first numbers and makes room.
  Result<void> place() {
    std::uint64_t n_vertices = query_.replaces ? 0 : surface_.positions.size();
    std::uint64_t n_triangles = query_.replaces ? 0 : surface_.triangles.size();
    for (RowStart& start : starts_) {
      for (std::uint32_t& first : start.vertex) {
        const std::uint32_t n = first;
        first = static_cast<std::uint32_t>(n_vertices);
        n_vertices += n;
      }
      const std::uint32_t n = start.triangle;
      start.triangle = static_cast<std::uint32_t>(n_triangles);
      n_triangles += n;
    }
    if (std::max(n_vertices, n_triangles) > std::numeric_limits<std::uint32_t>::max())
      return fail("the surface has {} vertices and {} triangles, more than {}: give it a tolerance",
                  n_vertices, n_triangles, std::numeric_limits<std::uint32_t>::max());
    if (query_.replaces) surface_.lines.clear();
    resize_large(surface_.positions, n_vertices);
    resize_large(surface_.triangles, n_triangles);
    resize_large(surface_.normals, query_.with_normals ? n_vertices : 0);
    return {};
  }

  template <typename T>
  void write() {
    const FullSurface all{model_,  frame_,  selection_.isovalue(), query_.style, field_,
                          starts_, surface_};
    std::vector<std::unique_ptr<SliceWriter<T>>> writers(as_size(n_workers(query_.threads)));
    parallel_for(as_size(field_.dims[2]), query_.threads, kSlicesAtOnce,
                 [&](std::size_t z, int worker) {
                   if (progress_.is_cancelled()) return;
                   auto& writer = writers[as_size(worker)];
                   if (!writer) writer = std::make_unique<SliceWriter<T>>(all);
                   writer->write(static_cast<std::int32_t>(z));
                 });
    for (const auto& writer : writers) {
      if (!writer) continue;
      const EdgeExtremes& e = writer->extremes();
      report_.largest_step = std::max(report_.largest_step, e.largest_step);
      report_.largest_snap = std::max(report_.largest_snap, e.largest_snap);
    }
  }

  const Selection<3>& selection_;
  const Model<3>& model_;
  const LatticeFrame& frame_;
  const IsosurfaceQuery& query_;
  Surface& surface_;
  Progress& progress_;
  SignField field_;
  std::vector<RowStart> starts_;  ///< By row, and one behind the last.
  FullResolutionReport report_;
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
