#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "lode/delaunay/greedy_insertion.h"
#include "lode/delaunay/level_queue.h"
#include "lode/delaunay/triangle_error.h"

namespace lode::delaunay {

/// Triangles beyond the tolerance, the worst first.
class StrictQueue {
 public:
  void push(std::uint32_t t, const LatticeTriangle& triangle) {
    heap_.push_back({priority_of(triangle), t});
    std::push_heap(heap_.begin(), heap_.end());
  }
  /// The worst triangle, which stays; kNoHalfEdge: there is none.
  [[nodiscard]] std::uint32_t top(const LatticeTriangles& triangles) {
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
    [[nodiscard]] bool is_current(const LatticeTriangles& triangles) const {
      return triangles[triangle].candidate != WorstSample::kNone &&
             priority_of(triangles[triangle]) == priority;
    }
  };
  void forget_replaced(const LatticeTriangles& triangles) {
    std::erase_if(heap_, [&](const Entry& entry) { return !entry.is_current(triangles); });
    std::make_heap(heap_.begin(), heap_.end());
  }

  std::vector<Entry> heap_;
};

/// What both orders do with a mesh. The judge sets candidates (WorstSample::kNone: nothing is to be
/// inserted) and errors: judge_all(mesh) of all triangles, insert(mesh, t) of those that inserting
/// the candidate of t makes, which it returns; judge_some(mesh, slots) where a run goes on.
template <typename Mesh, typename Judge>
class GreedyLoop {
 public:
  GreedyLoop(Mesh& mesh, Judge& judge, const GreedyOptions& options, Progress& progress)
      : mesh_(mesh), judge_(judge), options_(options), progress_(progress) {}

  /// `part`: that holds the mesh; `tile_bits`: see LevelQueue.
  Result<GreedyReport> run(const LatticePart& part, int tile_bits) {
    judge_.judge_all(mesh_);
    if (options_.order == InsertionOrder::strict) {
      LODE_CHECK(run_strict());
    } else {
      LODE_CHECK(run_levels(part, tile_bits));
    }
    return report();
  }
  /// In levels to the end of the first that leaves so many triangles.
  Result<GreedyReport> begin(const LatticePart& part, int tile_bits, std::size_t most_triangles) {
    judge_.judge_all(mesh_);
    LODE_CHECK(run_levels(part, tile_bits, most_triangles));
    return report();
  }
  /// In levels, of a mesh of which those triangles alone are to be judged; others have candidates
  /// and errors.
  Result<GreedyReport> go_on(std::span<const std::uint32_t> slots, const LatticePart& part,
                             int tile_bits) {
    judge_.judge_some(mesh_, slots);
    LODE_CHECK(run_levels(part, tile_bits));
    return report();
  }

 private:
  [[nodiscard]] GreedyReport report() {
    for (const LatticeTriangle& triangle : mesh_.triangles())
      report_.achieved_error =
          std::max(report_.achieved_error, static_cast<double>(triangle.error));
    // Errors are kept as floats, rounded up.
    if (report_.is_within_error)
      report_.achieved_error = std::min(report_.achieved_error, options_.max_error);
    return report_;
  }

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
      insert(queue, t);
    }
  }

  Result<void> run_levels(const LatticePart& part, int tile_bits,
                          std::size_t most_triangles = kMostTriangles) {
    LevelQueue queue(mesh_.nodes(), part, tile_bits, largest_error());
    for (std::uint32_t t = 0; t < mesh_.triangles().size(); ++t) queue_if_needed(queue, t);
    do {
      while (!queue.is_level_empty())
        for (std::uint32_t tile = 0; tile < queue.n_tiles(); ++tile)
          for (;;) {
            const std::uint32_t t = queue.pop(tile, mesh_.triangles());
            if (t == kNoHalfEdge) break;
            LODE_CHECK(check_in(queue.share_done()));
            insert(queue, t);
          }
    } while (mesh_.triangles().size() < most_triangles && queue.next_level());
    return {};
  }

  template <typename Queue>
  void insert(Queue& queue, std::uint32_t t) {
    for (const std::uint32_t made : judge_.insert(mesh_, t)) queue_if_needed(queue, made);
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
    constexpr std::uint64_t kPerReport = 1 << 14;
    if (report_.n_inserted % kPerReport != 0) return {};
    if (progress_.is_cancelled()) return cancelled_error();
    if (options_.reports) progress_.report("inserting", share);
    return {};
  }

  Mesh& mesh_;
  Judge& judge_;
  GreedyOptions options_;
  Progress& progress_;
  GreedyReport report_;
};

/// That holds a mesh's corners.
template <typename Mesh>
[[nodiscard]] LatticePart part_of(const Mesh& mesh) {
  LatticePart part{{std::numeric_limits<std::int32_t>::max(), 0}, {}};
  part.first.y = part.first.x;
  for (const LatticeTriangle& triangle : mesh.triangles())
    for (const std::uint32_t corner : triangle.corner) {
      const LatticePoint p = mesh.nodes().unpack(corner);
      part.first = {std::min(part.first.x, p.x), std::min(part.first.y, p.y)};
      part.last = {std::max(part.last.x, p.x), std::max(part.last.y, p.y)};
    }
  return part;
}

}  // namespace lode::delaunay
