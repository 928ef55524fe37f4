#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/delaunay/lattice.h"

namespace lode {

/// The worst error of the samples that one worker has seen, and where it is: of equal ones in the
/// first row, then column.
template <typename Real>
struct WorstSeen {
  std::uint64_t n_beyond = 0;  ///< Samples that err by more than is allowed.
  Real worst = 0;
  delaunay::LatticePoint at{};

  void join(const WorstSeen& other) {
    n_beyond += other.n_beyond;
    const bool is_first =
        std::pair(other.at.y, other.at.x) < std::pair(at.y, at.x) && other.worst == worst;
    if (other.worst > worst || is_first) {
      worst = other.worst;
      at = other.at;
    }
  }
};

/// look(triangle, seen) for n triangles, so many at once; what all have seen, the same for any
/// number of threads. Fails when cancelled.
template <typename Real, typename Look>
[[nodiscard]] Result<WorstSeen<Real>> look_at_triangles(std::size_t n, std::size_t at_once,
                                                        Threads threads, Progress& progress,
                                                        const Look& look) {
  std::vector<WorstSeen<Real>> seen(static_cast<std::size_t>(n_workers(threads)));
  const std::size_t n_pieces = (n + at_once - 1) / at_once;
  std::atomic<std::size_t> n_done{0};
  parallel_for(n_pieces, threads, 1, [&](std::size_t piece, int worker) {
    if (progress.is_cancelled()) return;
    for (std::size_t t = piece * at_once; t < std::min(n, (piece + 1) * at_once); ++t)
      look(t, seen[static_cast<std::size_t>(worker)]);
    progress.report("measuring", static_cast<double>(++n_done) / static_cast<double>(n_pieces));
  });
  if (progress.is_cancelled()) return cancelled_error();
  WorstSeen<Real> all;
  for (const WorstSeen<Real>& one : seen) all.join(one);
  return all;
}

}  // namespace lode
