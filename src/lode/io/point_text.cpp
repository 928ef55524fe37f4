#include "lode/io/point_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "lode/io/byte_stream.h"
#include "lode/io/inflate.h"
#include "lode/io/text.h"

namespace lode::io {
namespace {

/// Lines of a file, which may be compressed.
class LineReader {
 public:
  static Result<LineReader> open(const std::string& path) {
    LODE_TRY(const InputFilePtr file, InputFile::open(path));
    LineReader reader(path, file->size());
    std::unique_ptr<ByteStream> stream = make_file_stream(file, 0);
    reader.file_ = stream.get();
    if (to_lower(path).ends_with(".gz"))
      reader.inflated_ = std::make_unique<InflateStream>(std::move(stream), path);
    else
      reader.plain_ = std::move(stream);
    return reader;
  }

  /// The next one, until the call after; false at the end.
  Result<bool> next(std::string_view& line) {
    std::size_t end = 0;
    while ((end = text_.find('\n', used_)) == std::string::npos && !is_at_end_) LODE_CHECK(fill());
    if (end == std::string::npos) end = text_.size();
    if (used_ == text_.size()) return false;
    if (end - used_ > kLongestLine) return too_long();
    line = std::string_view(text_).substr(used_, end - used_);
    used_ = std::min(end + 1, text_.size());
    ++n_lines_;
    return true;
  }
  [[nodiscard]] std::uint64_t n_lines() const { return n_lines_; }
  [[nodiscard]] double share_read() const {
    return 1 - static_cast<double>(file_->n_left()) / static_cast<double>(n_bytes_);
  }

 private:
  static constexpr std::size_t kPiece = std::size_t{1} << 18;
  static constexpr std::size_t kLongestLine = std::size_t{1} << 16;

  LineReader(std::string path, std::uint64_t n_bytes) : path_(std::move(path)), n_bytes_(n_bytes) {}

  [[nodiscard]] Error too_long() const {
    return fail("{}: expected lines of text, got one of more than {} bytes in line {}", path_,
                kLongestLine, n_lines_ + 1);
  }
  Result<void> fill() {
    text_.erase(0, used_);
    used_ = 0;
    if (text_.size() > kLongestLine) return too_long();
    const std::size_t n_before = text_.size();
    text_.resize(n_before + kPiece);
    const auto rest = std::as_writable_bytes(std::span(text_).subspan(n_before));
    std::size_t n = 0;
    if (inflated_ != nullptr) {
      LODE_TRY(n, inflated_->read_some(rest));
    } else {
      n = static_cast<std::size_t>(std::min<std::uint64_t>(kPiece, plain_->n_left()));
      LODE_CHECK(plain_->read(rest.first(n)));
    }
    text_.resize(n_before + n);
    is_at_end_ = n == 0;
    return {};
  }

  std::string path_;
  std::uint64_t n_bytes_;
  std::unique_ptr<ByteStream> plain_;
  std::unique_ptr<InflateStream> inflated_;
  const ByteStream* file_ = nullptr;
  std::string text_;
  std::size_t used_ = 0;
  std::uint64_t n_lines_ = 0;
  bool is_at_end_ = false;
};

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

enum class Separator : std::uint8_t { blank, comma, semicolon };

/// Blanks beside a comma or semicolon belong to it; what is in quotes separates nothing.
Separator separator_of(std::string_view line) {
  bool is_quoted = false;
  for (const char c : line) {
    if (c == '"') is_quoted = !is_quoted;
    if (is_quoted || (c != ',' && c != ';')) continue;
    return c == ',' ? Separator::comma : Separator::semicolon;
  }
  return Separator::blank;
}

void split_columns(std::string_view line, Separator separator,
                   std::vector<std::string_view>& words) {
  words.clear();
  line = trimmed(line);
  if (line.empty()) return;
  const auto separates = [&](char c) {
    if (separator == Separator::blank) return is_blank(c);
    return c == (separator == Separator::comma ? ',' : ';');
  };
  for (;;) {
    std::size_t n = 0;
    for (bool is_quoted = false; n < line.size() && (is_quoted || !separates(line[n])); ++n)
      if (line[n] == '"') is_quoted = !is_quoted;
    words.push_back(trimmed(line.substr(0, n)));
    if (n == line.size()) return;
    line = trimmed(line.substr(n + 1));
  }
}

/// How many columns lines have, where empty ones at the end count or not.
struct ColumnCount {
  std::size_t least = 0;
  std::size_t most = std::numeric_limits<std::size_t>::max();
};

ColumnCount count_columns(const std::vector<std::string_view>& words) {
  ColumnCount count{words.size(), words.size()};
  while (count.least > 0 && words[count.least - 1].empty()) --count.least;
  return count;
}

/// A comma within digits, where something else separates columns, too: 0,5 1 2.
bool has_decimal_comma(std::string_view line) {
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  line = trimmed(line);
  if (line.find_first_of("; \t") == std::string_view::npos) return false;
  for (std::size_t i = 1; i + 1 < line.size(); ++i)
    if (line[i] == ',' && is_digit(line[i - 1]) && is_digit(line[i + 1])) return true;
  return false;
}

/// Which columns are x, y and height.
struct Columns {
  std::array<std::size_t, 3> at{0, 1, 2};
  bool has_degrees = false;  ///< x and y are longitude and latitude.
};

bool is_heading(const std::vector<std::string_view>& words) {
  if (words.empty() || words[0].empty() || to_double(words[0])) return false;
  const char first = words[0][0] == '"' && words[0].size() > 1 ? words[0][1] : words[0][0];
  return std::isalpha(static_cast<unsigned char>(first)) != 0;
}

/// The first column with one of the names, separated by blanks.
std::optional<std::size_t> find_column(const std::vector<std::string_view>& heading,
                                       std::string_view names) {
  const std::vector<std::string_view> known = split_words(names);
  for (std::size_t i = 0; i < heading.size(); ++i) {
    std::string name = to_lower(heading[i]);
    std::erase(name, '"');
    if (std::ranges::count(known, std::string_view(trimmed(name))) > 0) return i;
  }
  return std::nullopt;
}

/// Names of x and y that go together.
constexpr std::array<std::array<std::string_view, 2>, 3> kPlaceNames{
    {{"x point_x", "y point_y"},
     {"lon long lng longitude", "lat latitude"},
     {"e east easting", "n north northing"}}};
constexpr std::size_t kDegrees = 1;  ///< Which of them are.
constexpr std::string_view kHeightNames =
    "z point_z h height ele elev elevation alt altitude depth grid_code";

/// Nothing where the heading names some of the three, or none of more columns.
std::optional<Columns> columns_of(const std::vector<std::string_view>& heading) {
  const auto height = find_column(heading, kHeightNames);
  bool has_place = false;
  for (std::size_t i = 0; i < kPlaceNames.size(); ++i) {
    const auto x = find_column(heading, kPlaceNames[i][0]);
    const auto y = find_column(heading, kPlaceNames[i][1]);
    if (x && y && height) return Columns{{*x, *y, *height}, i == kDegrees};
    has_place = has_place || x || y;
  }
  if (has_place || height || heading.size() != 3) return std::nullopt;
  return Columns{};
}

/// How many decimals a number is written with, but for zeros at its end.
int n_decimals(std::string_view word) {
  const std::size_t exponent = word.find_first_of("eE");
  std::string_view digits = word.substr(0, exponent);
  const std::size_t point = digits.find('.');
  int n = 0;
  if (point != std::string_view::npos) {
    while (digits.ends_with('0')) digits.remove_suffix(1);
    n = static_cast<int>(digits.size() - point - 1);
  }
  if (exponent == std::string_view::npos) return n;
  const auto power = to_int64(word.substr(exponent + 1));
  constexpr std::int64_t kMost = 400;  // Doubles have fewer.
  return std::max(0, n - static_cast<int>(std::clamp(power.value_or(0), -kMost, kMost)));
}

class TextPointReader {
 public:
  TextPointReader(const std::string& path, const PointReadOptions& options)
      : path_(path), options_(options) {}

  Result<PointFile> read(Progress& progress) {
    LODE_TRY(LineReader lines, LineReader::open(path_));
    bool is_first = true;
    for (std::string_view line;;) {
      LODE_TRY(const bool has_line, lines.next(line));
      if (!has_line) break;
      if (lines.n_lines() == 1 && line.starts_with("\xEF\xBB\xBF")) line.remove_prefix(3);
      if (lines.n_lines() % kLinesPerReport == 0) {
        if (progress.is_cancelled()) return cancelled_error();
        progress.report("reading", lines.share_read());
      }
      const Separator separator = separator_of(line);
      split_columns(line, separator, words_);
      if (words_.empty() || words_[0].starts_with('#')) continue;
      const bool may_be_heading = std::exchange(is_first, false);
      if (may_be_heading && is_heading(words_)) {
        LODE_CHECK(take_heading(line, lines.n_lines()));
        n_columns_[static_cast<std::size_t>(separator)] = count_columns(words_);
      } else {
        LODE_CHECK(check_columns(line, separator, lines.n_lines()));
        LODE_CHECK(add_point(line, lines.n_lines()));
      }
    }
    file_.format = "text";
    // Beyond it, powers of ten are not exact.
    constexpr int kMostDecimals = 22;
    if (most_decimals_ <= kMostDecimals) file_.lattice.step = 1 / std::pow(10.0, most_decimals_);
    return std::move(file_);
  }

 private:
  static constexpr std::uint64_t kLinesPerReport = 1 << 16;

  Result<void> take_heading(std::string_view line, std::uint64_t n_line) {
    const auto found = columns_of(words_);
    if (!found) {
      std::string known;
      for (const auto& [x_names, y_names] : kPlaceNames)
        known += fmt::format("{} with {}; ", x_names, y_names);
      return fail(
          "{}: expected a heading of x, y and height in line {} (known are {}{}), or none, where "
          "the first three columns are taken; got {}",
          path_, n_line, known, kHeightNames, quoted(line));
    }
    columns_ = found->at;
    file_.has_degrees = found->has_degrees;
    return {};
  }

  /// As many as in the lines before with that separator, or the heading.
  Result<void> check_columns(std::string_view line, Separator separator, std::uint64_t n_line) {
    ColumnCount& all = n_columns_[static_cast<std::size_t>(separator)];
    const ColumnCount own = count_columns(words_);
    if (own.most < all.least || own.least > all.most)
      return fail("{}: expected {} columns, as before, in line {}, got {}: {}{}", path_, all.least,
                  n_line, own.most, quoted(line), hint(line));
    all = {std::max(all.least, own.least), std::min(all.most, own.most)};
    return {};
  }

  static const char* hint(std::string_view line) {
    return has_decimal_comma(line) ? " (decimals need a point, not a comma)" : "";
  }

  Result<void> add_point(std::string_view line, std::uint64_t n_line) {
    std::array<std::optional<double>, 3> number;
    for (std::size_t i = 0; i < 3; ++i)
      if (columns_[i] < words_.size()) number[i] = to_double(words_[columns_[i]]);
    const bool is_placed =
        number[0] && number[1] && std::isfinite(*number[0]) && std::isfinite(*number[1]);
    if (!is_placed || !number[2])
      return fail("{}: expected x, y and height in line {}, got {}{}", path_, n_line, quoted(line),
                  hint(line));
    ++file_.counts.n_in_file;
    if (!std::isfinite(*number[2]) || (options_.nodata && *number[2] == *options_.nodata)) {
      ++file_.counts.n_missing;
      return {};
    }
    for (std::size_t i = 0; i < 2; ++i)
      most_decimals_ = std::max(most_decimals_, n_decimals(words_[columns_[i]]));
    file_.points.push_back({{*number[0], *number[1], *number[2]}});
    return {};
  }

  const std::string& path_;
  const PointReadOptions& options_;
  std::array<std::size_t, 3> columns_{0, 1, 2};
  std::array<ColumnCount, 3> n_columns_;  ///< By separator.
  std::vector<std::string_view> words_;
  int most_decimals_ = 0;
  PointFile file_;
};

}  // namespace

Result<PointFile> read_point_text(const std::string& path, const PointReadOptions& options,
                                  Progress& progress) {
  return TextPointReader(path, options).read(progress);
}

}  // namespace lode::io
