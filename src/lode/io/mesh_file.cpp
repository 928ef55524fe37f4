#include "lode/io/mesh_file.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <new>
#include <string_view>

#include "lode/core/out_of_memory.h"
#include "lode/io/mesh_blocks.h"
#include "lode/io/mesh_exodus_output.h"
#include "lode/io/mesh_gmsh_output.h"
#include "lode/io/mesh_vtk_legacy_output.h"
#include "lode/io/mesh_vtu.h"
#include "lode/io/text.h"

namespace lode::io {
namespace {

using MeshWriter = Result<void> (*)(const std::string&, const SimplexMesh&, const MeshWriteOptions&,
                                    Progress&);

struct MeshFormat {
  std::string_view extension;
  MeshWriter write = nullptr;
};

constexpr std::array<MeshFormat, 6> kMeshFormats{{{".vtu", write_vtu},
                                                  {".vtk", write_vtk_legacy_mesh},
                                                  {".msh", write_gmsh_mesh},
                                                  {".e", write_exodus_mesh},
                                                  {".exo", write_exodus_mesh},
                                                  {".ex2", write_exodus_mesh}}};

Result<const MeshFormat*> mesh_format_of(const std::string& path) {
  const std::string extension = to_lower(std::filesystem::path(path).extension().string());
  const auto* const found =
      std::find_if(kMeshFormats.begin(), kMeshFormats.end(),
                   [&](const MeshFormat& format) { return format.extension == extension; });
  if (found != kMeshFormats.end()) return found;
  return fail("{}: expected a mesh file that ends in .vtu, .vtk, .msh, .e, .exo or .ex2", path);
}

}  // namespace

Result<void> check_mesh_path(const std::string& path) {
  LODE_TRY([[maybe_unused]] const MeshFormat* const format, mesh_format_of(path));
  return {};
}

Result<void> write_mesh(const std::string& path, const SimplexMesh& mesh,
                        const MeshWriteOptions& options, Progress& progress) try {
  LODE_EXPECTS(mesh.triangles.empty() || mesh.tetrahedra.empty());
  LODE_EXPECTS(mesh.values.size() == mesh.positions.size());
  LODE_EXPECTS(mesh.errors.size() == mesh.n_cells());
  LODE_EXPECTS(mesh.regions.empty() || mesh.regions.size() == mesh.n_cells());
  LODE_EXPECTS(has_whole_attributes(mesh));
  LODE_TRY(const MeshFormat* const format, mesh_format_of(path));
  return format->write(path, mesh, options, progress);
} catch (const std::bad_alloc&) {
  return out_of_memory("write the mesh", path);
}

}  // namespace lode::io
