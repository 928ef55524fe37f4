#pragma once

#include <cstdint>
#include <memory>
#include <pugixml.hpp>
#include <string>

#include "lode/core/result.h"
#include "lode/io/image.h"
#include "lode/io/input_file.h"
#include "lode/io/sample_storage.h"
#include "lode/io/vtk_xml_blocks.h"

namespace lode::io {

/// A VTK XML file, split into its XML part (parsed) and the appended data (left in the file,
/// since raw ones are not XML).
struct VtkXmlFile {
  enum class Appended { none, raw, base64 };

  InputFilePtr file;
  /// Shared by the stores that read text from it.
  std::shared_ptr<pugi::xml_document> document = std::make_shared<pugi::xml_document>();
  VtkCounts counts;            ///< Their byte order is also that of the numbers.
  bool is_compressed = false;  ///< By zlib, in blocks.
  Appended appended = Appended::none;
  std::uint64_t appended_start = 0;  ///< Right behind the underscore.

  [[nodiscard]] pugi::xml_node root() const { return document->child("VTKFile"); }
};

using VtkXmlFilePtr = std::shared_ptr<const VtkXmlFile>;

/// Reads and checks everything but the arrays' data. Fails when the XML part, which holds all but
/// appended arrays, exceeds the storage's limit and a megabyte.
[[nodiscard]] Result<VtkXmlFilePtr> open_vtk_xml(const std::string& path,
                                                 const SampleStorage& storage = {});

/// The byte order that a loaded array has: text is decoded to this machine's.
[[nodiscard]] ByteOrder byte_order_of(const VtkXmlFile& xml, const pugi::xml_node& array);

/// A DataArray, what it has to be, and where it goes.
struct VtkXmlDataArray {
  pugi::xml_node node;
  ScalarType type = ScalarType::uint8;
  std::uint64_t n_bytes = 0;
  SampleStorage storage = {};
};

/// Finds or decodes a DataArray: ascii, binary (base64) or appended. Beyond the storage's limit
/// small blocks in raw appended data are decoded whenever they are read, other encoded arrays once
/// into a spool, and text is refused.
[[nodiscard]] Result<std::unique_ptr<SampleStore>> load_vtk_xml_array(const VtkXmlFile& xml,
                                                                      const VtkXmlDataArray& array);

/// How many bytes an array takes that is binary or appended, as it says itself: for strings, whose
/// number of characters is nowhere else. Text has 0.
[[nodiscard]] Result<std::uint64_t> encoded_size(const VtkXmlFile& xml,
                                                 const pugi::xml_node& array);

}  // namespace lode::io
