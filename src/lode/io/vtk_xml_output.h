#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "lode/core/regular_grid.h"
#include "lode/io/surface_output.h"

namespace lode::io {

/// One array of a VTK XML file's appended raw data: its XML and its bytes.
struct VtkXmlArray {
  std::string attributes;  ///< type, Name, NumberOfComponents.
  std::uint64_t n_bytes = 0;
};

/// What a field's array may be called: `name` with what XML does not allow replaced; "value" where
/// it is empty, or one that has a meaning in our files.
[[nodiscard]] std::string vtk_array_name(std::string_view name);

/// The head of a file up to its data set: declaration, comments and the VTKFile element.
[[nodiscard]] std::string vtk_xml_head(std::string_view type, std::string_view comment,
                                       Frame frame);

/// The array's element; `offset` moves past its data.
[[nodiscard]] std::string describe_array(const VtkXmlArray& array, std::uint64_t& offset);

/// Appends the size that comes before an array's data.
[[nodiscard]] Result<void> write_array_size(SurfaceOutput& file, const VtkXmlArray& array);

/// TimeValue of a data set's field data, as VTK's readers and ParaView know it; empty without one.
[[nodiscard]] std::string vtk_time(const std::optional<double>& time);

}  // namespace lode::io
