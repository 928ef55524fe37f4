#include "lode/io/nrrd_files.h"

#include <algorithm>
#include <optional>

#include "lode/io/text.h"

namespace lode::io {
namespace {

/// More than slices of any scan, and few enough for a forged header.
constexpr std::int64_t kMaxFiles = 1 << 16;

/// "%d", "%3d" or "%03d" within a name.
struct Conversion {
  std::size_t begin = 0;
  std::size_t end = 0;
  int width = 0;
  bool has_zeros = false;
};

std::optional<Conversion> find_conversion(std::string_view name) {
  const std::size_t begin = name.find('%');
  if (begin == std::string_view::npos) return std::nullopt;
  const std::size_t letter = name.find_first_not_of("0123456789", begin + 1);
  constexpr std::size_t kMaxDigits = 3;
  if (letter == std::string_view::npos || name[letter] != 'd' || letter - begin - 1 > kMaxDigits ||
      name.find('%', letter) != std::string_view::npos)
    return std::nullopt;
  const std::string_view digits = name.substr(begin + 1, letter - begin - 1);
  return Conversion{.begin = begin,
                    .end = letter + 1,
                    .width = static_cast<int>(to_int64(digits).value_or(0)),
                    .has_zeros = digits.starts_with('0')};
}

struct FileList {
  std::vector<std::string> names;
  std::optional<std::int64_t> subdim;
};

Result<FileList> expand_pattern(const std::string& path, std::string_view value) {
  const auto words = split_words(value);
  const auto conversion = find_conversion(words.front());
  const auto numbers = to_int64s(value.substr(value.find(words.front()) + words.front().size()));
  constexpr std::int64_t kLimit = std::int64_t{1} << 40;
  const bool is_sound =
      conversion && numbers && (numbers->size() == 3 || numbers->size() == 4) &&
      std::ranges::all_of(*numbers, [](std::int64_t n) { return -kLimit < n && n < kLimit; });
  const std::int64_t step = is_sound ? (*numbers)[2] : 0;
  const std::int64_t reach = is_sound ? (*numbers)[1] - (*numbers)[0] : 0;
  if (step == 0 || (reach != 0 && (reach < 0) != (step < 0)))
    return fail("{}: expected 'data file' as in 'slice%03d.raw 1 9 1', got {}", path,
                in_quotes(value));
  const std::int64_t n = reach / step + 1;
  if (n > kMaxFiles) return fail("{}: expected at most {} data files, got {}", path, kMaxFiles, n);
  FileList list;
  for (std::int64_t i = 0; i < n; ++i) {
    const std::int64_t number = (*numbers)[0] + i * step;
    std::string name(words.front());
    name.replace(conversion->begin, conversion->end - conversion->begin,
                 conversion->has_zeros ? fmt::format("{:0{}}", number, conversion->width)
                                       : fmt::format("{:{}}", number, conversion->width));
    list.names.push_back(std::move(name));
  }
  if (numbers->size() == 4) list.subdim = (*numbers)[3];
  return list;
}

Result<FileList> take_lines(const std::string& path, std::string_view value,
                            const std::vector<std::string>& lines) {
  FileList list{.names = lines, .subdim = {}};
  const auto words = split_words(value);
  if (words.size() == 1) return list;
  list.subdim = to_int64(words[1]);
  if (words.size() == 2 && list.subdim) return list;
  return fail("{}: expected 'data file: LIST' or 'data file: LIST subdim', got {}", path,
              in_quotes(value));
}

}  // namespace

bool is_list_of_lines(std::string_view value) {
  const auto words = split_words(value);
  return !words.empty() && words.front() == "LIST";
}

bool is_file_list(std::string_view value) {
  return is_list_of_lines(value) || value.find('%') != std::string_view::npos;
}

Result<std::vector<std::string>> parse_file_list(const std::string& path, std::string_view value,
                                                 const std::vector<std::string>& lines,
                                                 std::span<const std::int64_t> sizes) {
  LODE_TRY(FileList list,
           is_list_of_lines(value) ? take_lines(path, value, lines) : expand_pattern(path, value));
  const auto n_axes = static_cast<std::int64_t>(sizes.size());
  const std::int64_t subdim = list.subdim.value_or(n_axes - 1);
  if (subdim < (list.subdim ? 1 : 0) || subdim > n_axes)
    return fail("{}: expected data files of 1 to {} axes, got {}", path, n_axes, subdim);
  const auto n_files = static_cast<std::int64_t>(list.names.size());
  std::int64_t n_expected = 1;  // the product of all sizes is known to fit
  for (const std::int64_t size : sizes.subspan(static_cast<std::size_t>(subdim)))
    n_expected *= size;
  if (subdim < n_axes && n_files != n_expected)
    return fail("{}: expected {} data files for the sizes, got {}", path, n_expected, n_files);
  if (subdim == n_axes && (n_files == 0 || sizes.back() % n_files != 0))
    return fail("{}: expected data files that divide {} slices evenly, got {} files", path,
                sizes.back(), n_files);
  return std::move(list.names);
}

}  // namespace lode::io
