#include "lode/delaunay/greedy_insertion.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "lode/delaunay/level_queue.h"
#include "lode/delaunay/triangle_judge.h"

namespace lode::delaunay {
namespace {

constexpr std::uint64_t kPerReport = 1 << 14;
constexpr const char* kPhase = "inserting";
/// Half-edges are numbered in 32 bits, four a triangle; an insertion adds two.
constexpr std::uint64_t kMostTriangles = (std::uint64_t{1} << 30) - 8;

/// Triangles beyond the tolerance, the worst first.
class StrictQueue {
 public:
  void push(std::uint32_t t, const LatticeTriangle& triangle) {
    heap_.push_back({priority_of(triangle), t});
    std::push_heap(heap_.begin(), heap_.end());
  }
  /// The worst triangle, which stays; kNoHalfEdge: there is none.
  [[nodiscard]] std::uint32_t top(const std::vector<LatticeTriangle>& triangles) {
    if (heap_.size() > 2 * triangles.size() + kSpare) forget_replaced(triangles);
    while (!heap_.empty()) {
      if (heap_.front().is_current(triangles)) return heap_.front().triangle;
      std::pop_heap(heap_.begin(), heap_.end());
      heap_.pop_back();
    }
    return kNoHalfEdge;
  }

 private:
  static constexpr std::size_t kSpare = 1024;
  struct Entry {
    std::uint64_t priority;
    std::uint32_t triangle;

    bool operator<(const Entry& other) const {
      return priority != other.priority ? priority < other.priority : triangle > other.triangle;
    }
    [[nodiscard]] bool is_current(const std::vector<LatticeTriangle>& triangles) const {
      return triangles[triangle].candidate != WorstSample::kNone &&
             priority_of(triangles[triangle]) == priority;
    }
  };
  void forget_replaced(const std::vector<LatticeTriangle>& triangles) {
    std::erase_if(heap_, [&](const Entry& entry) { return !entry.is_current(triangles); });
    std::make_heap(heap_.begin(), heap_.end());
  }

  std::vector<Entry> heap_;
};

/// What both orders do.
template <typename T>
class Insertion {
 public:
  /// `sparse`: see TriangleJudge.
  Insertion(LatticeMesh& mesh, const SampleRows<T>& rows, const SparseSamples<T>* sparse,
            double lower, double upper, const GreedyOptions& options, Progress& progress)
      : mesh_(mesh),
        judge_(rows, sparse, lower, upper, options.max_error),
        options_(options),
        progress_(progress) {}

  Result<GreedyReport> run(LatticePoint size) {
    const auto n = static_cast<std::uint32_t>(mesh_.triangles().size());
    for (std::uint32_t t = 0; t < n; ++t) judge_.judge(mesh_.triangle(t));
    if (options_.observer != nullptr) options_.observer->on_start(mesh_);
    if (options_.order == InsertionOrder::strict) {
      LODE_CHECK(run_strict());
    } else {
      LODE_CHECK(run_levels(size));
    }
    for (const LatticeTriangle& triangle : mesh_.triangles())
      report_.achieved_error =
          std::max(report_.achieved_error, static_cast<double>(triangle.error));
    // Errors are kept as floats, rounded up.
    if (report_.is_within_error)
      report_.achieved_error = std::min(report_.achieved_error, options_.max_error);
    return report_;
  }

 private:
  Result<void> run_strict() {
    StrictQueue queue;
    for (std::uint32_t t = 0; t < mesh_.triangles().size(); ++t) queue_if_needed(queue, t);
    const float first = largest_error();
    for (;;) {
      const std::uint32_t t = queue.top(mesh_.triangles());
      if (t == kNoHalfEdge) return {};
      const LatticeTriangle triangle = mesh_.triangle(t);
      const std::uint64_t n = mesh_.triangles().size();
      if (n + mesh_.growth(triangle.candidate, t) > options_.max_triangles) {
        report_.is_within_error = false;
        return {};
      }
      LODE_CHECK(check_in(share_left(first, triangle.error)));
      insert(queue, triangle.candidate, t);
    }
  }

  Result<void> run_levels(LatticePoint size) {
    LevelQueue queue(mesh_.packing(), size, largest_error());
    for (std::uint32_t t = 0; t < mesh_.triangles().size(); ++t) queue_if_needed(queue, t);
    do {
      while (!queue.is_level_empty())
        for (std::uint32_t tile = 0; tile < queue.n_tiles(); ++tile)
          for (;;) {
            const std::uint32_t t = queue.pop(tile, mesh_.triangles());
            if (t == LevelQueue::kEmpty) break;
            LODE_CHECK(check_in(queue.share_done()));
            insert(queue, mesh_.triangle(t).candidate, t);
          }
    } while (queue.next_level());
    return {};
  }

  template <typename Queue>
  void insert(Queue& queue, std::uint32_t node, std::uint32_t t) {
    const std::size_t n_before = mesh_.triangles().size();
    const std::span<const std::uint32_t> slots = mesh_.insert(node, t);
    for (const std::uint32_t made : slots) {
      judge_.judge(mesh_.triangle(made));
      queue_if_needed(queue, made);
    }
    if (options_.observer != nullptr) {
      const std::size_t n_added = mesh_.triangles().size() - n_before;
      options_.observer->on_insertion(mesh_, node, slots, slots.size() - n_added);
    }
    ++report_.n_inserted;
  }

  template <typename Queue>
  void queue_if_needed(Queue& queue, std::uint32_t t) {
    const LatticeTriangle& triangle = mesh_.triangle(t);
    if (triangle.candidate != WorstSample::kNone) queue.push(t, triangle);
  }

  [[nodiscard]] float largest_error() const {
    float largest = 0;
    for (const LatticeTriangle& triangle : mesh_.triangles())
      largest = std::max(largest, triangle.error);
    return largest;
  }

  /// How far errors have fallen, as octaves.
  [[nodiscard]] double share_left(float first, float error) const {
    const double last = std::max(options_.max_error, static_cast<double>(first) * 0x1p-16);
    return std::clamp(std::log(first / error) / std::log(std::max(first / last, 1.001)), 0.0, 1.0);
  }

  Result<void> check_in(double share) {
    if (mesh_.triangles().size() > kMostTriangles)
      return fail("expected up to {} triangles, got more: a larger tolerance takes fewer",
                  kMostTriangles);
    if (report_.n_inserted % kPerReport != 0) return {};
    if (progress_.is_cancelled()) return cancelled_error();
    progress_.report(kPhase, share);
    return {};
  }

  LatticeMesh& mesh_;
  TriangleJudge<T> judge_;
  GreedyOptions options_;
  Progress& progress_;
  GreedyReport report_;
};

}  // namespace

template <typename T>
Result<GreedyReport> insert_greedily(LatticeMesh& mesh, const SampleRows<T>& rows, double lower,
                                     double upper, const GreedyOptions& options,
                                     Progress& progress) {
  LODE_EXPECTS(options.max_error >= 0);
  LODE_EXPECTS(options.order == InsertionOrder::strict ||
               options.max_triangles == std::numeric_limits<std::uint64_t>::max());
  LatticePoint size;
  for (const LatticeTriangle& triangle : mesh.triangles())
    for (const std::uint32_t corner : triangle.corner) {
      const LatticePoint p = mesh.packing().unpack(corner);
      size = {std::max(size.x, p.x), std::max(size.y, p.y)};
    }
  std::optional<SparseSamples<T>> sparse;
  if (options.order == InsertionOrder::levels) sparse.emplace(rows, size);
  return Insertion<T>(mesh, rows, sparse ? &*sparse : nullptr, lower, upper, options, progress)
      .run(size);
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
