#include "lode/io/vtk_xml_output.h"

namespace lode::io {
namespace {

/// XML comments must not contain "--"; tags in them would mislead readers that look for the
/// appended data without parsing all of the XML.
std::string to_xml_comment(std::string_view text) {
  std::string comment = to_one_line(text);
  for (std::size_t i = 0; i < comment.size(); ++i) {
    const bool is_second_dash = i > 0 && comment[i - 1] == '-' && comment[i] == '-';
    if (is_second_dash || comment[i] == '<' || comment[i] == '>') comment[i] = ' ';
  }
  return fmt::format("<!-- {} -->\n", comment);
}

}  // namespace

std::string vtk_array_name(std::string_view name) {
  std::string kept = to_one_line(name);
  for (char& c : kept)
    if (c == '<' || c == '>' || c == '&' || c == '"' || c == '\'') c = '_';
  const bool has_meaning = kept.empty() || kept == "isovalue" || kept == "Normals" ||
                           kept == "Points" || kept == "error";
  return has_meaning ? "value" : kept;
}

std::string vtk_xml_head(std::string_view type, std::string_view comment, Frame frame) {
  std::string xml = "<?xml version=\"1.0\"?>\n";
  if (!comment.empty()) xml += to_xml_comment(comment);
  xml += to_xml_comment(fmt::format("frame {}", name_of(frame)));
  return xml + fmt::format(
                   "<VTKFile type=\"{0}\" version=\"1.0\" byte_order=\"LittleEndian\" "
                   "header_type=\"UInt64\">\n<{0}>\n",
                   type);
}

std::string describe_array(const VtkXmlArray& array, std::uint64_t& offset) {
  std::string xml =
      fmt::format("<DataArray {} format=\"appended\" offset=\"{}\"/>\n", array.attributes, offset);
  offset += sizeof(std::uint64_t) + array.n_bytes;
  return xml;
}

Result<void> write_array_size(SurfaceOutput& file, const VtkXmlArray& array) {
  return file.write(std::as_bytes(std::span(&array.n_bytes, 1)));
}

std::string vtk_time(const std::optional<double>& time) {
  if (!time) return {};
  return fmt::format(
      "<DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" "
      "format=\"ascii\">{}</DataArray>\n",
      *time);
}

}  // namespace lode::io
