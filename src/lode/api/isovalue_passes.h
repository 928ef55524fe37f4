#pragma once

// Several isovalues' surfaces out of a file, one behind the other, in as few passes as memory lets.

#include <algorithm>
#include <deque>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "lode/api/common_nodes.h"
#include "lode/api/isovalue_parts.h"
#include "lode/core/stopwatch.h"
#include "lode/core/surface_sink.h"
#include "lode/models/diamond/file_extract.h"

namespace lode {

/// Surfaces that come side by side while the one before them goes to its sink: the first of them
/// that fit.
class HeldSurfaces {
 public:
  HeldSurfaces(std::size_t n, std::uint64_t max_bytes) : max_bytes_(max_bytes), held_(n) {}

  /// Null, from then on, where memory has ended: the last ones are dropped.
  [[nodiscard]] SurfaceSink* sink_or_drop(std::size_t i) {
    while (n_bytes() > max_bytes_) held_.pop_back();
    return i < held_.size() ? &held_[i].collector : nullptr;
  }
  /// How many are there.
  [[nodiscard]] std::size_t size() const { return held_.size(); }
  [[nodiscard]] Surface take(std::size_t i) { return std::exchange(held_[i].surface, {}); }

 private:
  struct Held {
    Surface surface;
    SurfaceCollector collector{surface};
  };
  [[nodiscard]] std::uint64_t n_bytes() const {
    std::uint64_t n = 0;
    for (const Held& held : held_) n += held.surface.n_bytes();
    return n;
  }

  std::uint64_t max_bytes_;
  std::deque<Held> held_;  ///< Stay where they are.
};

/// What an isovalue's surface and its parts of a chunk may take, before one of them is known: three
/// triangles for twenty samples, as noisy scans have.
template <int D>
std::uint64_t guessed_bytes(const diamond::CoarseField<D>& field) {
  const auto n = static_cast<std::uint64_t>(field.info.grid.n_samples());
  constexpr auto kChunk = std::uint64_t{1} << (D == 3 ? 24 : 20);
  return 3 * n + 5 * std::min(n, kChunk);
}

/// Passes on surfaces that were held while the one before them was made.
template <typename Before, typename After>
Result<void> pass_on(std::span<const double> isovalues, HeldSurfaces& held, SurfaceSink& sink,
                     const Before& before, const After& after, Progress& progress) {
  for (std::size_t i = 0; i < isovalues.size(); ++i) {
    if (progress.is_cancelled()) return cancelled_error();
    before(isovalues[i]);
    SurfacePiece piece;
    piece.surface = held.take(i);
    piece.first_new = sink.n_vertices();
    LODE_CHECK(sink.add(std::move(piece)));
    after(isovalues[i]);
  }
  return {};
}

/// The nodes that all surfaces want refined whatever their error, and what they leave out.
using WantedNodes = std::function<Result<const CommonNodes*>()>;

/// extract_from_file() of all isovalues, in their order: before(isovalue) and after(isovalue) come
/// round each surface, of which the first of a pass goes straight to the sink and others wait.
/// These, and their parts, are to take max_bytes of memory; what does not fit is left to another
/// pass, and where none fits each has its own. `wanted_nodes` may be empty.
template <int D, typename Before, typename After>
Result<void> extract_passes(const diamond::CoarseField<D>& field, store::BlockCache& blocks,
                            const ExtractOptions& options, std::uint64_t max_bytes,
                            SurfaceSink& sink, ExtractReport& report, const Before& before,
                            const After& after, const WantedNodes& wanted_nodes, Progress& progress,
                            const diamond::SeePart<D>& see_part = {}) {
  std::span<const double> left = options.isovalues;
  std::uint64_t bytes_each = guessed_bytes(field);
  while (!left.empty()) {
    const std::uint64_t n_beside = max_bytes / bytes_each;
    const auto some = left.first(std::min<std::uint64_t>(left.size(), 1 + n_beside));
    const auto isovalues = diamond::IsovalueList::of(some);
    std::vector<std::size_t> place(some.size());  // in `some`, by number
    for (std::size_t i = 0; i < some.size(); ++i) place[isovalues.rank(some[i]) - 1] = i;
    HeldSurfaces held(some.size() - 1, max_bytes);
    before(some[0]);
    auto query = query_of<D>(some[0], options, report);
    if (wanted_nodes) {
      LODE_TRY(const CommonNodes* const common, wanted_nodes());
      query.wanted = common->wanted ? &*common->wanted : nullptr;
      query.weak = &common->weak;
    }
    LODE_TRY(const auto part, diamond::extract_from_file<D>(
                                  field, blocks, isovalues, query,
                                  [&](std::size_t i) {
                                    return place[i] == 0 ? &sink : held.sink_or_drop(place[i] - 1);
                                  },
                                  progress, see_part));
    add_part(part, report);
    after(some[0]);
    const Stopwatch watch;
    LODE_CHECK(pass_on(some.subspan(1, held.size()), held, sink, before, after, progress));
    report.seconds.geometry += watch.seconds();
    left = left.subspan(1 + held.size());
    bytes_each = std::max<std::uint64_t>(1, part.surface_bytes + part.part_bytes);
  }
  return {};
}

}  // namespace lode
