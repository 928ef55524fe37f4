// Dataset::count(): the sizes of many isovalues' surfaces.

#include <algorithm>
#include <new>
#include <utility>

#include "lode/api/dataset_impl.h"
#include "lode/api/file_build.h"
#include "lode/core/out_of_memory.h"
#include "lode/core/stopwatch.h"
#include "lode/models/diamond/isovalue_counts.h"

namespace lode {
namespace {

/// Ascending, each once.
std::vector<double> in_order(std::vector<double> isovalues) {
  std::sort(isovalues.begin(), isovalues.end());
  isovalues.erase(std::unique(isovalues.begin(), isovalues.end()), isovalues.end());
  return isovalues;
}

/// All in one pass.
Result<void> count_in_memory(const Dataset::Impl::AnyModel& held, const CountOptions& options,
                             CountReport& report, Progress& progress) {
  const diamond::CountQuery query{in_order(options.isovalues), report.max_error, options.threads};
  LODE_TRY(const auto counts, std::visit(
                                  [&]<int D>(const diamond::Model<D>& model) {
                                    return diamond::count_isosurfaces<D>(model, query, progress);
                                  },
                                  held));
  const bool is_flat = std::holds_alternative<diamond::Model<2>>(held);
  for (IsovalueCount& count : report.counts) {
    const auto at =
        std::lower_bound(query.isovalues.begin(), query.isovalues.end(), count.isovalue);
    const auto& found = counts[static_cast<std::size_t>(at - query.isovalues.begin())];
    (is_flat ? count.lines : count.triangles) = found.cells;
    count.vertices = found.vertices;
  }
  return {};
}

/// Counts the vertices of a surface's pieces and lets go of them.
class VertexCounter final : public SurfaceSink {
 public:
  Result<void> add(SurfacePiece piece) override {
    n_ += static_cast<std::uint32_t>(piece.n_new());
    return {};
  }
  void set_normals(std::span<const VertexNormal> /*normals*/) override {}
  [[nodiscard]] std::uint32_t n_vertices() const override { return n_; }

 private:
  std::uint32_t n_ = 0;
};

/// One after the other, by extracting them.
Result<void> count_pieces(const Dataset& dataset, const CountOptions& options, CountReport& report,
                          Progress& progress) {
  for (IsovalueCount& count : report.counts) {
    VertexCounter surface;
    LODE_TRY(const ExtractReport extracted,
             dataset.extract(ExtractOptions{.isovalues = {count.isovalue},
                                            .max_error = report.max_error,
                                            .normals = Normals::off,
                                            .threads = options.threads,
                                            .memory_limit = options.memory_limit},
                             surface, progress));
    count.triangles = extracted.triangles;
    count.lines = extracted.lines;
    count.vertices = extracted.vertices;
  }
  return {};
}

}  // namespace

Result<CountReport> Dataset::count(const CountOptions& options, Progress& progress) const try {
  const Stopwatch watch;
  const ExtractOptions like{.isovalues = options.isovalues,
                            .max_error = options.max_error,
                            .threads = options.threads,
                            .memory_limit = options.memory_limit};
  LODE_CHECK(check_extract_options(like));
  CountReport report{.max_error = tolerance_of(impl_->summary().stats, like), .counts = {}};
  report.counts.reserve(options.isovalues.size());
  for (const double isovalue : options.isovalues) report.counts.push_back({.isovalue = isovalue});
  const std::uint64_t limit =
      options.memory_limit > 0 ? options.memory_limit : physical_memory() / 4;
  if (impl_->is_in_file() && impl_->model_bytes() > limit) {
    LODE_CHECK(count_pieces(*this, options, report, progress));
  } else {
    LODE_TRY(const auto* const held, impl_->model(progress));
    LODE_CHECK(count_in_memory(*held, options, report, progress));
  }
  report.seconds = watch.seconds();
  return report;
} catch (const std::bad_alloc&) {
  return out_of_memory("count surfaces");
}

}  // namespace lode
