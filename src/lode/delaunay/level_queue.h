#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <vector>

#include "lode/delaunay/lattice_mesh.h"

namespace lode::delaunay {

/// Triangles by levels of their errors, which fall in quarters of an octave, and in a level by
/// tiles of their candidates. What is replaced while it waits is recognised when its turn comes.
class LevelQueue {
 public:
  static constexpr std::uint32_t kEmpty = 0xffffffff;

  /// `first_error`: about the largest that there will be.
  LevelQueue(LatticePacking packing, LatticePoint size, float first_error)
      : packing_(packing),
        n_tiles_x_((size.x >> kTileBits) + 1),
        n_tiles_(static_cast<std::uint32_t>(n_tiles_x_) *
                 static_cast<std::uint32_t>((size.y >> kTileBits) + 1)),
        top_(quarter_octave(first_error)),
        heads_(std::size_t{n_tiles_} * kLevels, kEmpty),
        n_waiting_(kLevels, 0) {}

  [[nodiscard]] std::uint32_t n_tiles() const { return n_tiles_; }

  /// The triangle has a candidate. Never above the current level.
  void push(std::uint32_t t, const LatticeTriangle& triangle) {
    const LatticePoint at = packing_.unpack(triangle.candidate);
    const auto tile =
        static_cast<std::uint32_t>((at.y >> kTileBits) * n_tiles_x_ + (at.x >> kTileBits));
    const int level = std::clamp(top_ - quarter_octave(triangle.error), level_, kLevels - 1);
    std::uint32_t& head = heads_[static_cast<std::size_t>(level) * n_tiles_ + tile];
    const Waiting entry{t, triangle.candidate, triangle.error, head};
    if (free_ != kEmpty) {
      head = free_;
      free_ = waiting_[free_].next;
      waiting_[head] = entry;
    } else {
      head = static_cast<std::uint32_t>(waiting_.size());
      waiting_.push_back(entry);
    }
    ++n_waiting_[static_cast<std::size_t>(level)];
  }

  /// The last triangle pushed to a tile of the current level that is still what it was, or kEmpty.
  [[nodiscard]] std::uint32_t pop(std::uint32_t tile,
                                  const std::vector<LatticeTriangle>& triangles) {
    std::uint32_t& head = heads_[static_cast<std::size_t>(level_) * n_tiles_ + tile];
    while (head != kEmpty) {
      const std::uint32_t at = head;
      const Waiting entry = waiting_[at];
      head = entry.next;
      waiting_[at].next = free_;
      free_ = at;
      --n_waiting_[static_cast<std::size_t>(level_)];
      const LatticeTriangle& triangle = triangles[entry.triangle];
      if (triangle.candidate == entry.candidate && triangle.error == entry.error)
        return entry.triangle;
    }
    return kEmpty;
  }

  [[nodiscard]] bool is_level_empty() const {
    return n_waiting_[static_cast<std::size_t>(level_)] == 0;
  }
  /// False after the last.
  [[nodiscard]] bool next_level() { return ++level_ < kLevels; }
  [[nodiscard]] double share_done() const { return static_cast<double>(level_) / kLevels; }

 private:
  struct Waiting {
    std::uint32_t triangle, candidate;
    float error;
    std::uint32_t next;
  };
  /// 128 by 128 samples.
  static constexpr int kTileBits = 7;
  /// 32 octaves; smaller errors share the last.
  static constexpr int kLevels = 128;

  [[nodiscard]] static int quarter_octave(float error) {
    return static_cast<int>(std::bit_cast<std::uint32_t>(error) >> 21);
  }

  LatticePacking packing_;
  std::int32_t n_tiles_x_;
  std::uint32_t n_tiles_;
  int top_;
  int level_ = 0;
  std::vector<std::uint32_t> heads_;  ///< By levels, then tiles.
  std::vector<std::uint64_t> n_waiting_;
  std::vector<Waiting> waiting_;
  std::uint32_t free_ = kEmpty;
};

}  // namespace lode::delaunay
