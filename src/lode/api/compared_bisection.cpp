#include "lode/api/compared_bisection.h"

#include <algorithm>
#include <optional>

#include "lode/core/stopwatch.h"
#include "lode/models/terrain/right_triangle_bisection/extract.h"
#include "lode/models/terrain/right_triangle_bisection/locate.h"

namespace lode {
namespace {

class ComparedBisection final : public TerrainCandidate {
 public:
  [[nodiscard]] std::string name() const override { return "right_triangle_bisection"; }
  [[nodiscard]] std::string what() const override {
    return "longest-edge bisection of right triangles, with an error for each sample: any "
           "tolerance, which may vary";
  }
  [[nodiscard]] Result<void> prepare(const HeightGrid& grid, std::span<const double>,
                                     Threads threads, Progress& progress) override {
    grid_ = &grid;
    range_ = height_range(grid);
    const Stopwatch watch;
    LODE_TRY(tree_, bisection::Bisection::build(grid, threads, progress));
    seconds_ = watch.seconds();
    return {};
  }
  [[nodiscard]] Result<Answer> extract(double tolerance, Progress&) override {
    Answer answer{.tin = tin_within(*tree_, *grid_, tolerance), .stated_error = 0};
    if (!answer.tin.errors.empty())
      answer.stated_error = static_cast<double>(*std::ranges::max_element(answer.tin.errors));
    return answer;
  }
  [[nodiscard]] Result<std::uint64_t> extract_middle(double tolerance, Progress&) override {
    const Demand demand = middle_demand(*grid_, tolerance);
    return tin_of(*tree_, *grid_, select_nodes(*tree_, *grid_, range_, demand)).triangles.size();
  }
  [[nodiscard]] bool can_vary() const override { return true; }
  [[nodiscard]] std::optional<double> build_seconds() const override { return seconds_; }
  [[nodiscard]] ModelLevels levels() const override {
    return {tree_->lattice().n_levels(), "steps between columns, each halved by two bisections"};
  }
  /// Of the errors; heights are the raster's.
  [[nodiscard]] std::optional<std::uint64_t> memory_bytes() const override {
    return tree_->n_bytes();
  }
  [[nodiscard]] Result<std::optional<std::uint64_t>> zoom(double tolerance,
                                                          const TerrainWindow& window) override {
    return std::optional(count_in_window(*tree_, tolerance, {window.lower, window.upper}));
  }
  [[nodiscard]] std::optional<std::uint64_t> locate(
      double tolerance, std::span<const delaunay::LatticePoint> places) override {
    return static_cast<std::uint64_t>(std::ranges::count_if(places, [&](delaunay::LatticePoint p) {
      return find_triangle(*tree_, tolerance, p.x, p.y).has_value();
    }));
  }
  [[nodiscard]] Neighbours neighbours() const override { return sorted_twins(); }

 private:
  const HeightGrid* grid_ = nullptr;
  HeightRange range_;
  std::optional<bisection::Bisection> tree_;
  double seconds_ = 0;
};

}  // namespace

std::unique_ptr<TerrainCandidate> bisection_candidate() {
  return std::make_unique<ComparedBisection>();
}

}  // namespace lode
