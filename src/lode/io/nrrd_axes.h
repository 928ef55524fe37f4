#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "lode/core/result.h"
#include "lode/io/image.h"

namespace lode::io {

/// The fields of a NRRD header by canonical name (lower case, single words spelt as in the
/// standard: "space directions", "data file", ...).
using NrrdFields = std::map<std::string, std::string>;

/// What the per-axis fields of a NRRD header say.
struct NrrdAxes {
  RegularGrid grid;
  SampleLayout layout;  ///< Byte order not yet set.
  std::string frame_note;
  std::string length_unit;  ///< Empty: none, or several, which the note tells.
};

/// Sorts the axes into up to three of space, one of components and one of time: by their kinds,
/// else by "none" among the space directions, else the first three are space and a fourth is
/// time.
[[nodiscard]] Result<NrrdAxes> parse_nrrd_axes(const std::string& path, const NrrdFields& fields,
                                               ScalarType type);

}  // namespace lode::io
