#pragma once

#include <cstdint>
#include <memory>
#include <pugixml.hpp>
#include <string>

#include "lode/core/result.h"
#include "lode/io/image.h"
#include "lode/io/input_file.h"

namespace lode::io {

/// A VTK XML file, split into its XML part (parsed) and the appended data (left in the file,
/// since raw ones are not XML).
struct VtkXmlFile {
  enum class Appended { none, raw, base64 };

  InputFilePtr file;
  pugi::xml_document document;
  ByteOrder byte_order = ByteOrder::little;
  std::size_t header_bytes = 4;  ///< Size of the counts before the data: UInt32 or UInt64.
  bool is_compressed = false;    ///< By zlib, in blocks.
  Appended appended = Appended::none;
  std::uint64_t appended_start = 0;  ///< Right behind the underscore.

  [[nodiscard]] pugi::xml_node root() const { return document.child("VTKFile"); }
};

using VtkXmlFilePtr = std::shared_ptr<const VtkXmlFile>;

/// Reads and checks everything but the arrays' data.
[[nodiscard]] Result<VtkXmlFilePtr> open_vtk_xml(const std::string& path);

/// The byte order that a loaded array has: text is decoded to this machine's.
[[nodiscard]] ByteOrder byte_order_of(const VtkXmlFile& xml, const pugi::xml_node& array);

/// Finds or decodes the `n_bytes` of a DataArray: ascii, binary (base64) or appended.
[[nodiscard]] Result<std::unique_ptr<SampleStore>> load_vtk_xml_array(const VtkXmlFile& xml,
                                                                      const pugi::xml_node& array,
                                                                      ScalarType type,
                                                                      std::uint64_t n_bytes);

}  // namespace lode::io
