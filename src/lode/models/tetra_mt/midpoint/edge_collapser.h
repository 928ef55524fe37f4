#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "lode/models/tetra_mt/collapse_queue.h"
#include "lode/models/tetra_mt/fan.h"
#include "lode/models/tetra_mt/held_samples.h"
#include "lode/models/tetra_mt/interfaces.h"
#include "lode/models/tetra_mt/live_tetrahedra.h"
#include "lode/models/tetra_mt/midpoint/edge_patch.h"
#include "lode/models/tetra_mt/midpoint/state.h"
#include "lode/models/tetra_mt/refusals.h"
#include "lode/models/tetra_mt/star.h"

namespace lode::tetra_mt::midpoint {

/// Vertices beside an edge that collapses, the one outside among them: so the star that comes of it
/// has at most 60 tetrahedra, those to the vertex outside among them.
inline constexpr int kMaxLink = 32;
/// Of a vertex that is not in a link.
inline constexpr std::uint8_t kNoPlace = 0xFF;

/// Collapses edges among a block's vertices. Those with others beside an end stay, so that no two
/// blocks touch the same tetrahedron: blocks may be worked on side by side. Each edge belongs to
/// the end of the smaller slot, which waits with the key of the best of its own.
class EdgeCollapser {
 public:
  /// `slots`: all tetrahedra with one of the vertices. `places`: room for a number for each vertex
  /// of the mesh and the one outside, of which nothing is expected or left.
  EdgeCollapser(State& state, std::span<const std::uint32_t> vertices,
                std::span<const std::uint32_t> slots, std::vector<std::uint32_t>& places);

  /// All that add less than `limit`, the least first, until `n_cells` are gone; all else gets its
  /// key in the state.
  void run(float limit, std::uint64_t n_cells);
  /// Finds which of the first `n` vertices are locked, and then their keys; what is beside them
  /// must be among the block's vertices, too, and be known to be locked or not.
  void find_locked(std::size_t n);
  /// Where quadrics are the order: those of the first n, before any keys.
  void find_quadrics(std::size_t n);
  void find_keys(std::size_t n);
  /// Does a collapse again that was chosen for other fields, of vertices by their places in the
  /// block, all of whose neighbours are of it. The same samples come to the same tetrahedra. False,
  /// and nothing done, where there is no such edge, or rounding leaves open what covers a sample.
  [[nodiscard]] bool repeat(const EdgeCollapse& given);

  /// Of the block's vertices that are left, which must be all of the mesh, in the order of their
  /// slots.
  [[nodiscard]] RefusalCounts count_refusals();

  [[nodiscard]] std::span<const EdgeCollapse> collapses() const { return collapses_; }
  /// By collapse and field.
  [[nodiscard]] std::span<const EdgeFacts> facts() const { return facts_; }
  [[nodiscard]] std::uint64_t n_cells_gone() const { return n_gone_; }
  /// Puts what has changed into the state.
  void write_back();

 private:
  /// What may become of an edge, but for the link condition.
  struct Choice {
    int place;       ///< Of the other end, in the star's link.
    float increase;  ///< As the order says, for each cell that goes; at least 0.
    bool is_inner;   ///< The other end has none but own vertices beside it.
  };
  /// Where the new vertex may lie.
  struct Rule {
    Place position;
    double moved;  ///< How far the boundary, or an interface, moves: first by itself, then in all.
  };
  /// The new vertex's value of a field.
  struct NewValue {
    Place place;
    std::int32_t code;
    double value;
  };
  /// How a tetrahedron of a fan covers a sample, in doubles.
  struct Cover {
    std::size_t lane = 0;
    std::array<double, 3> weights{};  ///< Of the triangle's corners.
    double least = 0;                 ///< Of all four.
    double rounding = 0;              ///< What a weight may be off, and more.
  };

  [[nodiscard]] std::uint32_t global(std::uint32_t vertex) const { return vertices_[vertex]; }
  [[nodiscard]] bool is_inner(const Star& star) const;
  [[nodiscard]] bool owns_edge_to(std::uint32_t other) const;
  [[nodiscard]] bool is_by_quadrics() const { return state_.order == CollapseOrder::quadric; }
  [[nodiscard]] bool is_by_space() const { return state_.order == CollapseOrder::space_error; }

  // edge_star.cpp: what is at a vertex, and at an edge.
  void look_at_star();
  void gather_own_samples();
  [[nodiscard]] bool look_at_other(int place);
  [[nodiscard]] bool look_at_edge(int place);
  [[nodiscard]] bool join_links();
  void join_triangles(int place);
  void add_link_vertex(int at, std::uint32_t vertex);
  void add_sample(std::uint32_t sample);
  void add_samples_of(std::uint32_t slot);
  [[nodiscard]] int n_cells_beside(int place) const;

  // edge_rules.cpp: where the new vertex lies.
  void find_extrema(const Star& star, std::vector<int>& found) const;
  void find_interfaces_of(const Star& star, Interfaces& found) const;
  [[nodiscard]] double height(const Star& star, const Interfaces& interfaces, int kept) const;
  [[nodiscard]] std::optional<Rule> place_rule_of(int place);
  [[nodiscard]] std::optional<Rule> rule_of(int place);
  [[nodiscard]] std::optional<Rule> flat_rule_of(int place, double limit);
  [[nodiscard]] Rule bent_rule_of(int place, double limit);
  [[nodiscard]] double deviation(const Star& star, const Interfaces& interfaces) const;
  void find_ring(const Star& star, const Interfaces& interfaces, int kept,
                 std::vector<std::uint32_t>& ring) const;
  [[nodiscard]] double deviation_of_end(const Star& star, const Interfaces& interfaces, int kept,
                                        double limit);
  [[nodiscard]] double deviation_of_middle(int place, double limit);
  void note_deviations(int place);
  [[nodiscard]] bool find_value_places(Place position);
  void take_value_places(Place position);
  [[nodiscard]] bool keeps_regions(int place) const;

  void find_vertex(int place);
  [[nodiscard]] bool make_fan_at(int place);
  void find_choices();
  [[nodiscard]] std::optional<Choice> choice_of(int place, double least);
  [[nodiscard]] std::optional<Choice> choice_by_quadrics(int place);
  void add_quadrics_of_star();
  [[nodiscard]] bool collapse_best(float key, float limit);
  void look_again_beside(float key, float limit);

  // edge_refusals.cpp: why vertices stay.
  /// By end of an edge: the first one's is the star's.
  struct EdgeRefusal {
    Refusal first;
    Refusal second;
  };
  [[nodiscard]] std::optional<Refusal> refusal_of_link(std::uint32_t vertex);
  [[nodiscard]] EdgeRefusal refusal_of_edge(int place);
  [[nodiscard]] Refusal refusal_to_move(const Star& star, const Interfaces& interfaces) const;

  // edge_collapse.cpp: what a collapse does.
  [[nodiscard]] bool collapse(const Choice& choice);
  [[nodiscard]] bool look_at_one_edge(int place);
  void change(int place);
  [[nodiscard]] Cover cover_by(std::size_t lane, std::uint32_t sample) const;
  [[nodiscard]] std::optional<Cover> find_cover(const StarSamples& samples,
                                                std::size_t sample) const;
  [[nodiscard]] std::optional<Cover> find_holder(std::uint32_t sample);
  [[nodiscard]] double error_of(const Cover& cover, std::uint32_t sample, std::size_t field) const;
  [[nodiscard]] bool cover_samples();
  void move_samples();
  void note_facts();
  void note_facts(std::size_t field);
  void note_held_samples();
  void note_held(std::uint32_t sample);
  [[nodiscard]] double world_error_of(std::size_t field) const;
  void make_vertex(std::uint32_t other);

  State& state_;
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
  std::vector<std::uint8_t> has_changed_;  ///< By slot.
  std::vector<std::uint8_t>
      link_places_;  ///< By vertex: its place in the star's link, or kNoPlace.

  std::vector<std::uint32_t> ring_;        ///< find_ring()'s of one end,
  std::vector<std::uint32_t> other_ring_;  ///< and of the other.
  EdgePatch patch_;
  Star star_;  ///< Of the vertex whose edges are looked at,
  Interfaces interfaces_;
  std::vector<int> extrema_;  ///< By field: 1 of a maximum, -1 of a minimum, else 0.
  std::size_t n_own_samples_ = 0;
  double own_cost_ = 0;
  Star other_;  ///< of the other end,
  Interfaces other_interfaces_;
  std::vector<int> other_extrema_;
  int place_in_other_ = -1;                 ///< Of the first end.
  std::array<int, Star::kMaxLink> joined_;  ///< By place in the other's link: in the edge's.
  Star edge_;  ///< and what is round both: its link's first places are the star's, both ends' none.
  std::array<Vec3d, Star::kMaxLink> link_;  ///< Relative to the star's vertex, times scale_.
  double scale_ = 1;  ///< A power of two that makes the star about as large as 1.
  StarLanes lanes_;
  StarSamples covered_;
  StarSamples one_beside_;  ///< One that is not of them.
  Fan fan_;
  Rule rule_{};
  PositionCode code_{};
  Vec3d at_;                     ///< The new vertex, as link_,
  std::vector<NewValue> value_;  ///< and by field its values.
  std::vector<Choice> choices_;
  std::vector<Cover> covers_;       ///< Of a collapse, by sample.
  std::vector<double> new_errors_;  ///< Likewise, and by field.
  std::vector<EdgeCollapse> collapses_;
  std::vector<EdgeFacts> facts_;
  std::uint64_t n_gone_ = 0;
};

}  // namespace lode::tetra_mt::midpoint
