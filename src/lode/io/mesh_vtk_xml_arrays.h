#pragma once

#include <optional>
#include <pugixml.hpp>
#include <string>
#include <vector>

#include "lode/core/cell_mesh.h"
#include "lode/core/result.h"
#include "lode/io/mesh_numbers.h"
#include "lode/io/vtk_xml_array.h"

namespace lode::io {

/// A VTK XML file whose mesh is being read.
struct VtkXmlMeshFile {
  VtkXmlFilePtr xml;
  MeshBudget budget;
  std::vector<std::string> skipped_arrays;  ///< CellMesh::skipped_arrays.

  [[nodiscard]] const std::string& path() const { return xml->file->path(); }
};

[[nodiscard]] pugi::xml_node find_array(const pugi::xml_node& parent, const char* name);

/// A DataArray of exactly `n` numbers.
[[nodiscard]] Result<MeshNumbers> load_xml_numbers(VtkXmlMeshFile& file,
                                                   const pugi::xml_node& array, std::uint64_t n);

/// The array in a piece's Points.
[[nodiscard]] Result<std::vector<Vec3d>> load_xml_points(VtkXmlMeshFile& file,
                                                         const pugi::xml_node& piece,
                                                         std::uint64_t n);

/// The numeric arrays in a piece's PointData or CellData; the names of strings and
/// bits are noted.
[[nodiscard]] Result<std::vector<MeshField>> load_xml_fields(VtkXmlMeshFile& file,
                                                             const pugi::xml_node& data,
                                                             std::uint64_t n_tuples);

/// What a data set's PatchIds and PatchNames tell, of as many as there are of both.
[[nodiscard]] Result<std::vector<BoundaryPatch>> load_xml_patch_names(VtkXmlMeshFile& file,
                                                                      const pugi::xml_node& data);
/// Likewise of RegionIds and RegionNames.
[[nodiscard]] Result<std::vector<MeshRegion>> load_xml_region_names(VtkXmlMeshFile& file,
                                                                    const pugi::xml_node& data);

/// The number TimeValue of a data set's field data; none where there is no such, of one number.
[[nodiscard]] Result<std::optional<double>> load_xml_time(VtkXmlMeshFile& file,
                                                          const pugi::xml_node& data);

}  // namespace lode::io
