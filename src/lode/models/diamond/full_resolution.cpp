#include "lode/models/diamond/full_resolution.h"

#include <chrono>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

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
    n_starts_ = n_rows * as_size(field_.dims[2]) + 1;
    starts_ = std::make_unique_for_overwrite<RowStart[]>(n_starts_);
    slices_.assign(as_size(field_.dims[2]), {});
    for_each_slice([&](std::size_t z) {
      for (std::size_t y = 0; y < n_rows; ++y) {
        RowStart& row = starts_[z * n_rows + y];
        row = {};
        if (!may_cross(y, z)) continue;
        const RowCounts n =
            count_row(CellRow(field_, static_cast<std::int32_t>(y), static_cast<std::int32_t>(z)),
                      query_.style);
        row = {n.vertices, n.triangles};
        for (const std::uint32_t n_own : n.vertices) slices_[z].vertices += n_own;
        slices_[z].triangles += n.triangles;
      }
    });
  }

  /// Turns counts into first numbers and makes room.
  Result<void> place() {
    const auto n_rows = as_size(field_.dims[1]);
    std::uint64_t n_vertices = query_.replaces ? 0 : surface_.positions.size();
    std::uint64_t n_triangles = query_.replaces ? 0 : surface_.triangles.size();
    for (SliceCounts& slice : slices_) {
      n_vertices += std::exchange(slice.vertices, n_vertices);
      n_triangles += std::exchange(slice.triangles, n_triangles);
    }
    for_each_slice([&](std::size_t z) {
      auto vertices = static_cast<std::uint32_t>(slices_[z].vertices);
      auto triangles = static_cast<std::uint32_t>(slices_[z].triangles);
      for (std::size_t y = 0; y < n_rows; ++y) {
        RowStart& row = starts_[z * n_rows + y];
        for (std::uint32_t& first : row.vertex) vertices += std::exchange(first, vertices);
        triangles += std::exchange(row.triangle, triangles);
      }
    });
    RowStart& end = starts_[n_starts_ - 1];
    end.vertex.fill(static_cast<std::uint32_t>(n_vertices));
    end.triangle = static_cast<std::uint32_t>(n_triangles);
    if (std::max(n_vertices, n_triangles) > std::numeric_limits<std::uint32_t>::max())
      return fail("the surface has {} vertices and {} triangles, more than {}: give it a tolerance",
                  n_vertices, n_triangles, std::numeric_limits<std::uint32_t>::max());
    if (query_.replaces) surface_.lines.clear();
    resize_large(surface_.positions, n_vertices);
    resize_large(surface_.triangles, n_triangles);
    resize_large(surface_.normals, query_.with_normals ? n_vertices : 0);
    return {};
  }

  [[nodiscard]] bool may_cross(std::size_t y, std::size_t z) const {
    return field_.may_cross(static_cast<std::int32_t>(y), static_cast<std::int32_t>(z));
  }
  /// body(z), in parallel.
  template <typename Body>
  void for_each_slice(const Body& body) {
    parallel_for(as_size(field_.dims[2]), query_.threads, kSlicesAtOnce, [&](std::size_t z, int) {
      if (!progress_.is_cancelled()) body(z);
    });
  }

  template <typename T>
  void write() {
    const FullSurface all{model_,       frame_, selection_.isovalue(),
                          query_.style, field_, {starts_.get(), n_starts_},
                          surface_};
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
  std::unique_ptr<RowStart[]> starts_;  ///< By row, and one behind the last.
  std::size_t n_starts_ = 0;
  struct SliceCounts {
    std::uint64_t vertices = 0;
    std::uint64_t triangles = 0;
  };
  std::vector<SliceCounts> slices_;  ///< Of each slice; then of those before it.
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
