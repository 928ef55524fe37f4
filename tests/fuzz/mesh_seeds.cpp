// Seeds of foreign meshes and points.
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "tests/fuzz/seeds.h"
#include "tests/io/cell_mesh_files.h"

namespace lode::fuzz {
namespace {

using io::test::bytes_of;

/// Two tetrahedra of two groups with a face of a third, and a field, in two steps, at their nodes.
constexpr const char* kGmsh2 =
    "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n2 4 \"its door\"\n3 9 \"a room\"\n"
    "$EndPhysicalNames\n$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 0 0 -1\n$EndNodes\n"
    "$Elements\n3\n1 4 2 9 1 1 2 3 4\n2 4 2 8 2 1 3 2 5\n3 2 2 4 1 1 2 4\n$EndElements\n"
    "$NodeData\n1\n\"heat\"\n1\n0.5\n3\n0\n1\n2\n1 2.5\n4 -1\n$EndNodeData\n"
    "$NodeData\n1\n\"heat\"\n1\n0.75\n3\n1\n1\n1\n2 7\n$EndNodeData\n"
    "$ElementData\n1\n\"RegionId\"\n1\n0\n3\n0\n1\n2\n1 5\n2 -6\n$EndElementData\n";
constexpr const char* kGmsh4 =
    "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 1 1\n1 0 0 0 1 1 1 1 4 0\n"
    "1 0 0 0 1 1 1 1 9 1 -1\n$EndEntities\n$Nodes\n2 4 1 4\n2 1 1 1\n1\n0 0 0 .5 .5\n3 1 0 3\n2\n"
    "3\n4\n1 0 0\n0 1 0\n0 0 1\n$EndNodes\n$Elements\n2 2 1 2\n2 1 2 1\n1 1 2 3\n3 1 4 1\n2 1 2 3 "
    "4\n"
    "$EndElements\n";
constexpr const char* kMedit =
    "MeshVersionFormatted 2\nDimension 3\nVertices\n5\n0 0 0 1\n1 0 0 1\n0 1 0 2\n0 0 1 2\n"
    "0 0 -3 0\nTriangles\n1\n1 2 4 3\nTetrahedra # two\n2\n1 2 3 4 7\n1 3 2 5 -1\nEnd\n";
constexpr const char* kMeditSolution =
    "MeshVersionFormatted 2\nDimension 3\nSolAtTetrahedra\n2\n1 1\n1\n1\nSolAtVertices\n5\n"
    "3 1 2 3\n1 1 2 3 1 2 3 4 5 6\n2 1 2 3 1 2 3 4 5 6\n3 1 2 3 1 2 3 4 5 6\n"
    "4 1 2 3 1 2 3 4 5 6\n5 1 2 3 1 2 3 4 5 6\nEnd\n";

/// Of version 2, from its sections: a keyword's code, and all that is behind.
std::string medit_bytes(const std::vector<std::pair<std::int32_t, std::string>>& sections) {
  std::string bytes = bytes_of<std::int32_t>({1, 2});
  for (const auto& [code, data] : sections) {
    const auto next = static_cast<std::int32_t>(bytes.size() + 8 + data.size());
    bytes += bytes_of<std::int32_t>({code, next}) + data;
  }
  return bytes + bytes_of<std::int32_t>({54, 0});
}

std::string medit_binary_mesh() {
  std::string vertices = bytes_of<std::int32_t>({4});
  for (const std::vector<double>& p :
       {std::vector<double>{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}})
    vertices += bytes_of(p) + bytes_of<std::int32_t>({1});
  return medit_bytes({{3, bytes_of<std::int32_t>({3})},
                      {4, vertices},
                      {6, bytes_of<std::int32_t>({1, 1, 2, 3, 5})},
                      {8, bytes_of<std::int32_t>({1, 1, 2, 3, 4, 7})}});
}

}  // namespace

void keep_meshes() {
  const CellMesh mesh = io::test::varied_mesh();
  for (const io::test::XmlForm& form : io::test::xml_forms())
    keep("cell_mesh", "vtu_" + form.name, io::test::vtu_of({mesh, mesh}, form));
  keep("cell_mesh", "vtk_counts", io::test::legacy_of(mesh, io::test::LegacyForm::binary_counts));
  keep("cell_mesh", "vtk_offsets", io::test::legacy_of(mesh, io::test::LegacyForm::ascii_offsets));
  keep("cell_mesh", "gmsh_2", kGmsh2);
  keep("cell_mesh", "gmsh_4", kGmsh4);
  keep("cell_mesh", "medit", kMedit);
  keep("cell_mesh", "medit_binary", medit_binary_mesh());
  keep("medit_solution", "text", joined(kMedit, kMeditSolution));
  const std::string values = bytes_of<std::int32_t>({4, 1, 1}) + bytes_of<double>({1, 2, 3, 4});
  keep("medit_solution", "binary",
       joined(medit_binary_mesh(), medit_bytes({{3, bytes_of<std::int32_t>({3})}, {62, values}})));
}

void keep_points() {
  keep("points", "bare", "0 0 1\n10.5 0 2\n0 1e1 3\n# no more\n");
  keep("points", "heading", "id,lat,lon,height\n1,47.1,8.5,400\n2,47.2,8.5,410\n3,47.1,8.75,nan\n");
  std::string las(227, '\0');
  const auto put = [&](std::size_t at, const std::string& bytes) {
    las.replace(at, bytes.size(), bytes);
  };
  put(0, "LASF");
  put(24, bytes_of<std::uint8_t>({1, 2}));
  put(94, bytes_of<std::uint16_t>({227}));
  put(96, bytes_of<std::uint32_t>({227, 0}));
  put(104, bytes_of<std::uint8_t>({0}));
  put(105, bytes_of<std::uint16_t>({20}));
  put(107, bytes_of<std::uint32_t>({3}));
  put(131, bytes_of<double>({0.01, 0.01, 0.01, 5e5, 4e6, 0}));
  for (const std::int32_t i : {0, 1, 2})
    las += bytes_of<std::int32_t>({100 * i, 70 * i * i, 9 * i}) + std::string(8, '\x02');
  keep("points", "las", las);
}

}  // namespace lode::fuzz
