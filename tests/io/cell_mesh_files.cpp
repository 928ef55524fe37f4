#include "tests/io/cell_mesh_files.h"

#include <fmt/format.h>

#include <set>

namespace lode::io::test {
namespace {

std::string count_bytes(std::uint64_t count, const XmlForm& form) {
  if (form.header == "UInt64") return bytes_of<std::uint64_t>({count}, form.order);
  return bytes_of<std::uint32_t>({static_cast<std::uint32_t>(count)}, form.order);
}

/// A header and what it announces, which base64 encodes one by one where data are compressed.
struct Encoded {
  std::string header;
  std::string data;
};

Encoded encoded(const std::string& bytes, const XmlForm& form) {
  if (form.block == 0) return {count_bytes(bytes.size(), form) + bytes, ""};
  Encoded result;
  std::string sizes;
  for (std::size_t at = 0; at < bytes.size(); at += form.block) {
    const std::string block = zlibbed(bytes.substr(at, form.block));
    sizes += count_bytes(block.size(), form);
    result.data += block;
  }
  const std::uint64_t n = (bytes.size() + form.block - 1) / form.block;
  result.header = count_bytes(n, form) + count_bytes(form.block, form) +
                  count_bytes(bytes.size() % form.block, form) + sizes;
  return result;
}

std::string in_base64(const Encoded& data) {
  return base64(data.header) + (data.data.empty() ? "" : base64(data.data));
}

std::string number_text(ScalarType type, double value) {
  if (is_floating(type)) return fmt::format("{:.17g} ", value);
  return fmt::format("{:.0f} ", value);
}

std::string xml_type(ScalarType type) {
  std::string name(name_of(type));
  name[0] = static_cast<char>(name[0] - 'a' + 'A');
  if (name[0] == 'U') name[1] = 'I';
  return name;
}

std::vector<double> flat(const std::vector<Vec3d>& points) {
  std::vector<double> values;
  for (const Vec3d& point : points) values.insert(values.end(), point.v.begin(), point.v.end());
  return values;
}

template <typename T>
std::vector<double> doubles(const std::vector<T>& numbers) {
  return {numbers.begin(), numbers.end()};
}

/// VTK's list of a cell's faces: their number, then each as its number of corners and these.
std::vector<double> face_list(const CellMesh& mesh, std::size_t cell) {
  std::vector<double> list{0};
  const auto faces = mesh.faces_of(cell);
  for (std::size_t at = 0; at < faces.size(); at += faces[at] + std::size_t{1}) {
    ++list[0];
    for (std::size_t i = 0; i <= faces[at]; ++i) list.push_back(faces[at + i]);
  }
  return list;
}

std::string xml_cells(const CellMesh& mesh, XmlArrays& arrays) {
  const std::vector<double> begins = doubles(mesh.begins);
  std::string text =
      "<Cells>" + arrays.array("connectivity", ScalarType::int64, doubles(mesh.corners)) +
      arrays.array("offsets", ScalarType::int64, {begins.begin() + 1, begins.end()}) +
      arrays.array("types", ScalarType::uint8, doubles(mesh.types));
  if (mesh.face_begins.empty()) return text + "</Cells>";
  std::vector<double> faces;
  std::vector<double> ends;
  for (std::size_t cell = 0; cell < mesh.n_cells(); ++cell) {
    if (mesh.faces_of(cell).empty()) {
      ends.push_back(-1);
      continue;
    }
    const std::vector<double> list = face_list(mesh, cell);
    faces.insert(faces.end(), list.begin(), list.end());
    ends.push_back(static_cast<double>(faces.size()));
  }
  return text + arrays.array("faces", ScalarType::int64, faces) +
         arrays.array("faceoffsets", ScalarType::int64, ends) + "</Cells>";
}

std::string xml_points(const CellMesh& mesh, XmlArrays& arrays) {
  const ScalarType type = mesh.has_narrow_points ? ScalarType::float32 : ScalarType::float64;
  return "<Points>" + arrays.array("Points", type, flat(mesh.points), 3) + "</Points>";
}

bool is_binary(LegacyForm form) {
  return form == LegacyForm::binary_counts || form == LegacyForm::binary_offsets;
}

std::string legacy_numbers(ScalarType type, const std::vector<double>& values, LegacyForm form) {
  if (is_binary(form)) return typed_bytes(type, values, ByteOrder::big) + "\n";
  std::string text;
  for (std::size_t i = 0; i < values.size(); ++i) {
    text += number_text(type, values[i]);
    if (i % 9 == 8) text += "\n";
  }
  return text + "\n";
}

std::string legacy_type_name(ScalarType type) {
  switch (type) {
    case ScalarType::uint8: return "unsigned_char";
    case ScalarType::int8: return "signed_char";
    case ScalarType::uint16: return "unsigned_short";
    case ScalarType::int16: return "short";
    case ScalarType::uint32: return "unsigned_int";
    case ScalarType::int32: return "int";
    case ScalarType::uint64: return "vtktypeuint64";
    case ScalarType::int64: return "vtktypeint64";
    case ScalarType::float32: return "float";
    default: return "double";
  }
}

/// A cell's corners, or a polyhedron's list of faces.
std::vector<double> legacy_cell(const CellMesh& mesh, std::size_t cell) {
  if (!mesh.faces_of(cell).empty()) return face_list(mesh, cell);
  const auto corners = mesh.corners_of(cell);
  return {corners.begin(), corners.end()};
}

std::string legacy_cells(const CellMesh& mesh, LegacyForm form) {
  std::vector<double> counted;
  std::vector<double> offsets{0};
  std::vector<double> corners;
  for (std::size_t cell = 0; cell < mesh.n_cells(); ++cell) {
    const std::vector<double> list = legacy_cell(mesh, cell);
    counted.push_back(static_cast<double>(list.size()));
    counted.insert(counted.end(), list.begin(), list.end());
    corners.insert(corners.end(), list.begin(), list.end());
    offsets.push_back(static_cast<double>(corners.size()));
  }
  if (form == LegacyForm::ascii_counts || form == LegacyForm::binary_counts)
    return fmt::format("CELLS {} {}\n", mesh.n_cells(), counted.size()) +
           legacy_numbers(ScalarType::int32, counted, form);
  return fmt::format("CELLS {} {}\nOFFSETS vtktypeint64\n", offsets.size(), corners.size()) +
         legacy_numbers(ScalarType::int64, offsets, form) + "CONNECTIVITY vtktypeint64\n" +
         legacy_numbers(ScalarType::int64, corners, form);
}

std::string legacy_fields(const std::string& section, std::size_t n,
                          const std::vector<MeshField>& fields, LegacyForm form) {
  std::string text = fmt::format("{} {}\nFIELD FieldData {}\n", section, n, fields.size());
  for (const MeshField& field : fields)
    text += fmt::format("{} {} {} {}\n", field.name, field.n_components, n,
                        legacy_type_name(field.type)) +
            legacy_numbers(field.type, field.values, form);
  return text;
}

/// Values that every type holds, and some that only this one does.
MeshField varied_field(const std::string& name, ScalarType type, std::size_t n, int n_components) {
  MeshField field{name, type, n_components, {}};
  for (std::size_t i = 0; i < n * static_cast<std::size_t>(n_components); ++i) {
    double value = static_cast<double>((i * 37 + 11) % 100);
    if (type == ScalarType::int16 || type == ScalarType::int32) value -= 50;
    if (is_floating(type)) value = value * 0.375 - 7;
    field.values.push_back(value);
  }
  return field;
}

/// KINDIds, and KINDNames as VTK has strings: characters, and a 0 after each name.
template <typename Named>
std::string xml_names(const std::string& kind, const std::vector<Named>& all, XmlArrays& arrays) {
  MeshField ids{kind + "Ids", ScalarType::int64, 1, {}};
  MeshField names{kind + "Names", ScalarType::uint8, 1, {}};
  for (const Named& named : all) {
    ids.values.push_back(static_cast<double>(named.id));
    for (const char c : named.name) names.values.push_back(static_cast<unsigned char>(c));
    names.values.push_back(0);
  }
  std::string text = arrays.array(names.name, names.type, names.values);
  text.replace(text.find("DataArray type=\"UInt8\""), 22, "Array type=\"String\"");
  if (const std::size_t end = text.find("</DataArray>"); end != std::string::npos)
    text.replace(end, 12, "</Array>");
  text += arrays.array(ids.name, ids.type, ids.values);
  const std::string name = "Name=\"" + ids.name + '"';
  text.insert(text.find(name), fmt::format("NumberOfTuples=\"{}\" ", ids.values.size()));
  return text;
}

}  // namespace

std::vector<XmlForm> xml_forms() {
  return {{"ascii"},
          {"inline_base64", "binary"},
          {"inline_base64_big_64", "binary", "raw", "UInt64", ByteOrder::big},
          {"inline_zlib", "binary", "raw", "UInt32", ByteOrder::little, 100},
          {"appended_raw", "appended"},
          {"appended_raw_big_64", "appended", "raw", "UInt64", ByteOrder::big},
          {"appended_zlib_64", "appended", "raw", "UInt64", ByteOrder::little, 64},
          {"appended_base64", "appended", "base64"},
          {"appended_base64_zlib_big", "appended", "base64", "UInt32", ByteOrder::big, 128}};
}

std::string XmlArrays::array(const std::string& name, ScalarType type,
                             const std::vector<double>& values, int n_components) {
  std::string head = fmt::format(R"(<DataArray type="{}" Name="{}" NumberOfComponents="{}")",
                                 xml_type(type), name, n_components);
  if (form_.format == "ascii") {
    std::string text;
    for (const double value : values) text += number_text(type, value);
    return head + R"( format="ascii">)" + text + "</DataArray>\n";
  }
  const Encoded data = encoded(typed_bytes(type, values, form_.order), form_);
  if (form_.format == "binary")
    return head + R"( format="binary">)" + in_base64(data) + "</DataArray>\n";
  head += fmt::format(R"( format="appended" offset="{}"/>)", appended_.size());
  appended_ += form_.encoding == "raw" ? data.header + data.data : in_base64(data);
  return head + "\n";
}

std::string XmlArrays::fields(const std::string& element, const std::vector<MeshField>& fields) {
  std::string text;
  for (const MeshField& field : fields)
    text += array(field.name, field.type, field.values, field.n_components);
  return fmt::format("<{0}>\n{1}</{0}>\n", element, text);
}

std::string XmlArrays::file(const std::string& kind, const std::string& attributes,
                            const std::string& content) const {
  std::string text = fmt::format(
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"{}\" byte_order=\"{}\" header_type=\"{}\"{}>\n"
      "<{} {}>\n{}</{}>\n",
      kind, form_.order == ByteOrder::big ? "BigEndian" : "LittleEndian", form_.header,
      form_.block > 0 ? " compressor=\"vtkZLibDataCompressor\"" : "", kind, attributes, content,
      kind);
  if (form_.format == "appended")
    text += fmt::format("<AppendedData encoding=\"{}\">\n_", form_.encoding) + appended_ +
            "\n</AppendedData>\n";
  return text + "</VTKFile>\n";
}

std::string vtu_of(const std::vector<CellMesh>& pieces, const XmlForm& form) {
  XmlArrays arrays(form);
  std::string content;
  for (const CellMesh& mesh : pieces)
    content += fmt::format("<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n",
                           mesh.points.size(), mesh.n_cells()) +
               arrays.fields("PointData", mesh.point_fields) +
               arrays.fields("CellData", mesh.cell_fields) + xml_points(mesh, arrays) +
               xml_cells(mesh, arrays) + "</Piece>\n";
  std::string names;
  if (!pieces[0].patch_names.empty()) names += xml_names("Patch", pieces[0].patch_names, arrays);
  if (!pieces[0].region_names.empty()) names += xml_names("Region", pieces[0].region_names, arrays);
  if (pieces[0].time) names += arrays.array("TimeValue", ScalarType::float64, {*pieces[0].time});
  if (!names.empty()) content = "<FieldData>\n" + names + "</FieldData>\n" + content;
  return arrays.file("UnstructuredGrid", "", content);
}

std::string vts_of(const std::string& whole, const std::vector<VtsPiece>& pieces,
                   const XmlForm& form) {
  XmlArrays arrays(form);
  std::string content;
  for (const VtsPiece& piece : pieces)
    content += fmt::format("<Piece Extent=\"{}\">\n", piece.extent) +
               arrays.fields("PointData", piece.content.point_fields) +
               arrays.fields("CellData", piece.content.cell_fields) +
               xml_points(piece.content, arrays) + "</Piece>\n";
  return arrays.file("StructuredGrid", fmt::format("WholeExtent=\"{}\"", whole), content);
}

std::string legacy_of(const CellMesh& mesh, LegacyForm form) {
  const bool has_offsets = form == LegacyForm::ascii_offsets || form == LegacyForm::binary_offsets;
  const ScalarType type = mesh.has_narrow_points ? ScalarType::float32 : ScalarType::float64;
  return fmt::format("# vtk DataFile Version {}\na test\n{}\nDATASET UNSTRUCTURED_GRID\n",
                     has_offsets ? "5.1" : "3.0", is_binary(form) ? "BINARY" : "ASCII") +
         fmt::format("FIELD FieldData {}\nCYCLE 1 1 int\n", mesh.time ? 2 : 1) +
         legacy_numbers(ScalarType::int32, {7}, form) +
         (mesh.time
              ? "TimeValue 1 1 double\n" + legacy_numbers(ScalarType::float64, {*mesh.time}, form)
              : std::string()) +
         fmt::format("POINTS {} {}\n", mesh.points.size(), legacy_type_name(type)) +
         legacy_numbers(type, flat(mesh.points), form) + legacy_cells(mesh, form) +
         fmt::format("CELL_TYPES {}\n", mesh.n_cells()) +
         legacy_numbers(ScalarType::int32, doubles(mesh.types), form) +
         legacy_fields("POINT_DATA", mesh.points.size(), mesh.point_fields, form) +
         legacy_fields("CELL_DATA", mesh.n_cells(), mesh.cell_fields, form);
}

std::string typed_bytes(ScalarType type, const std::vector<double>& values, ByteOrder order) {
  return visit_scalar_type(type, [&]<typename T>() {
    std::vector<T> numbers;
    for (const double value : values) numbers.push_back(static_cast<T>(value));
    return bytes_of<T>(numbers, order);
  });
}

CellMesh empty_cells() {
  CellMesh mesh;
  mesh.begins = {0};
  return mesh;
}

void add_cell(CellMesh& mesh, CellType type, const std::vector<std::uint32_t>& corners) {
  mesh.types.push_back(static_cast<std::uint8_t>(type));
  mesh.corners.insert(mesh.corners.end(), corners.begin(), corners.end());
  mesh.begins.push_back(mesh.corners.size());
  if (!mesh.face_begins.empty()) mesh.face_begins.push_back(mesh.faces.size());
}

void add_polyhedron(CellMesh& mesh, const std::vector<std::vector<std::uint32_t>>& faces) {
  if (mesh.face_begins.empty()) mesh.face_begins.assign(mesh.n_cells() + 1, 0);
  std::set<std::uint32_t> corners;
  for (const std::vector<std::uint32_t>& face : faces) {
    mesh.faces.push_back(static_cast<std::uint32_t>(face.size()));
    mesh.faces.insert(mesh.faces.end(), face.begin(), face.end());
    corners.insert(face.begin(), face.end());
  }
  add_cell(mesh, CellType::polyhedron, {corners.begin(), corners.end()});
}

CellMesh varied_mesh() {
  CellMesh mesh = empty_cells();
  for (int i = 0; i < 24; ++i)
    mesh.points.push_back({{0.25 * (i % 3), 0.5 * (i / 3 % 3), 1.0 * (i / 9) + 0.125}});
  mesh.has_narrow_points = true;
  add_cell(mesh, CellType::tetrahedron, {0, 1, 3, 9});
  add_cell(mesh, CellType::triangle, {4, 5, 7});
  add_polyhedron(mesh, {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}});
  add_cell(mesh, CellType::hexahedron, {0, 1, 4, 3, 9, 10, 13, 12});
  add_cell(mesh, CellType::voxel, {1, 2, 4, 5, 10, 11, 13, 14});
  add_cell(mesh, CellType::wedge, {3, 4, 6, 12, 13, 15});
  add_polyhedron(mesh, {{4, 5, 8, 7}, {4, 13, 5}, {5, 13, 8}, {8, 13, 7}, {7, 13, 4}});
  add_cell(mesh, CellType::pyramid, {4, 5, 8, 7, 14});
  add_cell(mesh, CellType::quadratic_tetrahedron, {0, 2, 6, 18, 1, 4, 3, 9, 10, 12});
  add_cell(mesh, CellType::vertex, {23});
  for (int i = 1; i <= 10; ++i) {
    const auto type = static_cast<ScalarType>(i);
    const std::string name(name_of(type));
    mesh.point_fields.push_back(varied_field(name, type, mesh.points.size(), 1 + i % 3));
    mesh.cell_fields.push_back(varied_field("cell_" + name, type, mesh.n_cells(), 1));
  }
  return mesh;
}

CellMesh read_mesh(const std::string& path) {
  Result<CellMesh> mesh = read_cell_mesh(path, {});
  EXPECT_TRUE(mesh) << mesh.error().message;
  return mesh ? std::move(mesh).value() : empty_cells();
}

void expect_same_mesh(const CellMesh& a, const CellMesh& b) {
  EXPECT_EQ(a.points, b.points);
  EXPECT_EQ(a.has_narrow_points, b.has_narrow_points);
  EXPECT_EQ(a.types, b.types);
  EXPECT_EQ(a.begins, b.begins);
  EXPECT_EQ(a.corners, b.corners);
  EXPECT_EQ(a.face_begins, b.face_begins);
  EXPECT_EQ(a.faces, b.faces);
  for (const auto& [one, other] :
       {std::pair(&a.point_fields, &b.point_fields), std::pair(&a.cell_fields, &b.cell_fields)}) {
    ASSERT_EQ(one->size(), other->size());
    for (std::size_t i = 0; i < one->size(); ++i) {
      EXPECT_EQ((*one)[i].name, (*other)[i].name);
      EXPECT_EQ((*one)[i].type, (*other)[i].type);
      EXPECT_EQ((*one)[i].n_components, (*other)[i].n_components);
      EXPECT_EQ((*one)[i].values, (*other)[i].values);
    }
  }
}

void expect_mesh_failure(const std::string& path, const std::vector<std::string>& parts) {
  const Result<CellMesh> mesh = read_cell_mesh(path, {});
  ASSERT_FALSE(mesh) << path;
  EXPECT_NE(mesh.error().message.find(path), std::string::npos) << mesh.error().message;
  for (const std::string& part : parts)
    EXPECT_NE(mesh.error().message.find(part), std::string::npos)
        << mesh.error().message << " lacks " << part;
}

}  // namespace lode::io::test
