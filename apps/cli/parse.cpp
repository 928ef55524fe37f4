#include "parse.h"

#include <charconv>
#include <cmath>

namespace lode::cli {
namespace {

std::vector<std::string> split(const std::string& text, std::string_view separators) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  while (true) {
    const std::size_t end = text.find_first_of(separators, begin);
    parts.push_back(text.substr(begin, end - begin));
    if (end == std::string::npos) return parts;
    begin = end + 1;
  }
}

}  // namespace

Result<double> parse_number(std::string_view option, const std::string& text) {
  const char* begin = text.data() + (text.starts_with('+') ? 1 : 0);
  const char* end = text.data() + text.size();
  double value = 0;
  const auto [at, status] = std::from_chars(begin, end, value);
  if (status != std::errc() || at != end || !std::isfinite(value))
    return fail("{}: expected a finite number, got '{}'", option, text);
  return value;
}

Result<std::vector<double>> parse_numbers(std::string_view option, const std::string& text) {
  std::vector<double> numbers;
  for (const std::string& part : split(text, ",")) {
    LODE_TRY(const double number, parse_number(option, part));
    numbers.push_back(number);
  }
  return numbers;
}

Result<Vec3d> parse_vector(std::string_view option, const std::string& text) {
  LODE_TRY(const std::vector<double> numbers, parse_numbers(option, text));
  if (numbers.size() != 3)
    return fail("{}: expected three numbers as X,Y,Z, got '{}'", option, text);
  return Vec3d{{numbers[0], numbers[1], numbers[2]}};
}

Result<std::int64_t> parse_integer(std::string_view option, const std::string& text,
                                   std::int64_t lower, std::int64_t upper) {
  std::int64_t value = 0;
  const char* end = text.data() + text.size();
  const auto [at, status] = std::from_chars(text.data(), end, value);
  if (status != std::errc() || at != end || value < lower || value > upper)
    return fail("{}: expected a whole number from {} to {}, got '{}'", option, lower, upper, text);
  return value;
}

Result<std::uint64_t> parse_bytes(std::string_view option, const std::string& text) {
  constexpr std::string_view kSuffixes = "KMGT";
  std::uint64_t value = 0;
  const char* end = text.data() + text.size();
  const auto [at, status] = std::from_chars(text.data(), end, value);
  int shift = 0;
  bool is_valid = status == std::errc() && value > 0;
  if (is_valid && at != end) {
    const char suffix = *at >= 'a' && *at <= 'z' ? static_cast<char>(*at - 'a' + 'A') : *at;
    const std::size_t found = kSuffixes.find(suffix);
    is_valid = found != std::string_view::npos && at + 1 == end;
    shift = is_valid ? 10 * (static_cast<int>(found) + 1) : 0;
  }
  if (!is_valid || value > (std::uint64_t{1} << 62) >> shift)
    return fail("{}: expected a number of bytes such as 512M or 4G, got '{}'", option, text);
  return value << shift;
}

Result<std::vector<std::int64_t>> parse_dims(std::string_view option, const std::string& text,
                                             std::int64_t upper) {
  std::vector<std::int64_t> dims;
  for (const std::string& part : split(text, "x,")) {
    LODE_TRY(const std::int64_t n, parse_integer(option, part, 1, upper));
    dims.push_back(n);
  }
  return dims;
}

}  // namespace lode::cli
