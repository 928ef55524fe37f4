#pragma once

#include <memory>
#include <string>

#include "lode/io/border_spool.h"
#include "lode/models/diamond/part_builder.h"

namespace lode::diamond {

/// A box of the lattice in the grid's axes.
template <int D>
IndexBox grid_box(const AxisMap<D>& axes, const LatticeBox<D>& box) {
  IndexBox result{{}, {{1, 1, 1}}};
  for (std::size_t i = 0; i < as_size(D); ++i) {
    result.lower[as_size(axes.axis[i])] = box.lower[i];
    result.upper[as_size(axes.axis[i])] = box.upper[i];
  }
  return result;
}

/// The source of a build in parts of so many chunks, with what it keeps of units that parts share
/// along axes where the source itself does not hold those units till the next part comes: in a file
/// beside `path`. Null where parts may as well read the source. Fails where there is no room for
/// that file.
template <int D>
[[nodiscard]] Result<std::unique_ptr<io::BorderSpool>> spool_borders(VolumeSource& source,
                                                                     std::int32_t chunks_per_part,
                                                                     const std::string& path);

}  // namespace lode::diamond
