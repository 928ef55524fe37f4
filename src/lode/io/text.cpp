#include "lode/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>

namespace lode::io {
namespace {

constexpr std::string_view kSpaces = " \t\r\n\v\f";

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

template <typename T>
std::optional<T> to_number(std::string_view text) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

template <typename T>
std::optional<std::vector<T>> to_numbers(std::string_view text) {
  std::vector<T> numbers;
  for (const std::string_view word : split_words(text)) {
    const auto number = to_number<T>(word);
    if (!number) return std::nullopt;
    numbers.push_back(*number);
  }
  return numbers;
}

}  // namespace

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kSpaces);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kSpaces) - first + 1);
}

std::string to_lower(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(), lower);
  return result;
}

bool equals_ignoring_case(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](char x, char y) { return lower(x) == lower(y); });
}

std::vector<std::string_view> split_words(std::string_view text) {
  std::vector<std::string_view> words;
  for (std::size_t i = text.find_first_not_of(kSpaces); i != std::string_view::npos;
       i = text.find_first_not_of(kSpaces, i)) {
    const std::size_t end = std::min(text.find_first_of(kSpaces, i), text.size());
    words.push_back(text.substr(i, end - i));
    i = end;
  }
  return words;
}

std::optional<double> to_double(std::string_view text) { return to_number<double>(text); }

std::optional<std::int64_t> to_int64(std::string_view text) {
  return to_number<std::int64_t>(text);
}

std::optional<std::uint64_t> to_uint64(std::string_view text) {
  return to_number<std::uint64_t>(text);
}

std::optional<std::vector<double>> to_doubles(std::string_view text) {
  return to_numbers<double>(text);
}

std::optional<std::vector<std::int64_t>> to_int64s(std::string_view text) {
  return to_numbers<std::int64_t>(text);
}

std::string format_bytes(std::uint64_t n) {
  constexpr std::array<std::string_view, 6> kUnits = {"kB", "MB", "GB", "TB", "PB", "EB"};
  if (n < 1000) return fmt::format("{} bytes", n);
  double value = static_cast<double>(n) / 1000;
  std::size_t unit = 0;
  // 999.5 would be written as 1e+03.
  for (; value >= 999.5 && unit + 1 < kUnits.size(); ++unit) value /= 1000;
  return fmt::format("{:.3g} {}", value, kUnits[unit]);
}

std::string in_quotes(std::string_view text) {
  constexpr std::size_t kMaxShown = 60;
  std::string result = "'";
  for (const char c : text.substr(0, kMaxShown)) result += c >= ' ' && c <= '~' ? c : '?';
  result += text.size() > kMaxShown ? "...'" : "'";
  return result;
}

}  // namespace lode::io
