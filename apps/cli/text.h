#pragma once

#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

namespace lode::cli {

/// Writes to stderr; what cannot be written there is lost, as there is nowhere else to say so.
void print_error(std::string_view text);
/// Writes to stdout and flushes; on failure says so on stderr and returns false.
[[nodiscard]] bool print_output(std::string_view text);

/// 1,234,567
[[nodiscard]] std::string format_count(std::uint64_t n);
/// Up to seven significant digits: 1200 or 0.00123. Without separators, so that it may be given to
/// an option, where 1,200 is two numbers.
[[nodiscard]] std::string format_number(double value);
/// The same, with more digits where it takes them to tell a thousandth of the relief.
[[nodiscard]] std::string format_height(double value, double relief);
/// The lowest and the highest, which tells the relief: -3 to 1200.5.
[[nodiscard]] std::string format_heights(double lower, double upper);
/// A range of values, rounded outward, so that it holds them when it is given to an option.
[[nodiscard]] std::string format_range(double low, double high);
/// 512 bytes, 1.5 MB (powers of ten).
[[nodiscard]] std::string format_bytes(std::uint64_t n);
/// 0.123 s
[[nodiscard]] std::string format_seconds(double seconds);

/// Rows of text in aligned columns. A table made with headings aligns columns of numbers to the
/// right; one without is a list of labels and values, aligned to the left.
class Table {
 public:
  Table() = default;
  explicit Table(std::vector<std::string> headings) : rows_{std::move(headings)}, headed_(true) {}

  void add(std::vector<std::string> row) { rows_.push_back(std::move(row)); }
  [[nodiscard]] std::string to_string() const;

 private:
  std::vector<std::vector<std::string>> rows_;
  bool headed_ = false;
};

/// The candidate most like `word`, if one is close enough to be what was meant; else empty.
[[nodiscard]] std::string closest_to(std::string_view word,
                                     const std::vector<std::string>& candidates);

}  // namespace lode::cli
