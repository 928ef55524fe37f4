#include "lode/io/ascii_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include "lode/io/text.h"

namespace lode::io {
namespace {

/// Decimal digits that float32 is taken to hold.
constexpr int kFloatDigits = 7;

bool is_space(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

/// Without zeros before the first that counts, and those that end a fraction.
int n_significant(std::string_view number) {
  const std::string_view digits = number.substr(0, number.find_first_of("eE"));
  const bool is_fraction = digits.find_first_of(".,") != std::string_view::npos;
  int n = 0;
  int n_zeros = 0;
  for (const char c : digits) {
    if (!is_digit(c) || (n == 0 && c == '0')) continue;
    ++n;
    n_zeros = c == '0' ? n_zeros + 1 : 0;
  }
  return is_fraction ? n - n_zeros : n;
}

bool is_whole(std::string_view number) {
  return std::ranges::all_of(number, [](char c) { return is_digit(c) || c == '-' || c == '+'; });
}

std::optional<double> value_of(std::string_view number) {
  std::string text(number);
  std::ranges::replace(text, ',', '.');  // as GDAL does
  return to_double(text);
}

/// Words of the header, and then samples.
class Scan {
 public:
  void add(std::string_view word) {
    if (!key_.empty()) {
      if (key_ == "nodata_value") set_nodata(word);
      key_.clear();
    } else if (is_header_ && is_letter(word[0]) && !is_no_number(word)) {
      key_ = to_lower(word);
    } else {
      is_header_ = false;
      add_sample(word);
    }
  }
  /// Whether nothing more can change the type.
  [[nodiscard]] bool is_settled() const { return needs_double_; }
  [[nodiscard]] std::string type() const {
    if (needs_double_ || (is_fractional_ && needs_integer_)) return "Float64";
    return is_fractional_ ? "Float32" : "";
  }

 private:
  static bool is_no_number(std::string_view word) {
    const std::string name = to_lower(word.substr(0, 3));
    return name == "nan" || name == "inf";
  }
  static bool is_of_int32(double value) {
    return std::abs(value) <= std::numeric_limits<std::int32_t>::max();
  }
  /// For GDAL it says what samples are, too.
  void set_nodata(std::string_view word) {
    nodata_ = value_of(word);
    is_fractional_ = !is_whole(word) || !nodata_ || !is_of_int32(*nodata_);
  }
  void add_sample(std::string_view word) {
    int n_digits = 0;
    bool whole = true;
    bool has_exponent = false;
    for (const char c : word) {
      n_digits += is_digit(c) ? 1 : 0;
      whole = whole && (is_digit(c) || c == '-' || c == '+');
      has_exponent = has_exponent || c == 'e' || c == 'E';
    }
    is_fractional_ = is_fractional_ || !whole;
    if (!has_exponent && (n_digits <= kFloatDigits || n_significant(word) <= kFloatDigits)) return;
    const auto value = value_of(word);
    if (!value || !std::isfinite(*value)) return;
    const auto rounded = static_cast<float>(*value);
    if (nodata_ && (*value == *nodata_ ||
                    (stands_for_float(*nodata_) && rounded == static_cast<float>(*nodata_))))
      return;
    const bool is_beyond = !std::isfinite(rounded) ||
                           (*value != 0 && std::abs(*value) < std::numeric_limits<float>::min());
    const bool is_lost = n_significant(word) > kFloatDigits && double{rounded} != *value;
    if (whole && is_of_int32(*value))
      needs_integer_ = needs_integer_ || is_lost;
    else
      needs_double_ = needs_double_ || is_beyond || is_lost || whole;
  }

  std::string key_;
  bool is_header_ = true;
  std::optional<double> nodata_{};
  bool is_fractional_ = false;
  bool needs_integer_ = false;  ///< A whole number that int32 holds and float32 does not.
  bool needs_double_ = false;
};

bool begins_as_grid(std::string_view head) {
  constexpr std::array<std::string_view, 9> kWords{
      "ncols", "nrows", "xllcorner", "yllcorner", "xllcenter", "yllcenter", "dx", "dy", "cellsize"};
  const auto words = split_words(head);
  return !words.empty() && std::ranges::find(kWords, to_lower(words[0])) != kWords.end();
}

}  // namespace

bool stands_for_float(double nodata) {
  constexpr double kNoHeight = 1e30;
  return std::abs(nodata) > kNoHeight || double{static_cast<float>(nodata)} != nodata;
}

std::string ascii_grid_type(const std::string& path) {
  constexpr std::size_t kPiece = std::size_t{1} << 20;
  constexpr std::size_t kHead = 64;
  constexpr std::size_t kLongestWord = 128;
  std::ifstream file(path, std::ios::binary);
  std::vector<char> piece(kPiece);
  std::string begun;  // A word that the next piece goes on with.
  Scan scan;
  for (bool is_first = true; file && !scan.is_settled(); is_first = false) {
    file.read(piece.data(), static_cast<std::streamsize>(kPiece));
    const std::string_view text(piece.data(), static_cast<std::size_t>(file.gcount()));
    if (is_first && !begins_as_grid(text.substr(0, kHead))) return "";
    for (std::size_t at = 0; at < text.size() && !scan.is_settled();) {
      std::size_t end = at;
      while (end < text.size() && !is_space(text[end])) ++end;
      const std::string_view word = text.substr(at, std::min(end - at, kLongestWord));
      const bool is_cut = end == text.size() && file;
      if (is_cut || !begun.empty()) begun += word.substr(0, kLongestWord - begun.size());
      if (!is_cut && !begun.empty())
        scan.add(begun);
      else if (!is_cut && !word.empty())
        scan.add(word);
      if (!is_cut) begun.clear();
      at = end + 1;
    }
  }
  if (!begun.empty()) scan.add(begun);
  return scan.type();
}

}  // namespace lode::io
