#include "lode/io/mesh_medit.h"

#include <algorithm>
#include <array>
#include <limits>
#include <string>
#include <string_view>

#include "lode/io/mesh_checks.h"
#include "lode/io/mesh_medit_input.h"
#include "lode/io/mesh_medit_solution.h"

namespace lode::io {
namespace {

struct MeditKind {
  std::string_view keyword;
  CellType type = CellType::vertex;
  std::size_t n_corners = 0;
};

constexpr std::array<MeditKind, 8> kMeditKinds = {{{"edges", CellType::line, 2},
                                                   {"triangles", CellType::triangle, 3},
                                                   {"quadrilaterals", CellType::quad, 4},
                                                   {"tetrahedra", CellType::tetrahedron, 4},
                                                   {"prisms", CellType::wedge, 6},
                                                   {"pentahedra", CellType::wedge, 6},
                                                   {"pyramids", CellType::pyramid, 5},
                                                   {"hexahedra", CellType::hexahedron, 8}}};

constexpr auto kMostThings = static_cast<std::int64_t>(kMaxMeshCount);

Result<std::int64_t> medit_reference(MeditInput& input) {
  using Limits = std::numeric_limits<std::int32_t>;
  return input.whole("a reference", Limits::min(), Limits::max());
}

/// Whether a keyword is that of cells of an order above the first, as tetrahedrap2; of dimension 3
/// only, or of any.
bool is_of_higher_order(std::string_view keyword, bool is_solid) {
  constexpr std::array<std::string_view, 4> kSolid = {"tetrahedra", "hexahedra", "prisms",
                                                      "pyramids"};
  constexpr std::array<std::string_view, 3> kOther = {"edges", "triangles", "quadrilaterals"};
  const auto is_it = [&](std::string_view name) {
    return keyword.size() == name.size() + 2 && keyword.starts_with(name) &&
           (keyword[name.size()] == 'p' || keyword[name.size()] == 'q') && keyword.back() > '1' &&
           keyword.back() <= '9';
  };
  return std::ranges::any_of(kSolid, is_it) || (!is_solid && std::ranges::any_of(kOther, is_it));
}

/// Solid ones are refused, as their nodes have no order that all programs agree on; faces and edges
/// are listed as left out.
Result<void> pass_over_higher_order(const std::string& keyword, MeditInput& input, CellMesh& mesh) {
  LODE_TRY(const std::int64_t n, input.whole("a number of cells", 0, kMostThings));
  if (n == 0) return {};
  if (is_of_higher_order(keyword, true))
    return fail("{}: expected cells of the first order, got {} of {}", input.path(), n, keyword);
  mesh.skipped_arrays.push_back(fmt::format("{} {}", n, keyword));
  return {};
}

Result<void> read_vertices(MeditInput& input, CellMesh& mesh) {
  LODE_TRY(const std::int64_t n, input.whole("a number of vertices", 0, kMostThings));
  for (std::int64_t i = 0; i < n; ++i) {
    Vec3d point;
    for (double& x : point.v) {
      LODE_TRY(x, input.real("a coordinate"));
    }
    LODE_TRY([[maybe_unused]] const std::int64_t reference, medit_reference(input));
    mesh.points.push_back(point);
  }
  return {};
}

Result<void> read_medit_cells(MeditInput& input, const MeditKind& kind, CellMesh& mesh) {
  LODE_TRY(const std::int64_t n, input.whole("a number of cells", 0, kMostThings));
  for (std::int64_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < kind.n_corners; ++k) {
      LODE_TRY(const std::int64_t id, input.whole("a vertex", 1, kMostThings));
      mesh.corners.push_back(static_cast<std::uint32_t>(id - 1));
    }
    LODE_TRY(const std::int64_t reference, medit_reference(input));
    mesh.begins.push_back(mesh.corners.size());
    mesh.types.push_back(static_cast<std::uint8_t>(kind.type));
    mesh.cell_fields[0].values.push_back(static_cast<double>(reference));
  }
  return {};
}

}  // namespace

Result<CellMesh> read_medit_mesh(const std::string& path, const MeshReadOptions& options) {
  LODE_TRY(MeditInput input, MeditInput::open(path, options));
  CellMesh mesh;
  mesh.path = path;
  mesh.begins = {0};
  mesh.cell_fields = {{"RegionId", ScalarType::int32, 1, {}}};
  std::string before;
  while (true) {
    LODE_TRY(const std::string keyword, input.keyword(before));
    if (keyword.empty() || keyword == "end") break;
    before.clear();
    if (keyword == "dimension") LODE_CHECK(input.expect_three_dimensions("a mesh"));
    if (keyword == "vertices") {
      LODE_CHECK(read_vertices(input, mesh));
      before = keyword;
    }
    if (is_of_higher_order(keyword, false))
      LODE_CHECK(pass_over_higher_order(keyword, input, mesh));
    for (const MeditKind& kind : kMeditKinds)
      if (keyword == kind.keyword) {
        LODE_CHECK(read_medit_cells(input, kind, mesh));
        before = keyword;
      }
  }
  const std::string solution =
      options.solution.empty() ? medit_solution_of(path) : options.solution;
  if (!solution.empty()) LODE_CHECK(add_medit_solution(solution, options, mesh));
  return mesh;
}

}  // namespace lode::io
