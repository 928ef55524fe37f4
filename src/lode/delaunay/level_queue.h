#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <vector>

#include "lode/delaunay/lattice_mesh.h"

namespace lode::delaunay {

/// Triangles by levels of their errors, which fall by octaves; in a level by tiles of their
/// candidates; in a tile by 16 steps an octave, the worst first. What is replaced while it waits is
/// recognised when its turn comes. `Nodes`: as of NodeMesh.
template <typename Nodes>
class LevelQueue {
 public:
  static constexpr std::uint32_t kEmpty = 0xffffffff;

  /// Tiles of the part are 2^tile_bits columns and rows wide. `first_error`: about the largest that
  /// there will be.
  LevelQueue(Nodes nodes, const LatticePart& part, int tile_bits, float first_error)
      : nodes_(nodes),
        first_(part.first),
        tile_bits_(tile_bits),
        n_tiles_x_(((part.last.x - part.first.x) >> tile_bits) + 1),
        n_tiles_(static_cast<std::uint32_t>(n_tiles_x_) *
                 static_cast<std::uint32_t>(((part.last.y - part.first.y) >> tile_bits) + 1)),
        top_(step_of(first_error)),
        heads_(std::size_t{n_tiles_} * kSteps, kEmpty),
        n_waiting_(kLevels, 0) {}

  [[nodiscard]] std::uint32_t n_tiles() const { return n_tiles_; }

  /// The triangle has a candidate. It waits in the current level where its error is above that.
  void push(std::uint32_t t, const LatticeTriangle& triangle) {
    const LatticePoint at = nodes_.unpack(triangle.candidate);
    const auto tile = static_cast<std::uint32_t>(((at.y - first_.y) >> tile_bits_) * n_tiles_x_ +
                                                 ((at.x - first_.x) >> tile_bits_));
    const int step =
        std::clamp(top_ - step_of(triangle.error), level_ * kStepsPerLevel, kSteps - 1);
    std::uint32_t& head = head_of(tile, step);
    const Waiting entry{t, triangle.candidate, triangle.error, head};
    if (free_ != kEmpty) {
      head = free_;
      free_ = waiting_[free_].next;
      waiting_[head] = entry;
    } else {
      head = static_cast<std::uint32_t>(waiting_.size());
      waiting_.push_back(entry);
    }
    ++n_waiting_[static_cast<std::size_t>(step / kStepsPerLevel)];
  }

  /// Of the current level and a tile, a triangle of the worst step that is still what it was when
  /// it was pushed, or kEmpty.
  [[nodiscard]] std::uint32_t pop(std::uint32_t tile, const LatticeTriangles& triangles) {
    for (int i = 0; i < kStepsPerLevel; ++i) {
      std::uint32_t& head = head_of(tile, level_ * kStepsPerLevel + i);
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
  /// Of the mantissa, that tell steps apart.
  static constexpr int kStepBits = 4;
  static constexpr int kStepsPerLevel = 16;
  /// Octaves; smaller errors share the last step.
  static constexpr int kLevels = 32;
  static constexpr int kSteps = kLevels * kStepsPerLevel;

  [[nodiscard]] static int step_of(float error) {
    return static_cast<int>(std::bit_cast<std::uint32_t>(error) >> (23 - kStepBits));
  }
  [[nodiscard]] std::uint32_t& head_of(std::uint32_t tile, int step) {
    return heads_[std::size_t{tile} * kSteps + static_cast<std::size_t>(step)];
  }

  Nodes nodes_;
  LatticePoint first_;
  int tile_bits_;
  std::int32_t n_tiles_x_;
  std::uint32_t n_tiles_;
  int top_;
  int level_ = 0;
  std::vector<std::uint32_t> heads_;  ///< By tiles, then steps.
  std::vector<std::uint64_t> n_waiting_;
  UninitializedArray<Waiting> waiting_;
  std::uint32_t free_ = kEmpty;
};

}  // namespace lode::delaunay
