#include "lode/io/mesh_gmsh_output.h"

#include <algorithm>
#include <limits>
#include <optional>

#include "lode/core/box.h"
#include "lode/io/mesh_blocks.h"
#include "lode/io/mesh_patches.h"
#include "lode/io/surface_output.h"
#include "lode/io/vector_arrays.h"
#include "lode/io/vtk_xml_output.h"

namespace lode::io {
namespace {

/// A mesh on its way into a .msh file.
struct GmshOutput {
  SurfaceOutput file;
  const SimplexMesh& mesh;
  const MeshBlocks& blocks;
  const PatchBlocks& patches;
  double time = 0;

  [[nodiscard]] bool is_solid() const { return n_simplex_corners(mesh) == 4; }
  [[nodiscard]] std::int32_t dimension() const { return is_solid() ? 3 : 2; }
  [[nodiscard]] Result<void> text(std::string_view text) { return file.write(text); }
  template <typename T>
  [[nodiscard]] Result<void> number(T value) {
    return file.write(std::as_bytes(std::span(&value, 1)));
  }
};

Result<void> write_gmsh_head(const MeshWriteOptions& options, GmshOutput& out) {
  LODE_CHECK(out.text("$MeshFormat\n4.1 1 8\n"));
  LODE_CHECK(out.number(std::int32_t{1}));
  LODE_CHECK(out.text("\n$EndMeshFormat\n"));
  std::string comment = to_one_line(options.comment);
  std::replace(comment.begin(), comment.end(), '$', '_');
  LODE_CHECK(out.text(
      fmt::format("$Comments\n{}; frame {}\n$EndComments\n", comment, name_of(options.frame))));
  const std::span<const MeshBlock> regions =
      out.mesh.regions.empty() ? std::span<const MeshBlock>() : out.blocks.blocks();
  const std::size_t n_names = out.patches.blocks().size() + regions.size();
  if (n_names == 0) return {};
  LODE_CHECK(out.text(fmt::format("$PhysicalNames\n{}\n", n_names)));
  const auto write_name = [&](std::int32_t dimension, std::int32_t tag, std::string name) {
    std::replace(name.begin(), name.end(), '"', '_');
    std::replace(name.begin(), name.end(), '$', '_');
    return out.text(fmt::format("{} {} \"{}\"\n", dimension, tag, name));
  };
  for (const PatchBlock& patch : out.patches.blocks())
    LODE_CHECK(write_name(2, patch.tag, patch.name));
  for (const MeshBlock& block : regions)
    LODE_CHECK(write_name(out.dimension(), block.tag, block.name));
  return out.text("$EndPhysicalNames\n");
}

/// Round what `corners_of(item)` gives of the items of a block, which has some.
template <typename CornersOf>
Box3d bounds_of(const SimplexMesh& mesh, std::span<const std::uint32_t> items,
                const CornersOf& corners_of) {
  const Vec3d& first = mesh.positions[corners_of(items.front())[0]];
  Box3d box{first, first};
  for (const std::uint32_t item : items)
    for (const std::uint32_t v : corners_of(item))
      for (std::size_t axis = 0; axis < 3; ++axis) {
        box.lower[axis] = std::min(box.lower[axis], mesh.positions[v][axis]);
        box.upper[axis] = std::max(box.upper[axis], mesh.positions[v][axis]);
      }
  return box;
}

/// Of no known boundary.
Result<void> write_gmsh_entity(std::int32_t entity, const Box3d& box,
                               std::optional<std::int32_t> group, GmshOutput& out) {
  LODE_CHECK(out.number(entity));
  LODE_CHECK(out.number(box.lower));
  LODE_CHECK(out.number(box.upper));
  LODE_CHECK(out.number(std::uint64_t{group ? 1U : 0U}));
  if (group) LODE_CHECK(out.number(*group));
  return out.number(std::uint64_t{0});
}

/// One for each block and patch; of either dimension numbered from 1.
Result<void> write_gmsh_entities(GmshOutput& out) {
  LODE_CHECK(out.text("$Entities\n"));
  const std::uint64_t n = out.blocks.blocks().size();
  const std::uint64_t n_patches = out.patches.blocks().size();
  for (const std::uint64_t count :
       {std::uint64_t{0}, std::uint64_t{0}, out.is_solid() ? n_patches : n, out.is_solid() ? n : 0})
    LODE_CHECK(out.number(count));
  std::int32_t entity = 0;
  for (const PatchBlock& patch : out.patches.blocks()) {
    const auto corners_of = [&](std::uint32_t side) {
      return out.mesh.corners_of(out.mesh.patch_sides[side]);
    };
    LODE_CHECK(
        write_gmsh_entity(++entity, bounds_of(out.mesh, patch.sides, corners_of), patch.tag, out));
  }
  entity = 0;
  for (const MeshBlock& block : out.blocks.blocks()) {
    const auto corners_of = [&](std::uint32_t cell) { return simplex_corners(out.mesh, cell); };
    std::optional<std::int32_t> group;
    if (!out.mesh.regions.empty()) group = block.tag;
    LODE_CHECK(
        write_gmsh_entity(++entity, bounds_of(out.mesh, block.cells, corners_of), group, out));
  }
  return out.text("\n$EndEntities\n");
}

/// How many blocks, how many in all, and the first and last tag.
Result<void> write_gmsh_counts(std::uint64_t n_blocks, std::uint64_t n, GmshOutput& out) {
  for (const std::uint64_t count : {n_blocks, n, std::uint64_t{n > 0 ? 1U : 0U}, n})
    LODE_CHECK(out.number(count));
  return {};
}

/// All of them belong to the first entity: vertices between regions are nobody's own.
Result<void> write_gmsh_nodes(GmshOutput& out) {
  const std::uint64_t n = out.mesh.positions.size();
  LODE_CHECK(out.text("$Nodes\n"));
  LODE_CHECK(write_gmsh_counts(n > 0 ? 1 : 0, n, out));
  if (n > 0) {
    for (const std::int32_t number : {out.dimension(), 1, 0}) LODE_CHECK(out.number(number));
    LODE_CHECK(out.number(n));
    LODE_CHECK(write_records(out.file, n, sizeof(std::uint64_t),
                             [](std::size_t i, std::byte* to) { put(to, std::uint64_t{i + 1}); }));
    LODE_CHECK(write_array(out.file, std::span(out.mesh.positions)));
  }
  return out.text("\n$EndNodes\n");
}

constexpr std::int32_t kTriangle = 2;
constexpr std::int32_t kTetrahedron = 4;

/// Behind all cells, whose tags are by place.
Result<void> write_gmsh_patches(GmshOutput& out) {
  std::int32_t entity = 0;
  std::uint64_t n_before = out.mesh.n_cells();
  for (const PatchBlock& patch : out.patches.blocks()) {
    for (const std::int32_t number : {2, ++entity, kTriangle}) LODE_CHECK(out.number(number));
    LODE_CHECK(out.number(std::uint64_t{patch.sides.size()}));
    LODE_CHECK(write_records(
        out.file, patch.sides.size(), 4 * sizeof(std::uint64_t), [&](std::size_t i, std::byte* to) {
          put(to, n_before + i + 1);
          for (const std::uint32_t v : out.mesh.corners_of(out.mesh.patch_sides[patch.sides[i]]))
            put(to, std::uint64_t{v} + 1);
        }));
    n_before += patch.sides.size();
  }
  return {};
}

Result<void> write_gmsh_elements(GmshOutput& out) {
  const std::size_t n_corners = n_simplex_corners(out.mesh);
  LODE_CHECK(out.text("$Elements\n"));
  LODE_CHECK(write_gmsh_counts(out.blocks.blocks().size() + out.patches.blocks().size(),
                               out.mesh.n_cells() + out.patches.n_faces(), out));
  std::int32_t entity = 0;
  std::uint64_t n_before = 0;
  for (const MeshBlock& block : out.blocks.blocks()) {
    for (const std::int32_t number :
         {out.dimension(), ++entity, out.is_solid() ? kTetrahedron : kTriangle})
      LODE_CHECK(out.number(number));
    LODE_CHECK(out.number(std::uint64_t{block.cells.size()}));
    LODE_CHECK(write_records(out.file, block.cells.size(), (n_corners + 1) * sizeof(std::uint64_t),
                             [&](std::size_t i, std::byte* to) {
                               put(to, n_before + i + 1);
                               for (const std::uint32_t v :
                                    simplex_corners(out.mesh, block.cells[i]))
                                 put(to, std::uint64_t{v} + 1);
                             }));
    n_before += block.cells.size();
  }
  LODE_CHECK(write_gmsh_patches(out));
  return out.text("\n$EndElements\n");
}

/// $NodeData or $ElementData: `value_of(i)` of what has the tag i + 1.
template <typename ValueOf>
Result<void> write_gmsh_data(std::string_view section, std::string_view name, std::size_t n,
                             const ValueOf& value_of, GmshOutput& out) {
  LODE_CHECK(
      out.text(fmt::format("${}\n1\n\"{}\"\n1\n{}\n3\n0\n1\n{}\n", section, name, out.time, n)));
  LODE_CHECK(write_records(out.file, n, sizeof(std::int32_t) + sizeof(double),
                           [&](std::size_t i, std::byte* to) {
                             put(to, static_cast<std::int32_t>(i + 1));
                             put(to, static_cast<double>(value_of(i)));
                           }));
  return out.text(fmt::format("\n$End{}\n", section));
}

/// $NodeData of three components.
Result<void> write_gmsh_vectors(std::string_view name,
                                std::span<const std::span<const double>> fields, GmshOutput& out) {
  const std::size_t n = fields[0].size();
  LODE_CHECK(
      out.text(fmt::format("$NodeData\n1\n\"{}\"\n1\n{}\n3\n0\n3\n{}\n", name, out.time, n)));
  LODE_CHECK(write_records(out.file, n, sizeof(std::int32_t) + fields.size() * sizeof(double),
                           [&](std::size_t i, std::byte* to) {
                             put(to, static_cast<std::int32_t>(i + 1));
                             for (const std::span<const double> field : fields)
                               put(to, double{field[i]});
                           }));
  return out.text("\n$EndNodeData\n");
}

Result<void> write_gmsh_fields(const MeshWriteOptions& options, GmshOutput& out) {
  const SimplexMesh& mesh = out.mesh;
  LODE_CHECK(write_gmsh_data(
      "NodeData", vtk_array_name(options.value_name), mesh.values.size(),
      [&](std::size_t i) { return mesh.values[i]; }, out));
  for (const ArrayOfFields& array : arrays_of_fields(options.value_name, mesh.attributes)) {
    const auto fields = fields_of(array, mesh.values, mesh.attributes);
    if (fields.size() == 1)
      LODE_CHECK(write_gmsh_data(
          "NodeData", vtk_array_name(array.name), fields[0].size(),
          [&](std::size_t i) { return fields[0][i]; }, out));
    else
      LODE_CHECK(write_gmsh_vectors(vtk_array_name(array.name), fields, out));
  }
  const std::span<const std::uint32_t> cells = out.blocks.cells();
  const auto write_errors = [&](std::string_view name, const std::vector<float>& errors) {
    return write_gmsh_data(
        "ElementData", name, cells.size(), [&](std::size_t i) { return errors[cells[i]]; }, out);
  };
  LODE_CHECK(write_errors("error", mesh.errors));
  for (const Attribute& attribute : mesh.attributes)
    if (!attribute.errors.empty())
      LODE_CHECK(write_errors(vtk_array_name(error_name(attribute)), attribute.errors));
  if (mesh.regions.empty() || out.blocks.has_region_tags()) return {};
  return write_gmsh_data(
      "ElementData", "RegionId", cells.size(),
      [&](std::size_t i) { return mesh.regions[cells[i]]; }, out);
}

}  // namespace

Result<void> write_gmsh_mesh(const std::string& path, const SimplexMesh& mesh,
                             const MeshWriteOptions& options, Progress& progress) {
  constexpr std::size_t kMax = std::numeric_limits<std::int32_t>::max();
  if (mesh.positions.size() > kMax || mesh.n_cells() + mesh.patch_sides.size() > kMax)
    return fail("{}: expected a mesh that Gmsh can number in 32 bits, got {} cells; .vtu can", path,
                mesh.n_cells());
  const MeshBlocks blocks(mesh);
  const PatchBlocks patches(mesh);
  const std::size_t n_bytes =
      mesh.positions.size() *
          (sizeof(Vec3d) + sizeof(std::uint64_t) + (mesh.attributes.size() + 1) * sizeof(double)) +
      mesh.n_cells() * (n_simplex_corners(mesh) + 2 + mesh.attributes.size()) *
          sizeof(std::uint64_t);
  LODE_TRY(SurfaceOutput file, SurfaceOutput::create(path, n_bytes, progress, options.threads));
  GmshOutput out{std::move(file), mesh, blocks, patches, options.time.value_or(0)};
  LODE_CHECK(write_gmsh_head(options, out));
  LODE_CHECK(write_gmsh_entities(out));
  LODE_CHECK(write_gmsh_nodes(out));
  LODE_CHECK(write_gmsh_elements(out));
  LODE_CHECK(write_gmsh_fields(options, out));
  return out.file.commit();
}

}  // namespace lode::io
