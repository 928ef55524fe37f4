#include "lode/io/mesh_medit.h"

#include <array>
#include <limits>
#include <string_view>

#include "lode/io/mesh_checks.h"
#include "lode/io/mesh_text.h"
#include "lode/io/text.h"

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

Result<std::int64_t> medit_whole(MeshText& text, std::string_view what, std::int64_t low,
                                 std::int64_t high) {
  const std::string_view word = text.word();
  const auto number = to_int64(word);
  if (number && *number >= low && *number <= high) return *number;
  return fail("{}: expected {} from {} to {} before byte {}, got {}", text.path(), what, low, high,
              text.position(), in_quotes(word));
}

Result<std::int64_t> medit_reference(MeshText& text) {
  using Limits = std::numeric_limits<std::int32_t>;
  return medit_whole(text, "a reference", Limits::min(), Limits::max());
}

Result<void> read_vertices(MeshText& text, CellMesh& mesh) {
  LODE_TRY(const std::int64_t n,
           medit_whole(text, "a number of vertices", 0, static_cast<std::int64_t>(kMaxMeshCount)));
  for (std::int64_t i = 0; i < n; ++i) {
    Vec3d point;
    for (double& x : point.v) {
      const std::string_view word = text.word();
      const auto number = to_double(word);
      if (!number)
        return fail("{}: expected a coordinate before byte {}, got {}", text.path(),
                    text.position(), in_quotes(word));
      x = *number;
    }
    LODE_TRY([[maybe_unused]] const std::int64_t reference, medit_reference(text));
    mesh.points.push_back(point);
  }
  return {};
}

Result<void> read_medit_cells(MeshText& text, const MeditKind& kind, CellMesh& mesh) {
  constexpr auto kMaxCorner = static_cast<std::int64_t>(kMaxMeshCount);
  LODE_TRY(const std::int64_t n, medit_whole(text, "a number of cells", 0, kMaxCorner));
  for (std::int64_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < kind.n_corners; ++k) {
      LODE_TRY(const std::int64_t id, medit_whole(text, "a vertex", 1, kMaxCorner));
      mesh.corners.push_back(static_cast<std::uint32_t>(id - 1));
    }
    LODE_TRY(const std::int64_t reference, medit_reference(text));
    mesh.begins.push_back(mesh.corners.size());
    mesh.types.push_back(static_cast<std::uint8_t>(kind.type));
    mesh.cell_fields[0].values.push_back(static_cast<double>(reference));
  }
  return {};
}

Result<void> read_medit_dimension(MeshText& text) {
  LODE_TRY(const std::int64_t n, medit_whole(text, "a dimension", 0, 99));
  if (n == 3) return {};
  return fail("{}: expected a mesh of 3 dimensions, got {}", text.path(), n);
}

}  // namespace

Result<CellMesh> read_medit_mesh(const std::string& path, const MeshReadOptions& options) {
  LODE_TRY(MeshText text, MeshText::open(path, options));
  text.blank_comments('#');
  CellMesh mesh;
  mesh.path = path;
  mesh.begins = {0};
  mesh.cell_fields = {{"RegionId", ScalarType::int32, 1, {}}};
  while (true) {
    const std::string keyword = to_lower(text.word());
    if (keyword.empty() || keyword == "end") return mesh;
    if (keyword == "dimension") LODE_CHECK(read_medit_dimension(text));
    if (keyword == "vertices") LODE_CHECK(read_vertices(text, mesh));
    for (const MeditKind& kind : kMeditKinds)
      if (keyword == kind.keyword) LODE_CHECK(read_medit_cells(text, kind, mesh));
  }
}

}  // namespace lode::io
