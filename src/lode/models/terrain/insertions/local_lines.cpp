#include "lode/models/terrain/insertions/local_lines.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <queue>
#include <utility>

#include "lode/models/terrain/insertions/local_mesh.h"
#include "lode/models/terrain/insertions/local_search.h"

namespace lode::insertions {
namespace {

using delaunay::LatticePoint;

/// Goes down from the base to an outermost vertex of a time, as if heights had that sign.
class OutermostVertex {
 public:
  OutermostVertex(const HistoryFile& file, std::uint32_t time, double sign)
      : mesh_(file, time), sign_(sign) {
    push(0, mesh_.n_triangles());
  }

  Result<std::optional<double>> find(std::uint32_t max_nodes, const Progress& progress) {
    // No vertex leaves: the outermost there was is of all later meshes, too.
    while (!open_.empty() && open_.top().first > highest_) {
      if (progress.is_cancelled()) return cancelled_error();
      const std::uint32_t t = open_.top().second;
      open_.pop();
      LODE_TRY(const FileNode death, mesh_.death_of(t));
      if (death.time == kNone) continue;
      const std::uint32_t n_before = mesh_.n_triangles();
      LODE_CHECK(mesh_.apply_death_of(t));
      if (mesh_.n_applied() > max_nodes) return std::optional<double>();
      push(n_before, mesh_.n_triangles());
    }
    return std::optional(sign_ * highest_);
  }

 private:
  void push(std::uint32_t begin, std::uint32_t end) {
    for (std::uint32_t t = begin; t < end; ++t) {
      const auto [a, b, c] = mesh_.heights_of(t);
      const double top = std::max({sign_ * a, sign_ * b, sign_ * c});
      highest_ = std::max(highest_, top);
      open_.emplace(top + static_cast<double>(mesh_.triangle(t).error), t);
    }
  }

  LocalMesh mesh_;
  double sign_;
  double highest_ = -std::numeric_limits<double>::infinity();
  /// What may be under a triangle, and which it is.
  std::priority_queue<std::pair<double, std::uint32_t>> open_;
};

}  // namespace

Result<std::optional<delaunay::Tin>> tin_crossing(const HistoryFile& file, std::uint32_t time,
                                                  std::span<const double> heights,
                                                  std::uint32_t max_nodes, Progress& progress) {
  if (progress.is_cancelled()) return cancelled_error();
  LocalSearch search(file, time, max_nodes);
  const auto may_cross = [&](std::uint32_t t) {
    const HeightRange under = search.heights_under(t);
    const auto above = std::ranges::lower_bound(heights, under.lower);
    return above != heights.end() && *above <= under.upper;
  };
  LatticeBox all;
  for (const LatticePoint& p : file.base().vertices) all.add(p);
  LODE_CHECK(search.add(all, may_cross, progress));
  if (search.is_beyond()) return std::optional<delaunay::Tin>();
  return std::optional(search.take());
}

double expected_crossing(const HistoryFile& file, std::uint32_t time,
                         std::span<const double> heights) {
  // So many times a triangle's error is what its heights span, with the error on both sides: of
  // greedy meshes of terrain, as measured.
  constexpr double kSpan = 16;
  const HeightRange& range = file.base().range;
  const auto n_within = std::ranges::count_if(
      heights, [&](double z) { return z >= range.lower && z <= range.upper; });
  double n_nodes = 0;
  std::uint32_t begin = 0;
  double error = 0;
  for (const ToleranceStep& step : file.steps()) {
    const std::uint32_t end = std::min(step.time, time);
    if (end > begin) {
      const double span = kSpan * error * static_cast<double>(n_within);
      const double share = begin == 0 ? 1 : std::min(1.0, span / (range.upper - range.lower));
      n_nodes += share * (end - begin);
      begin = end;
    }
    error = static_cast<double>(step.error);
  }
  return n_nodes;
}

Result<std::optional<HeightRange>> height_range(const HistoryFile& file, std::uint32_t time,
                                                std::uint32_t max_nodes, Progress& progress) {
  LODE_TRY(const auto lower, OutermostVertex(file, time, -1).find(max_nodes, progress));
  if (!lower) return std::optional<HeightRange>();
  LODE_TRY(const auto upper, OutermostVertex(file, time, 1).find(max_nodes, progress));
  if (!upper) return std::optional<HeightRange>();
  return std::optional(HeightRange{*lower, *upper});
}

}  // namespace lode::insertions
