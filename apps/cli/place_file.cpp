#include "place_file.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <fstream>
#include <system_error>

#include "parse.h"

namespace lode::cli {
namespace {

bool is_separator(char c) { return c == ',' || c == ';' || c == '\t' || c == ' ' || c == '\r'; }

/// Calls visit(word) for what is between separators; two commas have an empty word between them.
std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> words;
  const auto is_blank = [](char c) { return c == ' ' || c == '\r' || c == '\t'; };
  while (!line.empty() && is_blank(line.back())) line.remove_suffix(1);
  while (!line.empty() && is_blank(line.front())) line.remove_prefix(1);
  while (!line.empty()) {
    const auto end =
        static_cast<std::size_t>(std::ranges::find_if(line, is_separator) - line.begin());
    words.push_back(line.substr(0, end));
    line.remove_prefix(end);
    // One comma or semicolon, with blanks round it.
    bool has_separator = false;
    while (!line.empty() && is_separator(line.front())) {
      const bool is_mark = !is_blank(line.front());
      if (is_mark && has_separator) break;
      has_separator = has_separator || is_mark;
      line.remove_prefix(1);
    }
    if (line.empty() && has_separator) words.emplace_back();
  }
  return words;
}

std::string lowered(std::string_view word) {
  std::string text;
  for (const char c : word)
    if (c != '"') text += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

/// Which columns are x and y.
struct Columns {
  std::size_t x = 0;
  std::size_t y = 1;
  bool has_heading = false;
};

/// A word that does not begin as numbers do.
bool is_heading(const std::vector<std::string_view>& words) {
  const std::string first = words.empty() ? "" : lowered(words[0]);
  return !first.empty() && std::isalpha(static_cast<unsigned char>(first[0])) != 0 &&
         first != "nan" && !first.starts_with("inf");
}

Columns columns_of(const std::vector<std::string_view>& heading) {
  Columns columns{.has_heading = true};
  const auto find = [&](std::initializer_list<std::string_view> names, std::size_t& column) {
    for (std::size_t i = 0; i < heading.size(); ++i)
      if (std::ranges::count(names, lowered(heading[i])) > 0) {
        column = i;
        return true;
      }
    return false;
  };
  Columns named = columns;
  const bool has_x = find({"x", "lon", "long", "longitude", "easting"}, named.x);
  const bool has_y = find({"y", "lat", "latitude", "northing"}, named.y);
  return has_x && has_y ? named : columns;
}

Result<Place> place_in(const std::vector<std::string_view>& words, const Columns& columns,
                       const std::string& path, std::size_t n_lines, std::string_view line) {
  const auto refuse = [&] {
    return fail("{}: expected two finite numbers as x,y in line {}, got '{}'", path, n_lines,
                line.substr(0, 80));
  };
  if (words.size() <= std::max(columns.x, columns.y) || (!columns.has_heading && words.size() != 2))
    return refuse();
  const auto x = parse_number("", std::string(words[columns.x]));
  const auto y = parse_number("", std::string(words[columns.y]));
  if (!x || !y) return refuse();
  return Place{{*x, *y}};
}

}  // namespace

Result<std::vector<Place>> read_places(const std::string& path) {
  std::ifstream file(path);
  if (!file) {
    const std::error_code reason(errno, std::generic_category());
    return fail("{}: expected a file of places that can be read, got: {}", path, reason.message());
  }
  std::vector<Place> places;
  Columns columns;
  std::string line;
  std::size_t n_lines = 0;
  for (bool is_first = true; std::getline(file, line);) {
    ++n_lines;
    std::string_view text = line;
    if (n_lines == 1 && text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
    const std::vector<std::string_view> words = words_of(text);
    if (words.empty() || words[0].starts_with('#')) continue;
    if (is_first && is_heading(words)) {
      columns = columns_of(words);
    } else {
      LODE_TRY(const Place place, place_in(words, columns, path, n_lines, text));
      places.push_back(place);
    }
    is_first = false;
  }
  if (file.bad()) return fail("{}: could not be read to its end", path);
  if (places.empty()) return fail("{}: expected places as x,y, got none", path);
  return places;
}

}  // namespace lode::cli
