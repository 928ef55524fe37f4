#include "text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <iterator>
#include <numeric>

namespace lode::cli {
namespace {

/// Puts commas into the digits before the decimal point.
std::string with_separators(std::string digits) {
  const std::size_t begin = digits.starts_with('-') ? 1 : 0;
  std::size_t end = digits.find_first_not_of("0123456789", begin);
  if (end == std::string::npos) end = digits.size();
  for (std::size_t at = end; at > begin + 3; at -= 3) digits.insert(at - 3, 1, ',');
  return digits;
}

/// With so few digits that it is not `value` itself, beyond it in the direction of `sign`.
std::string format_beyond(double value, double sign) {
  constexpr int kDigits = 7;
  constexpr double kUnit = 1e-8;
  std::string text = format_number(value);
  if (!std::isfinite(value) || sign * (std::strtod(text.c_str(), nullptr) - value) >= 0)
    return text;
  // A unit of the last digit is at most ten times as much.
  text = fmt::format("{:.{}g}", value + sign * kUnit * std::abs(value), kDigits + 2);
  const bool is_beyond = sign * (std::strtod(text.c_str(), nullptr) - value) >= 0;
  return is_beyond ? text : fmt::format("{}", value);
}

/// Columns on the screen: UTF-8 continuation bytes take none.
std::size_t width_of(std::string_view text) {
  return static_cast<std::size_t>(std::ranges::count_if(
      text, [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

std::string padded(const std::string& text, std::size_t width, bool right) {
  const std::string space(width - std::min(width, width_of(text)), ' ');
  return right ? space + text : text + space;
}

bool starts_like_a_number(const std::string& text) {
  const std::size_t at = text.starts_with('-') ? 1 : 0;
  return text.empty() || (at < text.size() && text[at] >= '0' && text[at] <= '9');
}

/// Levenshtein distance with transpositions of neighbours, ignoring case.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  const auto same = [](char x, char y) {
    return std::tolower(static_cast<unsigned char>(x)) ==
           std::tolower(static_cast<unsigned char>(y));
  };
  std::vector<std::size_t> before, previous(b.size() + 1), current(b.size() + 1);
  std::iota(previous.begin(), previous.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    current[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substituted = previous[j - 1] + (same(a[i - 1], b[j - 1]) ? 0 : 1);
      current[j] = std::min({previous[j] + 1, current[j - 1] + 1, substituted});
      if (i > 1 && j > 1 && same(a[i - 1], b[j - 2]) && same(a[i - 2], b[j - 1]))
        current[j] = std::min(current[j], before[j - 2] + 1);
    }
    before = previous;
    previous = current;
  }
  return previous[b.size()];
}

}  // namespace

void print_error(std::string_view text) {
  std::fwrite(text.data(), 1, text.size(), stderr);
  std::fflush(stderr);
}

bool print_output(std::string_view text) {
  const bool is_written = std::fwrite(text.data(), 1, text.size(), stdout) == text.size();
  if (is_written && std::fflush(stdout) == 0) return true;
  print_error("lode: cannot write to standard output\n");
  return false;
}

std::string format_count(std::uint64_t n) { return with_separators(fmt::format("{}", n)); }

std::string format_number(double value) { return fmt::format("{:.7g}", value == 0 ? 0.0 : value); }

std::string format_range(double low, double high) {
  return fmt::format("{} to {}", format_beyond(low, -1), format_beyond(high, 1));
}

std::string format_height(double value, double relief) {
  constexpr double kSeven = 1e-7;
  constexpr double kShare = 1e-3;
  constexpr int kMostDecimals = 17;
  const bool is_told = std::abs(value) * kSeven <= relief * kShare;
  if (is_told || !(relief > 0) || !std::isfinite(value) || !std::isfinite(relief))
    return format_number(value);
  const double decimals =
      std::clamp(std::ceil(-std::log10(relief * kShare)), 0.0, static_cast<double>(kMostDecimals));
  return fmt::format("{:.{}f}", value, static_cast<int>(decimals));
}

std::string format_heights(double lower, double upper) {
  return fmt::format("{} to {}", format_height(lower, upper - lower),
                     format_height(upper, upper - lower));
}

std::string format_bytes(std::uint64_t n) {
  constexpr const char* kUnits[] = {"kB", "MB", "GB", "TB", "PB"};
  if (n < 1000) return fmt::format("{} bytes", n);
  double value = static_cast<double>(n) / 1000;
  std::size_t unit = 0;
  while (value >= 1000 && unit + 1 < std::size(kUnits)) {
    value /= 1000;
    ++unit;
  }
  return fmt::format("{:.3g} {}", value >= 100 ? std::floor(value) : value, kUnits[unit]);
}

std::string format_seconds(double seconds) { return fmt::format("{:.3f} s", seconds); }

std::string Table::to_string() const {
  std::vector<std::size_t> widths;
  std::vector<bool> is_number;
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    const auto& row = rows_[r];
    widths.resize(std::max(widths.size(), row.size()));
    is_number.resize(widths.size(), headed_);
    for (std::size_t i = 0; i < row.size(); ++i) {
      widths[i] = std::max(widths[i], width_of(row[i]));
      if (r > 0 && !starts_like_a_number(row[i])) is_number[i] = false;
    }
  }
  std::string text;
  for (const auto& row : rows_) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i)
      line += (i > 0 ? "  " : "") + padded(row[i], widths[i], is_number[i]);
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + '\n';
  }
  return text;
}

std::string closest_to(std::string_view word, const std::vector<std::string>& candidates) {
  std::string best;
  std::size_t best_distance = 1 + std::max<std::size_t>(1, word.size() / 3);
  for (const std::string& candidate : candidates) {
    const std::size_t distance = edit_distance(word, candidate);
    if (distance >= best_distance) continue;
    best_distance = distance;
    best = candidate;
  }
  return best;
}

}  // namespace lode::cli
