#include "lode/delaunay/greedy_insertion.h"

#include <algorithm>
#include <atomic>
#include <optional>
#include <utility>
#include <vector>

#include "lode/delaunay/greedy_loop.h"
#include "lode/delaunay/regions.h"
#include "lode/delaunay/triangle_judge.h"

namespace lode::delaunay {

namespace {

constexpr int kTileBits = 7;  // 128 by 128 samples stay in the cache.

/// Of a region: what lies on its border waits until the regions are joined. A triangle whose worst
/// sample does has an error beyond the tolerance, and no candidate.
template <typename T>
class RegionJudge {
 public:
  RegionJudge(const TriangleJudge<T>& judge, const Region& region)
      : judge_(judge), region_(region) {}

  /// Of triangles that are judged.
  void spare_borders(LatticeMesh& mesh) const {
    for (std::uint32_t t = 0; t < mesh.triangles().size(); ++t) spare_border(mesh, t);
  }
  void judge_some(LatticeMesh& mesh, std::span<const std::uint32_t> slots) const {
    judge_.judge_some(mesh, slots);
    for (const std::uint32_t t : slots) spare_border(mesh, t);
  }
  std::span<const std::uint32_t> insert(LatticeMesh& mesh, std::uint32_t t) const {
    const std::span<const std::uint32_t> made = judge_.insert(mesh, t);
    for (const std::uint32_t one : made) spare_border(mesh, one);
    return made;
  }

 private:
  void spare_border(LatticeMesh& mesh, std::uint32_t t) const {
    LatticeTriangle& triangle = mesh.triangle(t);
    if (triangle.candidate == WorstSample::kNone) return;
    for (std::uint32_t i = 0; i < 3; ++i) {
      if (triangle.twin[i] != kNoHalfEdge) continue;
      const std::uint32_t from = triangle.corner[i];
      const std::uint32_t to = triangle.corner[(i + 1) % 3];
      const auto at = [&](std::uint32_t node) { return mesh.nodes().unpack(node); };
      if (doubled_area(at(from), at(to), at(triangle.candidate)) != 0 ||
          !region_.border.contains(border_key(from, to)))
        continue;
      triangle.candidate = WorstSample::kNone;
      return;
    }
  }

  const TriangleJudge<T>& judge_;
  const Region& region_;
};

/// In levels, on several threads: a mesh of some thousand triangles is cut into regions, and each
/// refined on its own; then they are joined, made Delaunay along their borders, and refined there.
template <typename T>
class RegionalInsertion {
 public:
  RegionalInsertion(LatticeMesh& mesh, const SampleRows<T>& rows, double lower, double upper,
                    const GreedyOptions& options, Progress& progress)
      : mesh_(mesh),
        options_(options),
        progress_(progress),
        part_(part_of(mesh)),
        sparse_(rows, part_.last),
        judge_(rows, &sparse_, lower, upper, options.max_error, nullptr) {}

  Result<GreedyReport> run() {
    LODE_TRY(
        const GreedyReport first,
        GreedyLoop(mesh_, judge_, options_, progress_).begin(part_, kTileBits, kTrianglesBefore));
    n_inserted_ = first.n_inserted;
    // What little is left goes to where it is needed, all over the mesh.
    if (largest_error() <= kLeastShare * options_.max_error || mesh_.has_cuts()) return go_on({});
    std::vector<Region> regions = cut_into_regions(mesh_);
    if (regions.empty()) return go_on({});
    LODE_CHECK(refine(regions));
    return join(regions);
  }

 private:
  /// How many triangles there are before regions are cut, or more.
  static constexpr std::size_t kTrianglesBefore = 16384;
  /// How far errors are from the tolerance then, at least, that regions are worth their borders.
  static constexpr double kLeastShare = 8;

  [[nodiscard]] double largest_error() const {
    float largest = 0;
    for (const LatticeTriangle& triangle : mesh_.triangles())
      largest = std::max(largest, triangle.error);
    return static_cast<double>(largest);
  }

  [[nodiscard]] Result<GreedyReport> go_on(std::span<const std::uint32_t> slots) {
    LODE_TRY(GreedyReport rest,
             GreedyLoop(mesh_, judge_, options_, progress_).go_on(slots, part_, kTileBits));
    rest.n_inserted += n_inserted_;
    return rest;
  }
  Result<void> refine(std::vector<Region>& regions) {
    GreedyOptions options = options_;
    options.reports = false;
    std::vector<std::uint64_t> n_inserted(regions.size());
    std::vector<std::optional<Error>> failures(regions.size());
    std::atomic<std::size_t> n_done = 0;
    parallel_for(regions.size(), options_.threads, 1, [&](std::size_t r, int) {
      if (regions[r].triangles.empty()) return;
      LatticeMesh mesh(mesh_.nodes(), std::move(regions[r].triangles));
      RegionJudge<T> judge(judge_, regions[r]);
      judge.spare_borders(mesh);
      const auto report =
          GreedyLoop(mesh, judge, options, progress_).go_on({}, part_of(mesh), kTileBits);
      if (report)
        n_inserted[r] = report->n_inserted;
      else
        failures[r] = report.error();
      regions[r].triangles = mesh.take_triangles();
      progress_.report("inserting",
                       static_cast<double>(++n_done) / static_cast<double>(regions.size()));
    });
    for (std::size_t r = 0; r < regions.size(); ++r) {
      if (failures[r]) return *failures[r];
      n_inserted_ += n_inserted[r];
    }
    return {};
  }
  Result<GreedyReport> join(std::vector<Region>& regions) {
    std::uint64_t n = 0;
    for (const Region& region : regions) n += region.triangles.size();
    if (n > kMostTriangles)
      return fail("expected up to {} triangles, got {}: a larger tolerance takes fewer",
                  kMostTriangles, n);
    std::vector<std::uint32_t> border;
    mesh_ = LatticeMesh(mesh_.nodes(), join_regions(regions, options_.threads, border));
    std::vector<std::uint32_t> slots = mesh_.make_delaunay(std::move(border));
    for (std::uint32_t t = 0; t < mesh_.triangles().size(); ++t) {
      const LatticeTriangle& triangle = mesh_.triangles()[t];
      if (static_cast<double>(triangle.error) > options_.max_error) slots.push_back(t);
    }
    std::ranges::sort(slots);
    slots.erase(std::unique(slots.begin(), slots.end()), slots.end());
    return go_on(slots);
  }

  LatticeMesh& mesh_;
  GreedyOptions options_;
  Progress& progress_;
  LatticePart part_;
  SparseSamples<T> sparse_;
  TriangleJudge<T> judge_;
  std::uint64_t n_inserted_ = 0;
};

}  // namespace

template <typename T>
Result<GreedyReport> insert_greedily(LatticeMesh& mesh, const SampleRows<T>& rows, double lower,
                                     double upper, const GreedyOptions& options,
                                     Progress& progress) {
  LODE_EXPECTS(options.max_error >= 0);
  LODE_EXPECTS(options.order != InsertionOrder::tiles);
  LODE_EXPECTS(options.order == InsertionOrder::strict ||
               (options.max_triangles == std::numeric_limits<std::uint64_t>::max() &&
                options.observer == nullptr));
  const LatticePart part = part_of(mesh);
  if (options.order == InsertionOrder::strict) {
    TriangleJudge<T> judge(rows, nullptr, lower, upper, options.max_error, options.observer);
    return GreedyLoop(mesh, judge, options, progress).run(part, kTileBits);
  }
  return RegionalInsertion<T>(mesh, rows, lower, upper, options, progress).run();
}

template Result<GreedyReport> insert_greedily(LatticeMesh&, const SampleRows<std::int16_t>&, double,
                                              double, const GreedyOptions&, Progress&);
template Result<GreedyReport> insert_greedily(LatticeMesh&, const SampleRows<std::uint16_t>&,
                                              double, double, const GreedyOptions&, Progress&);
template Result<GreedyReport> insert_greedily(LatticeMesh&, const SampleRows<float>&, double,
                                              double, const GreedyOptions&, Progress&);
template Result<GreedyReport> insert_greedily(LatticeMesh&, const SampleRows<double>&, double,
                                              double, const GreedyOptions&, Progress&);

}  // namespace lode::delaunay
