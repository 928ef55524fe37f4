#pragma once

#include <functional>
#include <vector>

#include "lode/models/diamond/distance_search.h"
#include "lode/models/diamond/file_parts.h"
#include "lode/models/diamond/leaf_facets.h"
#include "lode/models/diamond/refinable.h"
#include "lode/models/diamond/selection.h"

namespace lode::diamond {

/// Some bricks of a file's part, and those round them, in which surfaces are held against each
/// other. Leaves are no larger than bricks: all larger nodes are wanted.
class PartWindow : public DistanceWindow {
 public:
  /// Numbered as those of the part's model.
  struct Bricks {
    std::vector<Index<3>> fresh;  ///< Own ones that are held for the first time,
    std::vector<Index<3>> again;  ///< or not,
    std::vector<Index<3>> round;  ///< and those round them.
    /// Facets of full resolution beyond it are left out, as too far from the own ones to prove
    /// anything; of the model's lattice.
    LatticeBox<3> near;
  };
  /// Where they are.
  struct Place {
    const CoarseField<3>& field;
    const FilePart<3>& part;
  };

  /// `wanted`: of the field; on_new(centre) hears of each node that comes in. What is referred to
  /// must outlive it.
  PartWindow(const Place& place, const IsosurfaceQuery& query, Bricks bricks, NodeSet<3>& wanted,
             std::function<void(const Index<3>&)> on_new);

  /// Before the search: finds what full() gives, if that is up to so many facets; whether it is.
  [[nodiscard]] bool find_full(std::size_t n_most, const Progress& progress);
  /// Of the whole, for progress.
  void set_share_done(double share) { share_done_ = share; }
  /// Of full resolution, in bricks that are held for the first time.
  [[nodiscard]] std::uint64_t n_first() const { return n_first_; }

  Facets full(const Progress& /*progress*/) override { return std::move(full_); }
  Facets cut(const Progress& progress) override;
  std::uint64_t insert_guess() override { return 0; }  // it came with the chunk
  std::uint64_t insert(const Index<3>& centre) override;
  void forget_new() override {
    is_all_fresh_ = false;
    fresh_here_.clear();
  }
  [[nodiscard]] bool contains(const Index<3>& centre) const override {
    return wanted_.contains(centre);
  }
  [[nodiscard]] bool is_refined(const Simplex<3>& s) const override;
  [[nodiscard]] const Shape<3>& shape() const override { return field_.shape; }
  [[nodiscard]] double share_done() const override { return share_done_; }

 private:
  [[nodiscard]] LatticeBox<3> sure() const;
  [[nodiscard]] FieldBricks of(std::span<const Index<3>> bricks, const LatticeBox<3>& known) const {
    return {part_.model(), part_.origin(), field_.info.grid, bricks, known};
  }
  [[nodiscard]] bool add_full(std::span<const Index<3>> bricks, std::size_t n_most,
                              const Progress& progress);

  const CoarseField<3>& field_;
  const FilePart<3>& part_;
  Bricks bricks_;
  IsosurfaceQuery query_;
  Refinable<3> nodes_;
  NodeSet<3>& wanted_;
  NodeSet<3> wanted_here_;
  NodeSet<3> fresh_here_;
  bool is_all_fresh_ = true;
  std::function<void(const Index<3>&)> on_new_;
  ToleranceSelection<3, CoarseField<3>> selection_;
  Facets full_;
  std::uint64_t n_first_ = 0;
  double share_done_ = 0;
};

}  // namespace lode::diamond
