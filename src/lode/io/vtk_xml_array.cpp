#include "lode/io/vtk_xml_array.h"

#include <algorithm>
#include <array>

#include "lode/io/byte_stream.h"
#include "lode/io/inflate.h"
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

Result<XmlPart> read_xml_part(const InputFile& file) {
  constexpr std::uint64_t kChunk = 1 << 20;
  constexpr std::uint64_t kMaxStart = 1024;
  XmlPart part;
  while (part.text.size() < file.size()) {
    const std::size_t start = part.text.size();
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
  element.load_buffer(closed.data(), closed.size(), pugi::parse_default, pugi::encoding_utf8);
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
  xml.byte_order = order == "BigEndian" ? ByteOrder::big : ByteOrder::little;
  const std::string header = root.attribute("header_type").as_string("UInt32");
  if (header != "UInt32" && header != "UInt64")
    return fail("{}: expected header_type UInt32 or UInt64, got {}", path, in_quotes(header));
  xml.header_bytes = header == "UInt64" ? 8 : 4;
  const std::string compressor = root.attribute("compressor").as_string();
  if (!compressor.empty() && compressor != "vtkZLibDataCompressor")
    return fail("{}: expected no compressor or vtkZLibDataCompressor, got {}", path,
                in_quotes(compressor));
  xml.is_compressed = !compressor.empty();
  return {};
}

/// An array's bytes as they are in the file, before any decompression. `text` keeps what the
/// stream reads from.
Result<std::unique_ptr<ByteStream>> encoded_stream(const VtkXmlFile& xml,
                                                   const pugi::xml_node& array, std::string& text) {
  const std::string& path = xml.file->path();
  const std::string format = array.attribute("format").as_string("ascii");
  if (format == "binary") return make_base64_stream(array.child_value(), path);
  if (format != "appended")
    return fail("{}: expected format ascii, binary or appended, got {}", path, in_quotes(format));
  if (xml.appended == VtkXmlFile::Appended::none)
    return fail("{}: an array refers to appended data, but there are none", path);
  const auto offset = to_uint64(array.attribute("offset").as_string());
  const std::uint64_t n_left = xml.file->size_from(xml.appended_start);
  if (!offset || *offset >= n_left)
    return fail("{}: expected an offset into the {} bytes of appended data, got {}", path, n_left,
                in_quotes(array.attribute("offset").as_string()));
  const std::uint64_t start = xml.appended_start + *offset;
  if (xml.appended == VtkXmlFile::Appended::raw) return make_file_stream(xml.file, start);
  text.resize(static_cast<std::size_t>(xml.file->size_from(start)));
  LODE_CHECK(xml.file->read(start, std::as_writable_bytes(std::span(text.data(), text.size()))));
  return make_base64_stream(text, path);
}

Result<std::uint64_t> read_count(const VtkXmlFile& xml, ByteStream& stream) {
  std::array<std::byte, 8> bytes{};
  const auto used = std::span(bytes).first(xml.header_bytes);
  LODE_CHECK(stream.read(used));
  std::uint64_t count = 0;
  for (std::size_t i = 0; i < used.size(); ++i) {
    const std::size_t at = xml.byte_order == ByteOrder::big ? i : used.size() - 1 - i;
    count = count << 8 | static_cast<std::uint64_t>(used[at]);
  }
  return count;
}

struct BlockSizes {
  std::vector<std::uint64_t> compressed;
  std::uint64_t block = 0;
  std::uint64_t last = 0;  ///< Of the last block.
};

Result<BlockSizes> read_block_sizes(const VtkXmlFile& xml, ByteStream& stream,
                                    std::uint64_t n_bytes) {
  const std::string& path = xml.file->path();
  LODE_TRY(const std::uint64_t n_blocks, read_count(xml, stream));
  LODE_TRY(const std::uint64_t block, read_count(xml, stream));
  LODE_TRY(const std::uint64_t partial, read_count(xml, stream));
  const std::uint64_t n_full = n_blocks - (partial > 0 && n_blocks > 0 ? 1 : 0);
  const bool fits =
      n_blocks > 0 && partial <= n_bytes && (n_full == 0 || block <= n_bytes / n_full);
  if (!fits || n_full * block + partial != n_bytes)
    return fail("{}: expected compressed blocks of {} bytes in all, got {} of {} and {} more", path,
                n_bytes, n_full, block, partial);
  if (n_blocks > stream.n_left() / xml.header_bytes)
    return fail("{}: expected {} compressed blocks, but only {} bytes follow", path, n_blocks,
                stream.n_left());
  BlockSizes sizes{.compressed = {}, .block = block, .last = partial > 0 ? partial : block};
  sizes.compressed.resize(static_cast<std::size_t>(n_blocks));
  for (std::uint64_t& size : sizes.compressed) {
    LODE_TRY(size, read_count(xml, stream));
  }
  return sizes;
}

Result<std::vector<std::byte>> inflate_blocks(const VtkXmlFile& xml, ByteStream& stream,
                                              std::uint64_t n_bytes) {
  const std::string& path = xml.file->path();
  LODE_TRY(const BlockSizes sizes, read_block_sizes(xml, stream, n_bytes));
  LODE_CHECK(check_inflated_size(path, n_bytes, stream.n_left()));
  std::vector<std::byte> bytes(static_cast<std::size_t>(n_bytes));
  std::vector<std::byte> compressed;
  std::span<std::byte> out = bytes;
  for (std::size_t i = 0; i < sizes.compressed.size(); ++i) {
    const std::uint64_t n = sizes.compressed[i];
    if (n > stream.n_left())
      return fail("{}: expected a compressed block of {} bytes, but only {} follow", path, n,
                  stream.n_left());
    compressed.resize(static_cast<std::size_t>(n));
    LODE_CHECK(stream.read(compressed));
    const bool is_last = i + 1 == sizes.compressed.size();
    const auto n_out = static_cast<std::size_t>(is_last ? sizes.last : sizes.block);
    LODE_CHECK(inflate_block(compressed, path, out.first(n_out)));
    out = out.subspan(n_out);
  }
  return bytes;
}

Result<std::vector<std::byte>> decode_text(const VtkXmlFile& xml, const pugi::xml_node& array,
                                           ScalarType type, std::uint64_t n_bytes) {
  const std::string_view text = array.child_value();
  auto stream = make_memory_stream(text, xml.file->path());
  TextCursor cursor(*stream, xml.file->path());
  return read_text_samples(cursor, text.size(), type, n_bytes);
}

bool is_text(const pugi::xml_node& array) {
  return std::string_view(array.attribute("format").as_string("ascii")) == "ascii";
}

}  // namespace

Result<VtkXmlFilePtr> open_vtk_xml(const std::string& path) {
  auto xml = std::make_shared<VtkXmlFile>();
  LODE_TRY(xml->file, InputFile::open(path));
  LODE_TRY(const XmlPart part, read_xml_part(*xml->file));
  const pugi::xml_parse_result parsed = xml->document.load_buffer(
      part.text.data(), part.text.size(), pugi::parse_default, pugi::encoding_utf8);
  if (!parsed)
    return fail("{}: expected well-formed XML: {} at byte {}", path, parsed.description(),
                parsed.offset);
  if (!xml->root()) return fail("{}: expected the XML element VTKFile", path);
  LODE_CHECK(read_attributes(*xml));
  if (part.appended_tag) LODE_CHECK(find_appended(*xml, *part.appended_tag));
  return VtkXmlFilePtr(std::move(xml));
}

ByteOrder byte_order_of(const VtkXmlFile& xml, const pugi::xml_node& array) {
  return is_text(array) ? native_byte_order() : xml.byte_order;
}

Result<std::unique_ptr<SampleStore>> load_vtk_xml_array(const VtkXmlFile& xml,
                                                        const pugi::xml_node& array,
                                                        ScalarType type, std::uint64_t n_bytes) {
  const std::string& path = xml.file->path();
  if (is_text(array)) {
    LODE_TRY(std::vector<std::byte> bytes, decode_text(xml, array, type, n_bytes));
    return make_memory_store(std::move(bytes));
  }
  std::string text;
  LODE_TRY(const std::unique_ptr<ByteStream> stream, encoded_stream(xml, array, text));
  if (xml.is_compressed) {
    LODE_TRY(std::vector<std::byte> bytes, inflate_blocks(xml, *stream, n_bytes));
    return make_memory_store(std::move(bytes));
  }
  LODE_TRY(const std::uint64_t n_given, read_count(xml, *stream));
  if (n_given != n_bytes || n_bytes > stream->n_left())
    return fail("{}: expected an array of {} bytes, got one of {} ({} follow)", path, n_bytes,
                n_given, stream->n_left());
  const bool is_appended = std::string_view(array.attribute("format").as_string()) == "appended";
  if (is_appended && xml.appended == VtkXmlFile::Appended::raw)
    return make_file_store(xml.file, xml.file->size() - stream->n_left(), n_bytes);
  std::vector<std::byte> bytes(static_cast<std::size_t>(n_bytes));
  LODE_CHECK(stream->read(bytes));
  return make_memory_store(std::move(bytes));
}

}  // namespace lode::io
