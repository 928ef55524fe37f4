#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "lode/api/dataset.h"

namespace lode::cli {

/// Every parser names the option in its message; numbers never depend on the locale.

/// A finite number: NaN and infinities are refused.
[[nodiscard]] Result<double> parse_number(std::string_view option, const std::string& text);
/// Finite numbers separated by commas.
[[nodiscard]] Result<std::vector<double>> parse_numbers(std::string_view option,
                                                        const std::string& text);
/// Exactly three finite numbers separated by commas.
[[nodiscard]] Result<Vec3d> parse_vector(std::string_view option, const std::string& text);
/// A whole number in [lower, upper].
[[nodiscard]] Result<std::int64_t> parse_integer(std::string_view option, const std::string& text,
                                                 std::int64_t lower, std::int64_t upper);
/// A number of bytes > 0, with an optional suffix K, M, G or T for powers of 1024: 512M.
[[nodiscard]] Result<std::uint64_t> parse_bytes(std::string_view option, const std::string& text);
/// Whole numbers in [1, upper] separated by 'x' or commas: 256x256x128.
[[nodiscard]] Result<std::vector<std::int64_t>> parse_dims(std::string_view option,
                                                           const std::string& text,
                                                           std::int64_t upper);
}  // namespace lode::cli
