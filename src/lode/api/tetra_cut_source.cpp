#include "lode/api/tetra_cut_source.h"

#include <limits>
#include <utility>

#include "lode/api/tetra_info.h"
#include "lode/models/tetra_mt/midpoint/structure_check.h"
#include "lode/models/tetra_mt/random_cut.h"
#include "lode/refine/engine.h"
#include "lode/refine/focus.h"

namespace lode {
namespace {

using tetra_mt::kNone;
using tetra_mt::PackedHierarchy;
using tetra_mt::StructureFindings;
using tetra_mt::TetraCut;
using tetra_mt::midpoint::Forest;
using tetra_mt::midpoint::MidpointCut;

tetra_mt::WorldErrors known_of(const TetraFieldInfo& field) {
  return field.base_world_error ? tetra_mt::WorldErrors::known : tetra_mt::WorldErrors::unknown;
}

/// To a code of the box: by an eighth at most, or to the first one.
bool is_rounded_up(double error, double code, const Box3d& bounds) {
  const tetra_mt::WorldCodes codes(bounds.lower, bounds.upper);
  return code >= error && (code <= 1.126 * error || code <= static_cast<double>(codes.error(1)));
}

template <typename Cut>
Result<RefinedCells> refine(Cut cut, const TetraFieldInfo& field, const Box3d& bounds,
                            const std::optional<double>& tolerance, Progress& progress) {
  Engine<Cut> engine(cut);
  if (tolerance)
    engine.set_query(uniform_demand(*tolerance), {}, FocusChange::changed,
                     ApplyOrder::nearest_first);
  engine.run([&] { return progress.is_cancelled() || cut.is_damaged(); });
  if (progress.is_cancelled()) return cancelled_error();
  LODE_CHECK(cut.check());
  const double achieved = tolerance
                              ? engine.largest([](const NodeFacts& facts) { return facts.error; })
                              : field.base_error;
  RefinedCells made{TetraCells(cut), achieved};
  if (!field.base_world_error) return made;
  if (!tolerance) {
    engine.set_query(uniform_demand(std::numeric_limits<double>::infinity()));
    engine.finish();
  }
  made.achieved_world = engine.largest([](const NodeFacts& facts) { return facts.world_error; });
  LODE_CHECK(cut.check());
  if (!tolerance) {
    made.has_stated_world = is_rounded_up(*field.base_world_error, made.achieved_world, bounds);
    made.achieved_world = *field.base_world_error;
  }
  return made;
}

template <typename Cut>
Result<TetraCells> cells_at_random(Cut cut, std::uint32_t n_nodes, std::uint32_t n_wanted,
                                   std::uint64_t seed) {
  tetra_mt::apply_at_random(n_nodes, n_wanted, seed, cut);
  LODE_CHECK(cut.check());
  return TetraCells(cut);
}

/// `facts(maker)`: what is stored of a node; `reference`: what its range is above.
template <typename FactsOf>
void state_cells(const FactsOf& facts_of, double reference, TetraCells& cells) {
  cells.stated.assign(cells.makers.size(), {});
  for (std::size_t i = 0; i < cells.makers.size(); ++i) {
    if (cells.makers[i] == kNone) continue;
    const NodeFacts facts = without_bounds(facts_of(cells.makers[i]), reference);
    cells.stated[i] = {facts.error, facts.range};
  }
}

class HalfEdgeSource final : public TetraCutSource {
 public:
  explicit HalfEdgeSource(const PackedHierarchy& hierarchy) : hierarchy_(hierarchy) {
    info_ = info_of(hierarchy.head());
  }

  Result<StructureFindings> check_structure(std::uint64_t seed, Progress& progress) const override {
    return tetra_mt::check_structure(hierarchy_, seed, progress);
  }
  Result<TetraVertices> vertices() const override { return TetraVertices(hierarchy_); }
  Result<void> take_values(std::size_t field, TetraVertices& vertices) const override {
    vertices.take_values(hierarchy_, field);
    return hierarchy_.check();
  }
  void spread(std::vector<bool>& /*is*/) const override {}
  Result<RefinedCells> refined(std::size_t field, std::optional<double> tolerance,
                               Progress& progress) const override {
    const TetraFieldInfo& info = info_.fields[field];
    return refine(TetraCut(hierarchy_, field, known_of(info)), info, info_.bounds, tolerance,
                  progress);
  }
  Result<TetraCells> random(std::uint32_t n_nodes, std::uint64_t seed) const override {
    return cells_at_random(TetraCut(hierarchy_), hierarchy_.head().shape.n_nodes, n_nodes, seed);
  }
  Result<void> state(std::size_t field, TetraCells& cells) const override {
    state_cells([&](std::uint32_t maker) { return hierarchy_.facts(maker, field); },
                hierarchy_.head().fields[field].low, cells);
    return hierarchy_.check();
  }

 private:
  const PackedHierarchy& hierarchy_;
};

class MidpointSource final : public TetraCutSource {
 public:
  explicit MidpointSource(const Forest& forest) : forest_(forest) {
    info_ = info_of(forest.head());
  }

  Result<StructureFindings> check_structure(std::uint64_t seed, Progress& progress) const override {
    return tetra_mt::midpoint::check_structure(forest_, seed, progress);
  }
  Result<TetraVertices> vertices() const override {
    TetraVertices vertices(forest_);
    LODE_CHECK(forest_.check());
    return vertices;
  }
  Result<void> take_values(std::size_t field, TetraVertices& vertices) const override {
    vertices.take_values(forest_, field);
    return forest_.check();
  }
  /// Children have smaller labels.
  void spread(std::vector<bool>& is) const override {
    const std::uint32_t n_vertices = forest_.head().n_vertices;
    for (std::uint32_t node = 0; node < forest_.head().n_nodes(); ++node) {
      const auto [first, second] = forest_.children(node);
      is[n_vertices + node] = is[first] || is[second];
    }
  }
  Result<RefinedCells> refined(std::size_t field, std::optional<double> tolerance,
                               Progress& progress) const override {
    const TetraFieldInfo& info = info_.fields[field];
    return refine(MidpointCut(forest_, field, known_of(info)), info, info_.bounds, tolerance,
                  progress);
  }
  Result<TetraCells> random(std::uint32_t n_nodes, std::uint64_t seed) const override {
    return cells_at_random(MidpointCut(forest_), forest_.head().n_nodes(), n_nodes, seed);
  }
  Result<void> state(std::size_t field, TetraCells& cells) const override {
    const auto& codes = forest_.head().fields[field].codes;
    state_cells(
        [&](std::uint32_t maker) {
          return codes.facts(tetra_mt::midpoint::NodeCodes::parts(forest_.facts(maker, field)));
        },
        codes.knots()[0], cells);
    return forest_.check();
  }

 private:
  const Forest& forest_;
};

}  // namespace

std::unique_ptr<const TetraCutSource> source_of(const PackedHierarchy& hierarchy) {
  return std::make_unique<const HalfEdgeSource>(hierarchy);
}

std::unique_ptr<const TetraCutSource> source_of(const Forest& forest) {
  return std::make_unique<const MidpointSource>(forest);
}

}  // namespace lode
