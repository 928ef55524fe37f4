#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

#include "lode/core/cell_mesh.h"
#include "lode/io/mesh_reader.h"
#include "tests/io/volume_test_files.h"

namespace lode::io::test {

/// How a VTK XML file holds its arrays.
struct XmlForm {
  std::string name = "ascii";
  std::string format = "ascii";  ///< ascii, binary, or appended as `encoding`.
  std::string encoding = "raw";  ///< Of appended data: raw or base64.
  std::string header = "UInt32";
  ByteOrder order = ByteOrder::little;
  std::size_t block = 0;  ///< Bytes in each compressed block; 0: not compressed.
};

/// Forms that between them have each encoding, header, byte order, and compression.
std::vector<XmlForm> xml_forms();

/// Collects arrays, inline or appended, in one form.
class XmlArrays {
 public:
  explicit XmlArrays(XmlForm form) : form_(std::move(form)) {}

  /// A DataArray element.
  std::string array(const std::string& name, ScalarType type, const std::vector<double>& values,
                    int n_components = 1);
  std::string fields(const std::string& element, const std::vector<MeshField>& fields);
  /// The whole file round the content of its data set.
  [[nodiscard]] std::string file(const std::string& kind, const std::string& attributes,
                                 const std::string& content) const;

 private:
  XmlForm form_;
  std::string appended_;
};

std::string vtu_of(const std::vector<CellMesh>& pieces, const XmlForm& form = {});

/// A grid's points and fields, in the part of it that `extent` names.
struct VtsPiece {
  std::string extent;
  CellMesh content;
};
std::string vts_of(const std::string& whole, const std::vector<VtsPiece>& pieces,
                   const XmlForm& form = {});

enum class LegacyForm { ascii_counts, binary_counts, ascii_offsets, binary_offsets };
std::string legacy_of(const CellMesh& mesh, LegacyForm form);

/// Bytes of numbers of a type.
std::string typed_bytes(ScalarType type, const std::vector<double>& values, ByteOrder order);

/// A mesh without cells.
CellMesh empty_cells();
void add_cell(CellMesh& mesh, CellType type, const std::vector<std::uint32_t>& corners);
/// Each face as its corners.
void add_polyhedron(CellMesh& mesh, const std::vector<std::vector<std::uint32_t>>& faces);
/// Cells of nine types, polyhedra among them, and a field of each numeric type at points and cells.
CellMesh varied_mesh();

/// A file that must be readable.
CellMesh read_mesh(const std::string& path);
void expect_same_mesh(const CellMesh& a, const CellMesh& b);
/// Expects an error that names the file and contains all `parts`.
void expect_mesh_failure(const std::string& path, const std::vector<std::string>& parts);

}  // namespace lode::io::test
