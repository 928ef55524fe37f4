#include "lode/api/compared_quadtrees.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "lode/api/built_model.h"
#include "lode/api/quadtree_demand.h"
#include "lode/api/quadtree_patches.h"
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
    default: return "gaps are closed all over the mesh before there is anything to ask";
  }
}

ModelLevels of_sizes(std::int32_t n) { return {n, "sizes of squares, from a cell's on"}; }

/// What its patches are asked of: with a copy of the tree, and of the heights.
template <typename Tree>
Result<quadtree_file::QuadtreeModel> to_model(const HeightGrid& grid, TerrainModel model,
                                              const Tree& tree) {
  LODE_TRY(terrain_file::Source source, source_of(grid, {.model = model, .levels = {}}));
  return quadtree_file::QuadtreeModel{std::move(source), {}, grid, tree};
}

/// Of a tree that keeps all errors, so that it is asked without a mesh.
template <typename Tree>
class KeptTree : public TerrainCandidate {
 public:
  [[nodiscard]] Result<void> prepare(const HeightGrid& grid, std::span<const double>,
                                     Threads threads, Progress& progress) override {
    grid_ = &grid;
    range_ = height_range(grid);
    const Stopwatch watch;
    LODE_TRY(tree_, Tree::build(grid, threads, progress));
    seconds_ = watch.seconds();
    return {};
  }
  [[nodiscard]] Result<std::uint64_t> extract_middle(double tolerance, Progress&) override {
    return to_tin(*tree_, middle_leaves(tolerance)).triangles.size();
  }
  [[nodiscard]] bool can_vary() const override { return true; }
  [[nodiscard]] std::optional<double> build_seconds() const override { return seconds_; }
  [[nodiscard]] ModelLevels levels() const override { return of_sizes(tree_->domain().n_levels()); }
  [[nodiscard]] std::string why_not(ModelPart part) const override {
    return why_not_of_squares(part);
  }
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
      return find_leaf(*tree_, tolerance, p).has_value();
    }));
  }
  [[nodiscard]] Neighbours neighbours() const override { return of_several_sizes(); }

 protected:
  [[nodiscard]] const Tree& tree() const { return *tree_; }
  [[nodiscard]] auto middle_leaves(double tolerance) const {
    const Demand demand = middle_demand(*grid_, tolerance);
    return QuadtreeDemand(tree_->domain(), *grid_, range_, demand).leaves(*tree_);
  }
  [[nodiscard]] Result<std::shared_ptr<const TerrainPatches>> patches_of(TerrainModel kind,
                                                                         double tolerance,
                                                                         Progress& progress) {
    if (!model_) {
      LODE_TRY(model_, to_model(*grid_, kind, *tree_));
    }
    SelectedTerrain selected;
    selected.tin = to_tin(*tree_, tree_->leaves(tolerance));
    selected.report.max_error = tolerance;
    LODE_TRY(QuadtreePatches patches,
             QuadtreePatches::make(*model_, std::move(selected), {}, progress));
    return std::shared_ptr<const TerrainPatches>(
        std::make_shared<const QuadtreePatches>(std::move(patches)));
  }

 private:
  const HeightGrid* grid_ = nullptr;
  HeightRange range_;
  std::optional<Tree> tree_;
  std::optional<quadtree_file::QuadtreeModel> model_;
  double seconds_ = 0;
};

class SurfaceSquares final : public KeptTree<surface_quadtree::SurfaceQuadtree> {
 public:
  explicit SurfaceSquares(Continuity continuity) : continuity_(continuity) {}
  [[nodiscard]] std::string name() const override {
    return is_forced() ? "surface_quadtree, forced" : "surface_quadtree";
  }
  [[nodiscard]] std::string what() const override {
    return is_forced() ? "the same with its gaps closed: vertices that hang in an edge moved onto "
                         "it (figure 6 of the survey), by who is across, so that the whole mesh is "
                         "made before it is zoomed into or places are found"
                       : "bilinear squares, whose tolerance holds for them, not for the triangles "
                         "measured here; with gaps where squares of different sizes meet";
  }
  [[nodiscard]] Result<Answer> extract(double tolerance, Progress&) override {
    Answer answer{.tin = to_tin(tree(), tree().leaves(tolerance))};
    if (is_forced()) {
      close_gaps(answer.tin);
    } else {
      answer.stated_error = largest_error(answer.tin);
    }
    return answer;
  }
  /// What is moved onto an edge depends on who is across.
  [[nodiscard]] Result<std::uint64_t> extract_middle(double tolerance, Progress&) override {
    delaunay::Tin tin = to_tin(tree(), middle_leaves(tolerance));
    if (is_forced()) close_gaps(tin);
    return tin.triangles.size();
  }
  [[nodiscard]] Result<std::optional<std::uint64_t>> zoom(double tolerance,
                                                          const TerrainWindow& window) override {
    if (is_forced()) return std::optional<std::uint64_t>();
    return KeptTree::zoom(tolerance, window);
  }
  [[nodiscard]] std::optional<std::uint64_t> locate(
      double tolerance, std::span<const delaunay::LatticePoint> places) override {
    return is_forced() ? std::nullopt : KeptTree::locate(tolerance, places);
  }
  [[nodiscard]] Result<std::shared_ptr<const TerrainPatches>> patches(double tolerance,
                                                                      Progress& progress) override {
    if (is_forced()) return std::shared_ptr<const TerrainPatches>();
    return patches_of(TerrainModel::surface_quadtree, tolerance, progress);
  }

 private:
  [[nodiscard]] bool is_forced() const { return continuity_ == Continuity::forced; }
  static double largest_error(const delaunay::Tin& tin) {
    return tin.errors.empty() ? 0.0 : static_cast<double>(*std::ranges::max_element(tin.errors));
  }

  Continuity continuity_;
};

class Quaternary final : public KeptTree<quaternary_triangulation::QuaternaryTriangulation> {
 public:
  [[nodiscard]] std::string name() const override { return "quaternary_triangulation"; }
  [[nodiscard]] std::string what() const override {
    return "right triangles split in four; with gaps where different sizes meet";
  }
  [[nodiscard]] Result<Answer> extract(double tolerance, Progress&) override {
    return Answer{.tin = to_tin(tree(), tree().leaves(tolerance)), .stated_error = tolerance};
  }
  [[nodiscard]] Result<std::shared_ptr<const TerrainPatches>> patches(double tolerance,
                                                                      Progress& progress) override {
    return patches_of(TerrainModel::quaternary_triangulation, tolerance, progress);
  }
};

class Restricted final : public TerrainCandidate {
 public:
  [[nodiscard]] std::string name() const override { return "restricted_quadtree"; }
  [[nodiscard]] std::string what() const override {
    return "balanced squares in six patterns of triangles, continuous at the tolerance that they "
           "are made for, each time anew: the tolerance does not vary, and there is no tree to "
           "zoom "
           "into, or to find places in, before all of a mesh is made";
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
