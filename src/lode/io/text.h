#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace lode::io {

/// Small text helpers of the header parsers. Whitespace is ASCII; letters fold as ASCII.
[[nodiscard]] std::string_view trimmed(std::string_view text);
[[nodiscard]] std::string to_lower(std::string_view text);
[[nodiscard]] bool equals_ignoring_case(std::string_view a, std::string_view b);
[[nodiscard]] std::vector<std::string_view> split_words(std::string_view text);

/// The whole of `text` (a leading + allowed) as a number, else nothing.
[[nodiscard]] std::optional<double> to_double(std::string_view text);
[[nodiscard]] std::optional<std::int64_t> to_int64(std::string_view text);
[[nodiscard]] std::optional<std::uint64_t> to_uint64(std::string_view text);

/// All words of `text` as numbers, else nothing.
[[nodiscard]] std::optional<std::vector<double>> to_doubles(std::string_view text);
[[nodiscard]] std::optional<std::vector<std::int64_t>> to_int64s(std::string_view text);

/// "48 bytes", "512 MB", "12.4 GB": three digits, units of 1000.
[[nodiscard]] std::string format_bytes(std::uint64_t n);

/// `text` in quotes, fit for a message: unprintable bytes replaced, cut after 60.
[[nodiscard]] std::string in_quotes(std::string_view text);
/// The same under a shorter name. One overload for each kind of string, because argument-dependent
/// lookup also finds the std::quoted templates where <iomanip> is included; exact matches win.
[[nodiscard]] inline std::string quoted(std::string_view text) { return in_quotes(text); }
[[nodiscard]] inline std::string quoted(const std::string& text) { return in_quotes(text); }
[[nodiscard]] inline std::string quoted(std::string& text) { return in_quotes(text); }
[[nodiscard]] inline std::string quoted(const char* text) { return in_quotes(text); }

}  // namespace lode::io
