#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lode/core/result.h"

namespace lode::io {

/// Whether the value of 'data file' stands for a list of names: "LIST [subdim]", the names being
/// the lines to the header's end, or a pattern, "slice%03d.raw min max step [subdim]".
[[nodiscard]] bool is_file_list(std::string_view value);
[[nodiscard]] bool is_list_of_lines(std::string_view value);

/// The names of the data files, in the order of their samples; all hold equally many. Without
/// subdim each is a slice along the slowest axis; with subdim below the dimension each is one of so
/// many axes, with the dimension itself a slab of several slices. `lines`: those after LIST;
/// `sizes`: of the volume's axes. Fails, naming `path`, where files and sizes do not agree.
[[nodiscard]] Result<std::vector<std::string>> parse_file_list(
    const std::string& path, std::string_view value, const std::vector<std::string>& lines,
    std::span<const std::int64_t> sizes);

}  // namespace lode::io
