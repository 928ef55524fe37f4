#pragma once

#include <string>
#include <vector>

#include "lode/core/result.h"
#include "lode/io/image_grid.h"

namespace lode::io {

enum class OmeAxisKind { space, time, channel };

struct OmeAxis {
  std::string name;
  OmeAxisKind kind = OmeAxisKind::space;
  std::string unit;  ///< Empty where none is given.
};

/// The finest level of a multiscale image, as OME-NGFF 0.4 (attributes of Zarr version 2) and 0.5
/// (of version 3) describe it. The coarser ones are means of it, not samples, and are not used.
struct OmeImage {
  std::string version;        ///< Empty where none is given.
  std::vector<OmeAxis> axes;  ///< Of the array: two or three of space behind all others.
  std::string array_path;     ///< Below the group, and never out of it.
  std::vector<double> scale;  ///< position = scale · index + translation, for each axis.
  std::vector<double> translation;

  [[nodiscard]] std::size_t n_leading() const;
};

/// The images that the attributes of the group in `directory` name; none where it is no OME-Zarr.
/// Fails, naming the file, on what cannot be understood.
[[nodiscard]] Result<std::vector<OmeImage>> read_ome_images(const std::string& directory);

/// The steps of a grid whose axes are those of space, the last one first; each leads along the
/// world axis that its name (x, y or z) says.
[[nodiscard]] GridSteps grid_steps(const OmeImage& image, const Index3& dims);

/// "OME-Zarr axes z, y, x in micrometer": what it says instead of a frame.
[[nodiscard]] std::string describe_axes(const OmeImage& image);

/// That of all axes in space; empty where they have none, or several.
[[nodiscard]] std::string length_unit_of(const OmeImage& image);

}  // namespace lode::io
