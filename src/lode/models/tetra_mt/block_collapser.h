#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "lode/models/tetra_mt/build_state.h"
#include "lode/models/tetra_mt/collapse_queue.h"
#include "lode/models/tetra_mt/fan.h"
#include "lode/models/tetra_mt/held_samples.h"
#include "lode/models/tetra_mt/interfaces.h"
#include "lode/models/tetra_mt/live_tetrahedra.h"
#include "lode/models/tetra_mt/refusals.h"
#include "lode/models/tetra_mt/star.h"

namespace lode::tetra_mt {

struct CollapseRules {
  CollapseOrder order = CollapseOrder::squared_error;
  /// What is beside a collapse is looked at again at so much of its key; not where quadrics are the
  /// order, of which a collapse changes one.
  float discount = 0.7F;
  int max_link = 32;  ///< Vertices beside both ends of an edge that collapses.
  /// How far the boundary, and what lies between regions, may be from the reference's, or that from
  /// it, in the mesh's unit. What collapses do is added up or, of the boundary, measured at its
  /// vertices that went, with what edges' bends may add between them, where that is less. 0: all
  /// stays in its planes, but for a millionth of the mesh's size, or for 64 roundings of positions
  /// where these are narrow.
  double boundary_tolerance = 0;
  bool has_world_errors = false;  ///< CollapseFacts' are found.
  /// Vertices stay whose values are above, or below, all beside them in the mesh as it is at first,
  /// not only those which are so when their turn comes.
  bool keeps_extrema = false;
};

/// Collapses edges among a block's vertices. Those with others beside them stay, so that no two
/// blocks touch the same tetrahedron: blocks may be worked on side by side.
class BlockCollapser {
 public:
  /// `slots`: all tetrahedra with one of the vertices. `places`: room for a number for each vertex
  /// of the mesh and the one outside, of which nothing is expected or left.
  BlockCollapser(BuildState& state, std::span<const std::uint32_t> vertices,
                 std::span<const std::uint32_t> slots, std::vector<std::uint32_t>& places,
                 const CollapseRules& rules);

  /// All that add less than `limit`, the least first, until `n_cells` are gone; all else gets its
  /// key in the state.
  void run(float limit, std::uint64_t n_cells);
  /// Finds the keys of all, and which are locked.
  void find_keys();

  /// Of a block of all vertices.
  [[nodiscard]] RefusalCounts count_refusals();

  [[nodiscard]] std::span<const Collapse> collapses() const { return collapses_; }
  /// By collapse and field.
  [[nodiscard]] std::span<const CollapseFacts> facts() const { return facts_; }
  /// Of the collapses; once.
  [[nodiscard]] CollapseStars take_stars() { return std::move(stars_); }
  [[nodiscard]] std::uint64_t n_cells_gone() const { return n_gone_; }
  /// Puts what has changed into the state.
  void write_back();

 private:
  /// What may become of a vertex, but for the link condition.
  struct Choice {
    int kept;        ///< In its link.
    float increase;  ///< Of cost_of() errors, for each cell that goes; at least 0.
    float moved;     ///< How far the boundary, or an interface, is from the reference's then.
  };

  [[nodiscard]] std::uint32_t global(std::uint32_t vertex) const { return vertices_[vertex]; }
  [[nodiscard]] float& deviation(int triangle) {
    return state_.deviations[slots_[star_.slots[static_cast<std::size_t>(triangle)]]];
  }
  void find_inner();
  /// Others keep their keys, for blocks in which they may.
  [[nodiscard]] bool may_go(std::uint32_t vertex) const {
    return is_inner_[vertex] != 0 && state_.is_locked[global(vertex)] == 0;
  }
  [[nodiscard]] bool is_extremum() const;
  void find_interfaces_of(const Star& star, Interfaces& found) const;
  [[nodiscard]] float moved_by(int kept) const;
  [[nodiscard]] double outline_of(int kept) const;
  [[nodiscard]] double deviation_of(int kept, double limit) const;
  void note_deviations(int kept, float moved);
  void gather_boundary();
  [[nodiscard]] double measured_of(int kept, double limit) const;
  void move_boundary(int kept);
  [[nodiscard]] bool keeps_regions(int kept);
  void gather_link();
  void gather_link_values();
  void gather_samples();
  [[nodiscard]] double cost_of_sample(std::uint32_t sample) const;
  void fill_lanes();
  void find_quadrics();
  [[nodiscard]] int n_cells_beside(int kept) const;
  [[nodiscard]] bool make_fan_to(int kept);
  /// How a tetrahedron of a fan covers a sample, in doubles.
  struct Cover {
    std::size_t lane = 0;
    std::array<double, 3> weights{};  ///< Of the triangle's corners.
    double least = 0;                 ///< Of all four.
    double rounding = 0;              ///< What a weight may be off, and more.
  };
  [[nodiscard]] Cover cover_by(std::size_t lane, int kept, std::uint32_t sample) const;
  [[nodiscard]] std::optional<Cover> find_cover(int kept, const StarSamples& samples,
                                                std::size_t sample) const;
  [[nodiscard]] std::optional<Cover> find_holder(int kept, std::uint32_t sample);
  [[nodiscard]] double hull_error_of(const Cover& cover, int kept, std::uint32_t sample,
                                     std::size_t field) const;
  [[nodiscard]] double error_of(const Cover& cover, int kept, std::uint32_t sample,
                                std::size_t field) const;
  [[nodiscard]] Refusal refusal_of(std::uint32_t vertex);
  [[nodiscard]] Refusal refusal_to(int kept);
  [[nodiscard]] bool is_on_domain_boundary_alone() const;
  [[nodiscard]] bool look_at_star();
  void find_choices();
  void find_choices_by_samples();
  void find_choices_by_quadrics();
  [[nodiscard]] bool may_collapse_to(int kept);
  [[nodiscard]] bool collapse_best(float key, float limit);
  [[nodiscard]] bool collapse(const Choice& choice);
  [[nodiscard]] bool cover_samples(int kept);
  void note_facts(int kept);
  void note_held_samples(int kept);
  void note_held(int kept, std::uint32_t sample);
  [[nodiscard]] double world_error_of(int kept, std::size_t field) const;
  void note_star();
  void look_again_beside(float key, float limit);

  [[nodiscard]] bool is_by_quadrics() const { return rules_.order == CollapseOrder::quadric; }

  BuildState& state_;
  CollapseRules rules_;
  std::vector<std::uint32_t> vertices_;  ///< Own ones, those beside them, the one outside.
  std::vector<std::uint32_t> slots_;
  LiveTetrahedra live_;
  StarGatherer gatherer_;
  TetrahedraBeside beside_;
  CollapseQueue queue_;
  std::vector<Vec3d> positions_;           ///< By own and other vertex.
  std::vector<double> values_;             ///< Likewise, and by field.
  std::vector<std::uint32_t> samples_;     ///< By slot: the first.
  std::vector<CornerSets> corner_sets_;    ///< By slot.
  std::vector<std::uint32_t> makers_;      ///< By slot.
  std::vector<std::uint8_t> is_inner_;     ///< By own vertex.
  std::vector<std::uint8_t> has_changed_;  ///< By slot.
  Star star_;
  Interfaces interfaces_;  ///< Of the star.
  float deviation_ = 0;    ///< Of these from the reference's.
  /// Vertices of the reference's boundary that went into the star's faces outside, and its own.
  std::vector<std::uint32_t> on_boundary_;
  std::vector<Vec3d> boundary_points_;  ///< Likewise, in the star's unit.
  Star other_;                          ///< That of a vertex to go into, and its interfaces.
  Interfaces other_interfaces_;
  std::array<Vec3d, Star::kMaxLink> link_;  ///< Relative to the star's vertex, times scale_.
  double scale_ = 1;  ///< A power of two that makes the star about as large as 1.
  StarLanes lanes_;
  bool has_lanes_ = false;  ///< They are those of the star.
  StarSamples covered_;
  StarSamples one_beside_;  ///< One that is not of them.
  Fan fan_;
  std::vector<Choice> choices_;
  std::vector<Collapse> collapses_;
  std::vector<CollapseFacts> facts_;
  CollapseStars stars_;
  std::vector<Cover> covers_;       ///< Of a collapse, by sample.
  std::vector<double> new_errors_;  ///< And by field.
  std::uint64_t n_gone_ = 0;
};

}  // namespace lode::tetra_mt
