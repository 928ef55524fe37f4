#pragma once

// Several isovalues' surfaces out of a file, one behind the other, in as few passes as memory lets.

#include <deque>
#include <span>
#include <utility>
#include <vector>

#include "lode/api/isovalue_parts.h"
#include "lode/core/surface_sink.h"
#include "lode/models/diamond/file_extract.h"

namespace lode {

/// Surfaces that come side by side while the one before them goes to its sink: as many as fit, the
/// first ones.
class HeldSurfaces {
 public:
  HeldSurfaces(std::size_t n, std::uint64_t max_bytes) : max_bytes_(max_bytes), held_(n) {}

  /// Null, from then on, where memory has ended; the last of them go first.
  [[nodiscard]] SurfaceSink* sink(std::size_t i) {
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
    for (const Held& held : held_) {
      const Surface& s = held.surface;
      n += s.positions.capacity() * sizeof(s.positions[0]) +
           s.normals.capacity() * sizeof(s.normals[0]) +
           s.triangles.capacity() * sizeof(s.triangles[0]) +
           s.lines.capacity() * sizeof(s.lines[0]);
    }
    return n;
  }

  std::uint64_t max_bytes_;
  std::deque<Held> held_;  ///< Stay where they are.
};

/// extract_from_file() of all isovalues, in their order: before(isovalue) and after(isovalue) come
/// round each surface, of which the first goes straight to the sink and others wait in max_bytes of
/// memory. What does not fit is left to another pass.
template <int D, typename Before, typename After>
Result<void> extract_passes(const diamond::CoarseField<D>& field, store::BlockCache& blocks,
                            const ExtractOptions& options, std::uint64_t max_bytes,
                            SurfaceSink& sink, ExtractReport& report, const Before& before,
                            const After& after, Progress& progress) {
  std::span<const double> left = options.isovalues;
  while (!left.empty()) {
    const auto isovalues = diamond::IsovalueList::of(left);
    std::vector<std::size_t> place(left.size());  // in `left`, by number
    for (std::size_t i = 0; i < left.size(); ++i) place[isovalues.rank(left[i]) - 1] = i;
    HeldSurfaces held(left.size() - 1, max_bytes);
    before(left[0]);
    LODE_TRY(const auto part,
             diamond::extract_from_file<D>(
                 field, blocks, isovalues, query_of<D>(left[0], options, report),
                 [&](std::size_t i) { return place[i] == 0 ? &sink : held.sink(place[i] - 1); },
                 progress));
    add_part(part, report);
    after(left[0]);
    const std::size_t n_held = held.size();
    for (std::size_t i = 0; i < n_held; ++i) {
      before(left[i + 1]);
      SurfacePiece piece;
      piece.surface = held.take(i);
      piece.first_new = sink.n_vertices();
      LODE_CHECK(sink.add(std::move(piece)));
      after(left[i + 1]);
    }
    left = left.subspan(1 + n_held);
  }
  return {};
}

}  // namespace lode
