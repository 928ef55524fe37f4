#include "lode/models/tetra_mt/midpoint/repeated_collapses.h"

#include <numeric>
#include <utility>

#include "lode/models/tetra_mt/mesh_check.h"
#include "lode/models/tetra_mt/midpoint/edge_collapser.h"

namespace lode::tetra_mt::midpoint {

Result<RepeatedCollapses> repeat_collapses(const TetraMesh& mesh,
                                           std::span<const EdgeCollapse> collapses,
                                           const RepeatRules& rules, Threads threads,
                                           Progress& progress) {
  constexpr std::size_t kReportEvery = 4096;
  LODE_CHECK(check_mesh(mesh));
  if (mesh.fields.empty()) return fail("midpoints: expected a field, got none");
  State state(mesh, CollapseOrder::squared_error, rules.boundary_tolerance);
  state.has_world_errors = rules.has_world_errors;
  LODE_CHECK(state.close(threads));
  // One block of all, numbered as the mesh is.
  std::vector<std::uint32_t> vertices(state.outside);
  std::iota(vertices.begin(), vertices.end(), 0U);
  std::vector<std::uint32_t> slots(state.tetrahedra.size());
  std::iota(slots.begin(), slots.end(), 0U);
  std::vector<std::uint32_t> places(state.outside + std::size_t{1});
  EdgeCollapser block(state, vertices, slots, places);
  for (std::size_t k = 0; k < collapses.size(); ++k) {
    if (k % kReportEvery == 0) {
      if (progress.is_cancelled()) return cancelled_error();
      progress.report("measuring fields",
                      static_cast<double>(k) / static_cast<double>(collapses.size()));
    }
    if (!block.repeat(collapses[k]))
      return fail(
          "collapse {} of {}: expected an edge that may go by what is known of its samples, got "
          "that of vertices {} and {}",
          k, collapses.size(), collapses[k].kept, collapses[k].removed);
  }
  RepeatedCollapses result;
  result.facts.assign(block.facts().begin(), block.facts().end());
  result.errors = std::move(state.errors);
  return result;
}

}  // namespace lode::tetra_mt::midpoint
