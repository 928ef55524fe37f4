#include "tests/tetra/collapse_checks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "tests/tetra/mesh_checks.h"

namespace lode::test {

using tetra_mt::Collapse;
using tetra_mt::HalfEdgeCollapses;

namespace {

std::pair<double, double> range_of(const MeshField& field, const std::set<std::uint32_t>& of) {
  std::pair range{std::numeric_limits<double>::infinity(),
                  -std::numeric_limits<double>::infinity()};
  for (const std::uint32_t v : of)
    range = {std::min(range.first, field.values[v]), std::max(range.second, field.values[v])};
  return range;
}

}  // namespace

std::set<std::uint32_t> vertices_of(const Tetrahedra& tetrahedra) {
  std::set<std::uint32_t> vertices;
  for (const auto& t : tetrahedra) vertices.insert(t.begin(), t.end());
  return vertices;
}

HalfEdgeCollapses collapsed(const TetraMesh& mesh, std::uint64_t base_cells,
                            const tetra_mt::CollapseRules& rules, Threads threads) {
  Progress progress;
  auto result = tetra_mt::collapse_half_edges(
      mesh, {.base_cells = base_cells, .rules = rules, .threads = threads}, progress);
  EXPECT_TRUE(result) << (result ? "" : result.error().message);
  return result ? std::move(*result) : HalfEdgeCollapses{};
}

std::vector<std::array<std::uint32_t, 2>> pairs(const HalfEdgeCollapses& result) {
  std::vector<std::array<std::uint32_t, 2>> all;
  for (const Collapse& c : result.collapses) all.push_back({c.removed, c.kept});
  return all;
}

void expect_simpler(const TetraMesh& mesh, const HalfEdgeCollapses& result) {
  const double volume = volume_of(mesh, mesh.tetrahedra);
  EXPECT_NEAR(expect_conforming(mesh, result.base), volume, 1e-5 * volume);
  EXPECT_EQ(normalised(result.base), normalised(replay(mesh.tetrahedra, pairs(result))));
  const std::set<std::uint32_t> left = vertices_of(result.base);
  EXPECT_EQ(left.size() + result.collapses.size(), vertices_of(mesh.tetrahedra).size());
  for (const MeshField& field : mesh.fields)
    EXPECT_EQ(range_of(field, left), range_of(field, vertices_of(mesh.tetrahedra)));
}

void expect_errors_true(const TetraMesh& mesh, const HalfEdgeCollapses& result) {
  for (std::size_t f = 0; f < mesh.fields.size(); ++f) {
    const std::vector<double>& values = mesh.fields[f].values;
    const auto [low, high] = std::ranges::minmax(values);
    for (const Collapse& c : result.collapses) {
      const Located found = locate(mesh, result.base, mesh.positions[c.removed], f);
      EXPECT_GT(found.least_weight, -1e-4);
      const double error = static_cast<double>(result.errors[c.removed * mesh.fields.size() + f]);
      EXPECT_NEAR(error * (high - low), values[c.removed] - found.value,
                  1e-4 * (high - low) + 1e-14 * std::abs(found.value));  // The search rounds, too.
    }
  }
}

}  // namespace lode::test
