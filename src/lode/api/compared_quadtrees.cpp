#include "lode/api/compared_quadtrees.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "lode/api/quadtree_demand.h"
#include "lode/core/stopwatch.h"
#include "lode/mappers/tin_gaps.h"
#include "lode/models/terrain/quaternary_triangulation/quaternary_triangulation.h"
#include "lode/models/terrain/restricted_quadtree/restricted_quadtree.h"
#include "lode/models/terrain/surface_quadtree/surface_quadtree.h"

namespace lode {
namespace {

enum class Continuity : std::uint8_t { left_open, forced };

Neighbours of_several_sizes() {
  return {Neighbours::Place::nowhere,
          "where sizes differ several triangles are behind an edge, and none is kept"};
}

std::string why_not_of_squares(ModelPart part) {
  switch (part) {
    case ModelPart::links: return "squares are found by their columns and rows";
    case ModelPart::file: return "closed gaps are not kept; a file is that of the open ones";
    case ModelPart::variable: return "closing gaps leaves no tolerance to vary";
    default: return "all leaves are asked for at once: no descent to a place is written";
  }
}

/// The number of triangles.
template <typename Tree>
std::uint64_t extract_demand(const Tree& tree, const HeightGrid& grid, const HeightRange& range,
                             double tolerance) {
  const Demand demand = middle_demand(grid, tolerance);
  return to_tin(tree, QuadtreeDemand(tree.domain(), grid, range, demand).leaves(tree))
      .triangles.size();
}

ModelLevels of_sizes(std::int32_t n) { return {n, "sizes of squares, from a cell's on"}; }

class SurfaceSquares final : public TerrainCandidate {
 public:
  explicit SurfaceSquares(Continuity continuity) : continuity_(continuity) {}
  [[nodiscard]] std::string name() const override {
    return is_forced() ? "surface_quadtree, forced" : "surface_quadtree";
  }
  [[nodiscard]] std::string what() const override {
    return is_forced() ? "the same with its gaps closed: vertices that hang in an edge moved onto "
                         "it (figure 6 of the survey)"
                       : "bilinear squares, whose tolerance holds for them, not for the triangles "
                         "measured here; with gaps where squares of different sizes meet";
  }
  [[nodiscard]] Result<void> prepare(const HeightGrid& grid, std::span<const double>,
                                     Threads threads, Progress& progress) override {
    const Stopwatch watch;
    LODE_TRY(tree_, surface_quadtree::SurfaceQuadtree::build(grid, threads, progress));
    seconds_ = watch.seconds();
    grid_ = &grid;
    range_ = height_range(grid);
    return {};
  }
  [[nodiscard]] Result<Answer> extract(double tolerance, Progress&) override {
    Answer answer{.tin = to_tin(*tree_, tree_->leaves(tolerance))};
    if (is_forced()) {
      close_gaps(answer.tin);
    } else {
      answer.stated_error = largest_error(answer.tin);
    }
    return answer;
  }
  [[nodiscard]] bool can_vary() const override { return !is_forced(); }
  [[nodiscard]] Result<std::uint64_t> extract_middle(double tolerance, Progress&) override {
    return extract_demand(*tree_, *grid_, range_, tolerance);
  }
  [[nodiscard]] std::optional<double> build_seconds() const override { return seconds_; }
  [[nodiscard]] ModelLevels levels() const override { return of_sizes(tree_->domain().n_levels()); }
  [[nodiscard]] std::optional<std::uint64_t> memory_bytes() const override {
    return tree_->n_bytes();
  }
  [[nodiscard]] Neighbours neighbours() const override { return of_several_sizes(); }
  [[nodiscard]] std::string why_not(ModelPart part) const override {
    return why_not_of_squares(part);
  }

 private:
  [[nodiscard]] bool is_forced() const { return continuity_ == Continuity::forced; }
  static double largest_error(const delaunay::Tin& tin) {
    return tin.errors.empty() ? 0.0 : static_cast<double>(*std::ranges::max_element(tin.errors));
  }

  Continuity continuity_;
  const HeightGrid* grid_ = nullptr;
  HeightRange range_;
  std::optional<surface_quadtree::SurfaceQuadtree> tree_;
  double seconds_ = 0;
};

class Quaternary final : public TerrainCandidate {
 public:
  [[nodiscard]] std::string name() const override { return "quaternary_triangulation"; }
  [[nodiscard]] std::string what() const override {
    return "right triangles split in four; with gaps where different sizes meet";
  }
  [[nodiscard]] Result<void> prepare(const HeightGrid& grid, std::span<const double>,
                                     Threads threads, Progress& progress) override {
    const Stopwatch watch;
    LODE_TRY(tree_,
             quaternary_triangulation::QuaternaryTriangulation::build(grid, threads, progress));
    seconds_ = watch.seconds();
    grid_ = &grid;
    range_ = height_range(grid);
    return {};
  }
  [[nodiscard]] Result<Answer> extract(double tolerance, Progress&) override {
    return Answer{.tin = to_tin(*tree_, tree_->leaves(tolerance)), .stated_error = tolerance};
  }
  [[nodiscard]] bool can_vary() const override { return true; }
  [[nodiscard]] Result<std::uint64_t> extract_middle(double tolerance, Progress&) override {
    return extract_demand(*tree_, *grid_, range_, tolerance);
  }
  [[nodiscard]] std::optional<double> build_seconds() const override { return seconds_; }
  [[nodiscard]] ModelLevels levels() const override { return of_sizes(tree_->domain().n_levels()); }
  [[nodiscard]] std::optional<std::uint64_t> memory_bytes() const override {
    return tree_->n_bytes();
  }
  [[nodiscard]] Neighbours neighbours() const override { return of_several_sizes(); }
  [[nodiscard]] std::string why_not(ModelPart part) const override {
    return why_not_of_squares(part);
  }

 private:
  const HeightGrid* grid_ = nullptr;
  HeightRange range_;
  std::optional<quaternary_triangulation::QuaternaryTriangulation> tree_;
  double seconds_ = 0;
};

class Restricted final : public TerrainCandidate {
 public:
  [[nodiscard]] std::string name() const override { return "restricted_quadtree"; }
  [[nodiscard]] std::string what() const override {
    return "balanced squares in six patterns of triangles, continuous at the tolerance that they "
           "are made for, each time anew";
  }
  [[nodiscard]] Result<void> prepare(const HeightGrid& grid, std::span<const double>, Threads,
                                     Progress&) override {
    const Stopwatch watch;
    LODE_TRY(domain_, squares::SquareDomain::make(grid));
    seconds_ = watch.seconds();
    return {};
  }
  [[nodiscard]] Result<Answer> extract(double tolerance, Progress& progress) override {
    LODE_TRY(const auto leaves, restricted_quadtree::build(*domain_, tolerance, progress));
    return Answer{.tin = to_tin(*domain_, leaves), .stated_error = tolerance};
  }
  [[nodiscard]] std::optional<double> build_seconds() const override { return seconds_; }
  [[nodiscard]] bool is_made_anew() const override { return true; }
  [[nodiscard]] ModelLevels levels() const override { return of_sizes(domain_->n_levels()); }
  [[nodiscard]] Neighbours neighbours() const override { return sorted_twins(); }
  [[nodiscard]] std::string why_not(ModelPart part) const override {
    if (part == ModelPart::variable)
      return "squares are balanced for one tolerance; where it varied there would be gaps";
    return TerrainCandidate::why_not(part);
  }

 private:
  std::optional<squares::SquareDomain> domain_;
  double seconds_ = 0;
};

}  // namespace

std::vector<std::unique_ptr<TerrainCandidate>> quadtree_candidates() {
  std::vector<std::unique_ptr<TerrainCandidate>> all;
  all.push_back(std::make_unique<SurfaceSquares>(Continuity::left_open));
  all.push_back(std::make_unique<SurfaceSquares>(Continuity::forced));
  all.push_back(std::make_unique<Quaternary>());
  all.push_back(std::make_unique<Restricted>());
  return all;
}

}  // namespace lode
