#pragma once

#include <functional>
#include <span>
#include <vector>

#include "lode/core/progress.h"
#include "lode/models/diamond/coarse_field.h"
#include "lode/models/diamond/own_errors.h"
#include "lode/models/diamond/part_overlap.h"
#include "lode/store/writer.h"

namespace lode::diamond {

/// Some chunks of a field that are built by themselves, and what that takes of the field: border
/// layers of kPlanEdge samples, more than nested errors of level kChunkLevel reach (7, D = 3 or 2),
/// and of a whole brick where the next part along the last axis begins.
template <int D>
struct PartPlan {
  LatticeBox<D> chunks;   ///< Positions.
  LatticeBox<D> samples;  ///< Of the field: the chunks' own and the border layers.
  Index<D> dims;          ///< Of the part's lattice; its origin is part.origin.
  Part<D> part;

  [[nodiscard]] static PartPlan of(const Shape<D>& shape, const LatticeBox<D>& chunks);
  /// One as large along each axis as any with so many chunks side by side in x.
  [[nodiscard]] static PartPlan largest(const Shape<D>& shape, std::int32_t chunks_per_part);
  /// What a PartBuilder takes for it.
  [[nodiscard]] std::uint64_t n_bytes(std::size_t sample_size) const;
};

/// Builds a field part by part: what a part needs of others are samples of its border layers and
/// the coarse samples, what it gives to others are its shares of the coarse nodes (Borgo,
/// Scopigno, Cignoni, Pascucci (2003), section 4.1.1). The order of parts does not matter, but one
/// that follows the part before it along the last axis takes over what both need.
template <int D>
class PartBuilder {
 public:
  /// `field` has its samples and stats. Parts raise the errors and widen the ranges of its nodes.
  PartBuilder(CoarseField<D>& field, Threads threads) : field_(field), threads_(threads) {}

  /// Takes the memory for parts of up to so many samples an axis, once.
  void reserve(const Index<D>& dims);
  void begin(const PartPlan<D>& plan);
  /// Of plan.samples those that are to be put: not those of the part before.
  [[nodiscard]] LatticeBox<D> missing_samples() const;
  /// Samples of a box inside plan.samples (storage type, x fastest).
  void put_samples(const LatticeBox<D>& box, const std::byte* values);
  /// After all samples. brick_done() is called n_bricks() times, by any thread.
  [[nodiscard]] Result<void> find_attributes(const Progress& progress,
                                             const std::function<void()>& brick_done);
  [[nodiscard]] std::size_t n_bricks() const { return model_.n_bricks(); }
  /// Appends the blocks of one of the part's chunks.
  [[nodiscard]] Result<void> append_chunk(const Index<D>& chunk, store::Writer& writer,
                                          const Progress& progress) const;

  /// The part, after find_attributes(): levels up to kChunkLevel and their world errors.
  [[nodiscard]] const Model<D>& model() const { return model_; }

  /// Per level up to kChunkLevel: the largest nested error of any part's nodes so far.
  [[nodiscard]] const std::vector<ErrorCode>& largest_errors() const { return largest_; }
  /// Those of parts that another builder has built.
  void set_largest_errors(std::vector<ErrorCode> largest) { largest_ = std::move(largest); }
  /// Nested error of the root, where the only part is the whole field.
  [[nodiscard]] double base_error() const { return model_.base_error(); }

 private:
  template <typename V>
  [[nodiscard]] Result<void> find_own_errors(const Progress& progress,
                                             const std::function<void()>& brick_done);
  void take_over(const PartPlan<D>& plan);
  [[nodiscard]] bool is_in_core(const Index<D>& p) const;
  [[nodiscard]] int n_own_levels() const;
  void give_own_errors();
  void nest();
  void find_worlds();
  void give_cubes();
  void give_cube(const Index<D>& q, std::size_t at);
  void find_largest();
  [[nodiscard]] ErrorCode largest_in_core(int level, std::size_t first, std::size_t end) const;

  CoarseField<D>& field_;
  Threads threads_;
  PartPlan<D> plan_;
  bool is_found_ = false;          ///< What is to be found of it.
  std::int32_t n_taken_over_ = 0;  ///< Layers of bricks along the last axis, of the part before.
  Model<D> model_;                 ///< Levels up to kChunkLevel.
  PartErrors overlap_;             ///< What the next part takes over.
  PartErrors coarse_;              ///< Own errors of the next levels, to kPlanLevel.
  std::vector<ErrorCode> largest_;
};

extern template struct PartPlan<2>;
extern template struct PartPlan<3>;
extern template class PartBuilder<2>;
extern template class PartBuilder<3>;

}  // namespace lode::diamond
