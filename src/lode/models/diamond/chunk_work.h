#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "lode/models/diamond/block_order.h"
#include "lode/models/diamond/brick_work.h"
#include "lode/models/diamond/isovalue_list.h"
#include "lode/models/diamond/kept_nodes.h"

namespace lode::diamond {

/// The bricks that a cut of a file's field has been refined down to, numbered in the order of the
/// chunks that they are loaded with.
template <int D>
class ChunkWork {
 public:
  using CoarseSelection = ManySelection<D, CoarseField<D>>;

  /// What is to be loaded: whose samples and nodes of all levels matter, and of which only those of
  /// levels from kKeptLevel on.
  struct Bricks {
    std::vector<Index<D>> fine;
    std::vector<Index<D>> coarse;
  };

  ChunkWork() = default;
  /// Of the cut that the selection makes; what is referred to must outlive it.
  ChunkWork(const CoarseField<D>& field, const CoarseSelection& selection, const CoarseCut<D>& cut)
      : field_(&field),
        selection_(&selection),
        cut_(&cut),
        brick_dims_(brick_counts<D>(field.shape)),
        work_(work_of(cut)),
        parts_(field.axes, brick_dims_, work_) {}

  [[nodiscard]] std::size_t size() const { return work_.size(); }
  /// Part i + 1 is that of brick number i.
  [[nodiscard]] const PartsOfBricks<D>& parts() const { return parts_; }
  [[nodiscard]] Index<D> chunk_of(std::size_t i) const {
    return point_of<D>(chunk_counts<D>(field_->shape), chunk_number(i));
  }
  /// Behind the last brick of the chunk that number `begin` is in.
  [[nodiscard]] std::size_t end_of_chunk(std::size_t begin) const {
    std::size_t end = begin;
    while (end < size() && chunk_number(end) == chunk_number(begin)) ++end;
    return end;
  }
  /// In a lattice that begins at `origin`, a brick's corner.
  [[nodiscard]] CutBrick<D> local(std::size_t i, const Index<D>& origin) const {
    return cut_brick<D>(*cut_, brick_dims_, work_[i], origin);
  }

  /// Of the chunk that `begin` is in, from there on; with those round it where they matter too.
  [[nodiscard]] Bricks bricks_of(std::size_t begin, bool with_round) const {
    Bricks bricks;
    for (std::size_t i = begin, end = end_of_chunk(begin); i < end; ++i)
      (is_fine(brick_of(i)) ? bricks.fine : bricks.coarse).push_back(brick_of(i));
    if (with_round)
      for (const std::size_t i : round(begin)) bricks.fine.push_back(brick_of(i));
    return bricks;
  }
  /// Fine ones beside the chunk that `begin` is in, or at its edges and corners.
  [[nodiscard]] std::vector<std::size_t> round(std::size_t begin) const {
    std::vector<std::size_t> round;
    if (begin == size()) return round;
    const Index<D> chunk = chunk_of(begin);
    const LatticeBox<D> samples =
        samples_of_chunks<D>(field_->shape, {chunk, chunk + all_equal<D>(1)});
    Index<D> first;
    Index<D> n;
    for (std::size_t a = 0; a < as_size(D); ++a) {
      first[a] = std::max(samples.lower[a] / kBrickEdge<D> - 1, 0);
      n[a] = std::min((samples.upper[a] - 1) / kBrickEdge<D> + 2, brick_dims_[a]) - first[a];
    }
    for (std::size_t at = 0; at < n_points<D>(n); ++at) {
      const Index<D> brick = first + point_of<D>(n, at);
      const std::uint32_t part = parts_.of(brick);
      if (part != 0 && chunk_number(part - 1) != chunk_number(begin) && is_fine(brick))
        round.push_back(part - 1);
    }
    return round;
  }

 private:
  [[nodiscard]] Index<D> brick_of(std::size_t i) const {
    return point_of<D>(brick_dims_, work_[i].brick);
  }
  [[nodiscard]] std::size_t chunk_number(std::size_t i) const {
    return chunk_of_brick<D>(field_->shape, brick_of(i));
  }
  /// Whether finer nodes of a brick matter: nodes of level kKeptLevel are refined.
  [[nodiscard]] bool is_fine(const Index<D>& brick) const {
    return !field_->is_needed() || has_fine_node(brick);
  }
  [[nodiscard]] bool has_fine_node(const Index<D>& brick) const {
    return any_kept_node<D>(field_->shape, brick, [&](const Index<D>& q, std::size_t at) {
      const Index<D> centre = q * (std::int32_t{1} << kKeptLevel);
      return selection_->is_active(kKeptLevel, at) &&
             (selection_->exceeds_tolerance(selection_->error(kKeptLevel, at)) ||
              field_->shape.reaches_across(centre, kKeptLevel) || selection_->is_wanted(centre));
    });
  }

  const CoarseField<D>* field_ = nullptr;
  const CoarseSelection* selection_ = nullptr;
  const CoarseCut<D>* cut_ = nullptr;
  Index<D> brick_dims_;
  std::vector<BrickWork<D>> work_;
  PartsOfBricks<D> parts_;
};

}  // namespace lode::diamond
