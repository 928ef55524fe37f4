#include "lode/io/mesh_reader.h"

#include <algorithm>
#include <array>
#include <exception>
#include <filesystem>
#include <new>
#include <span>
#include <string_view>

#include "lode/core/out_of_memory.h"
#include "lode/io/input_file.h"
#include "lode/io/mesh_checks.h"
#include "lode/io/mesh_gmsh.h"
#include "lode/io/mesh_medit.h"
#include "lode/io/mesh_vtk_legacy.h"
#include "lode/io/mesh_vtk_xml.h"
#include "lode/io/text.h"

namespace lode::io {
namespace {

enum class MeshForm { vtk_xml, vtk_legacy, gmsh, medit };

constexpr std::array<std::string_view, 6> kMeshExtensions = {".vtu", ".vts",  ".vtk",
                                                             ".msh", ".mesh", ".meshb"};

/// What a file begins as.
Result<MeshForm> mesh_form_of(const std::string& path) {
  constexpr std::uint64_t kMaxStart = 1024;
  LODE_TRY(const InputFilePtr file, InputFile::open(path));
  const std::string lower = to_lower(path);
  const bool is_known = std::any_of(kMeshExtensions.begin(), kMeshExtensions.end(),
                                    [&](std::string_view end) { return lower.ends_with(end); });
  if (!is_known)
    return fail(
        "{}: expected a mesh of a known format (.vtu .vts .vtk .msh .mesh .meshb), got extension "
        "{}",
        path, in_quotes(std::filesystem::path(path).extension().string()));
  std::string start(static_cast<std::size_t>(std::min(kMaxStart, file->size())), '\0');
  LODE_CHECK(file->read(0, std::as_writable_bytes(std::span(start.data(), start.size()))));
  if (start.starts_with("# vtk DataFile")) return MeshForm::vtk_legacy;
  if (start.find("<VTKFile") != std::string::npos) return MeshForm::vtk_xml;
  if (start.find("$MeshFormat") != std::string::npos) return MeshForm::gmsh;
  if (start.find("MeshVersionFormatted") != std::string::npos || lower.ends_with(".meshb"))
    return MeshForm::medit;
  return fail("{}: expected VTK XML, legacy VTK, Gmsh or MEDIT text, got {}", path,
              in_quotes(std::string_view(start).substr(0, 20)));
}

Result<CellMesh> read_form(MeshForm form, const std::string& path, const MeshReadOptions& options) {
  switch (form) {
    case MeshForm::vtk_legacy: return read_vtk_legacy_mesh(path, options);
    case MeshForm::gmsh: return read_gmsh_mesh(path, options);
    case MeshForm::medit: return read_medit_mesh(path, options);
    default: return read_vtk_xml_mesh(path, options);
  }
}

Result<CellMesh> read_and_check(const std::string& path, const MeshReadOptions& options) {
  LODE_TRY(const MeshForm form, mesh_form_of(path));
  if (form != MeshForm::medit && !options.solution.empty())
    return fail("{}: expected a MEDIT mesh with the solution {}, got another", path,
                options.solution);
  LODE_TRY(CellMesh mesh, read_form(form, path, options));
  LODE_CHECK(check_cell_mesh(mesh));
  return mesh;
}

}  // namespace

Result<CellMesh> read_cell_mesh(const std::string& path, const MeshReadOptions& options) {
  try {
    return read_and_check(path, options);
  } catch (const std::bad_alloc&) {
    return out_of_memory("read the file", path);
  } catch (const std::exception& exception) {
    return fail("{}: cannot be read: {}", path, exception.what());
  }
}

}  // namespace lode::io
