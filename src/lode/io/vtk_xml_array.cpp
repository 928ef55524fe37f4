#include "lode/io/vtk_xml_array.h"

#include <algorithm>
#include <array>
#include <limits>
#include <new>

#include "lode/io/byte_stream.h"
#include "lode/io/spooled_store.h"
#include "lode/io/text.h"
#include "lode/io/text_cursor.h"
#include "lode/io/text_samples.h"

namespace lode::io {
namespace {

constexpr std::string_view kAppendedTag = "<AppendedData";

/// The file up to the appended data, whose tag is found piece by piece; and where that tag is.
struct XmlPart {
  std::string text;
  std::optional<std::uint64_t> appended_tag;
};

Result<XmlPart> read_xml_part(const InputFile& file, const SampleStorage& storage) {
  constexpr std::uint64_t kChunk = 1 << 20;
  constexpr std::uint64_t kMaxStart = 1024;
  XmlPart part;
  while (part.text.size() < file.size()) {
    const std::size_t start = part.text.size();
    if (!storage.holds(start))
      return fail(
          "{}: XML text of more than {} cannot be held within a memory limit of {}; write the "
          "arrays as raw appended data",
          file.path(), format_bytes(start), format_bytes(storage.memory_limit));
    const auto n = static_cast<std::size_t>(std::min(kChunk, file.size_from(start)));
    part.text.resize(start + n);
    LODE_CHECK(file.read(start, std::as_writable_bytes(std::span(part.text.data() + start, n))));
    // Binary garbage is noticed in the first piece.
    if (start == 0 && part.text.substr(0, kMaxStart).find("<VTKFile") == std::string::npos)
      return fail("{}: expected a VTK XML file, got {}", file.path(),
                  in_quotes(std::string_view(part.text).substr(0, 20)));
    const std::size_t tag =
        part.text.find(kAppendedTag, start - std::min(start, kAppendedTag.size()));
    if (tag == std::string::npos) continue;
    part.appended_tag = tag;
    part.text.resize(tag);
    part.text += "</VTKFile>";
    return part;
  }
  return part;
}

Result<void> find_appended(VtkXmlFile& xml, std::uint64_t tag) {
  constexpr std::uint64_t kMaxTag = 4096;
  const InputFile& file = *xml.file;
  std::string text(static_cast<std::size_t>(std::min(kMaxTag, file.size_from(tag))), '\0');
  LODE_CHECK(file.read(tag, std::as_writable_bytes(std::span(text.data(), text.size()))));
  const std::size_t close = text.find('>');
  const std::size_t underscore = text.find('_', close == std::string::npos ? 0 : close);
  if (close == std::string::npos || underscore == std::string::npos ||
      !trimmed(std::string_view(text).substr(close + 1, underscore - close - 1)).empty())
    return fail("{}: expected an underscore before the appended data", file.path());
  pugi::xml_document element;
  const std::string closed = text.substr(0, close) + "/>";
  const pugi::xml_parse_result parsed =
      element.load_buffer(closed.data(), closed.size(), pugi::parse_default, pugi::encoding_utf8);
  if (parsed.status == pugi::status_out_of_memory) throw std::bad_alloc();
  const std::string encoding = element.first_child().attribute("encoding").as_string("base64");
  if (encoding != "raw" && encoding != "base64")
    return fail("{}: expected appended data as raw or base64, got {}", file.path(),
                in_quotes(encoding));
  xml.appended = encoding == "raw" ? VtkXmlFile::Appended::raw : VtkXmlFile::Appended::base64;
  xml.appended_start = tag + underscore + 1;
  return {};
}

Result<void> read_attributes(VtkXmlFile& xml) {
  const std::string& path = xml.file->path();
  const pugi::xml_node root = xml.root();
  const std::string order = root.attribute("byte_order").as_string("LittleEndian");
  if (order != "LittleEndian" && order != "BigEndian")
    return fail("{}: expected byte_order LittleEndian or BigEndian, got {}", path,
                in_quotes(order));
  xml.counts.byte_order = order == "BigEndian" ? ByteOrder::big : ByteOrder::little;
  const std::string header = root.attribute("header_type").as_string("UInt32");
  if (header != "UInt32" && header != "UInt64")
    return fail("{}: expected header_type UInt32 or UInt64, got {}", path, in_quotes(header));
  xml.counts.n_bytes = header == "UInt64" ? 8 : 4;
  const std::string compressor = root.attribute("compressor").as_string();
  if (!compressor.empty() && compressor != "vtkZLibDataCompressor")
    return fail(
        "{}: expected no compressor or vtkZLibDataCompressor, got {}; write the file with one of "
        "these",
        path, in_quotes(compressor));
  xml.is_compressed = !compressor.empty();
  return {};
}

/// An array's bytes as they are in the file, before any decompression.
Result<std::unique_ptr<ByteStream>> encoded_stream(const VtkXmlFile& xml,
                                                   const pugi::xml_node& array) {
  const std::string& path = xml.file->path();
  const std::string format = array.attribute("format").as_string("ascii");
  if (format == "binary")
    return make_base64_stream(make_memory_stream(array.child_value(), path, xml.document), path);
  if (format != "appended")
    return fail("{}: expected format ascii, binary or appended, got {}", path, in_quotes(format));
  if (xml.appended == VtkXmlFile::Appended::none)
    return fail("{}: an array refers to appended data, but there are none", path);
  const auto offset = to_uint64(array.attribute("offset").as_string());
  const std::uint64_t n_left = xml.file->size_from(xml.appended_start);
  if (!offset || *offset >= n_left)
    return fail("{}: expected an offset into the {} bytes of appended data, got {}", path, n_left,
                in_quotes(array.attribute("offset").as_string()));
  auto stream = make_file_stream(xml.file, xml.appended_start + *offset);
  if (xml.appended == VtkXmlFile::Appended::raw) return stream;
  return make_base64_stream(std::move(stream), path);
}

/// Whether the array's bytes, compressed or not, lie in the file as they are.
bool is_raw_appended(const VtkXmlFile& xml, const pugi::xml_node& array) {
  return xml.appended == VtkXmlFile::Appended::raw &&
         std::string_view(array.attribute("format").as_string()) == "appended";
}

bool is_text(const pugi::xml_node& array) {
  return std::string_view(array.attribute("format").as_string("ascii")) == "ascii";
}

Result<std::unique_ptr<SampleStore>> load_text_array(const VtkXmlFile& xml,
                                                     const VtkXmlDataArray& array) {
  const std::string& path = xml.file->path();
  LODE_CHECK(check_held(path, "text", array.n_bytes, array.storage));
  const std::string_view text = array.node.child_value();
  auto stream = make_memory_stream(text, path);
  TextCursor cursor(*stream, path);
  LODE_TRY(std::vector<std::byte> bytes,
           read_text_samples(cursor, text.size(), array.type, array.n_bytes));
  return make_memory_store(std::move(bytes));
}

/// Decodes a stream, known to be long enough, now or while it is read.
Result<std::unique_ptr<SampleStore>> keep(const VtkXmlFile& xml, std::unique_ptr<ByteStream> stream,
                                          const VtkXmlDataArray& array) {
  if (!array.storage.holds(array.n_bytes))
    return make_spooled_store({.path = xml.file->path(),
                               .stream = std::move(stream),
                               .n_bytes = array.n_bytes,
                               .tally = xml.file->tally()},
                              array.storage);
  std::vector<std::byte> bytes(static_cast<std::size_t>(array.n_bytes));
  LODE_CHECK(stream->read(bytes));
  return make_memory_store(std::move(bytes));
}

}  // namespace

Result<VtkXmlFilePtr> open_vtk_xml(const std::string& path, const SampleStorage& storage) {
  auto xml = std::make_shared<VtkXmlFile>();
  LODE_TRY(xml->file, InputFile::open(path));
  LODE_TRY(const XmlPart part, read_xml_part(*xml->file, storage));
  const pugi::xml_parse_result parsed = xml->document->load_buffer(
      part.text.data(), part.text.size(), pugi::parse_default, pugi::encoding_utf8);
  if (parsed.status == pugi::status_out_of_memory) throw std::bad_alloc();
  if (!parsed)
    return fail("{}: expected well-formed XML: {} at byte {}", path, parsed.description(),
                parsed.offset);
  if (!xml->root()) return fail("{}: expected the XML element VTKFile", path);
  LODE_CHECK(read_attributes(*xml));
  if (part.appended_tag) LODE_CHECK(find_appended(*xml, *part.appended_tag));
  return VtkXmlFilePtr(std::move(xml));
}

ByteOrder byte_order_of(const VtkXmlFile& xml, const pugi::xml_node& array) {
  return is_text(array) ? native_byte_order() : xml.counts.byte_order;
}

Result<std::unique_ptr<SampleStore>> load_vtk_xml_array(const VtkXmlFile& xml,
                                                        const VtkXmlDataArray& array) {
  const std::string& path = xml.file->path();
  const std::uint64_t n_bytes = array.n_bytes;
  if (is_text(array.node)) return load_text_array(xml, array);
  LODE_TRY(std::unique_ptr<ByteStream> stream, encoded_stream(xml, array.node));
  const bool is_in_file = is_raw_appended(xml, array.node);
  if (xml.is_compressed) {
    LODE_TRY(VtkBlocks blocks, read_vtk_blocks(path, *stream, xml.counts, n_bytes));
    if (is_in_file && !array.storage.holds(n_bytes) && blocks.are_small())
      return make_vtk_block_store(xml.file, xml.file->size() - stream->n_left(), std::move(blocks));
    return keep(xml, make_vtk_block_stream(std::move(stream), std::move(blocks)), array);
  }
  LODE_TRY(const std::uint64_t n_given, read_vtk_count(*stream, xml.counts));
  if (n_given != n_bytes || n_bytes > stream->n_left())
    return fail("{}: expected an array of {} bytes, got one of {} ({} follow)", path, n_bytes,
                n_given, stream->n_left());
  if (is_in_file) return make_file_store(xml.file, xml.file->size() - stream->n_left(), n_bytes);
  return keep(xml, std::move(stream), array);
}

Result<std::uint64_t> encoded_size(const VtkXmlFile& xml, const pugi::xml_node& array) {
  if (is_text(array)) return std::uint64_t{0};
  LODE_TRY(const std::unique_ptr<ByteStream> stream, encoded_stream(xml, array));
  LODE_TRY(const std::uint64_t first, read_vtk_count(*stream, xml.counts));
  if (!xml.is_compressed || first == 0) return first;
  LODE_TRY(const std::uint64_t block, read_vtk_count(*stream, xml.counts));
  LODE_TRY(const std::uint64_t partial, read_vtk_count(*stream, xml.counts));
  const std::uint64_t n_full = first - (partial > 0 ? 1 : 0);
  if (block > 0 && n_full > (std::numeric_limits<std::uint64_t>::max() - partial) / block)
    return fail("{}: expected compressed blocks of a sensible size, got {} of {} bytes",
                xml.file->path(), n_full, block);
  return n_full * block + partial;
}

}  // namespace lode::io
