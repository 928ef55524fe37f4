#pragma once

#include <string>

#include "lode/io/point_file.h"

namespace lode::io {

/// Reads scattered points: LAS 1.0 to 1.4 (see point_las.h) and text (see point_text.h), perhaps
/// compressed by gzip. Fails, naming the file and where in it, on what is missing, truncated or no
/// such file, on classes of what has none, and where no point is left.
[[nodiscard]] Result<PointFile> read_points(const std::string& path,
                                            const PointReadOptions& options, Progress& progress);

/// Whether the name is that of scattered points: .las, .laz (which is refused, with a reason),
/// .csv, .txt, .xyz, or one of these three with .gz (any case). A .xyz file that is no text, or
/// beside a .q of the same name, is taken for a grid of PLOT3D, and is none.
[[nodiscard]] bool is_point_path(const std::string& path);

}  // namespace lode::io
