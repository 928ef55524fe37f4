#include <array>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <memory>
#include <new>

#include "lode/core/out_of_memory.h"
#include "lode/render/transfer_function.h"

namespace lode {
namespace {

constexpr std::size_t kMaxFunctionBytes = 1024 * 1024;
constexpr std::string_view kBlanks = " \t\r\f\v,;";

Result<std::string> read_function_text(const std::string& path) {
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  const std::unique_ptr<std::FILE, Close> file(std::fopen(path.c_str(), "rb"));
  if (!file) return fail("{}: cannot open: {}", path, std::strerror(errno));
  std::string text(kMaxFunctionBytes + 1, '\0');
  text.resize(std::fread(text.data(), 1, text.size(), file.get()));
  if (std::ferror(file.get()) != 0) return fail("{}: cannot read: {}", path, std::strerror(errno));
  if (text.size() > kMaxFunctionBytes)
    return fail("{}: expected a transfer function of at most {} bytes, got a larger file", path,
                kMaxFunctionBytes);
  return text;
}

/// Cuts the first word off; empty where there is none.
std::string_view take_word(std::string_view& line) {
  const std::size_t begin = line.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) return line = {};
  line.remove_prefix(begin);
  const std::string_view word = line.substr(0, line.find_first_of(kBlanks));
  line.remove_prefix(word.size());
  return word;
}

/// `where`: file and line. Nothing but blanks and a comment give no numbers.
Result<std::size_t> parse_line(std::string_view line, const std::string& where,
                               std::array<double, 5>& numbers) {
  line = line.substr(0, line.find('#'));
  std::size_t n = 0;
  for (std::string_view word = take_word(line); !word.empty(); word = take_word(line)) {
    if (n == numbers.size())
      return fail("{}: expected five numbers (value, red, green, blue, extinction), got more",
                  where);
    const char* const end = word.data() + word.size();
    const char* const begin = word.data() + (word.front() == '+' ? 1 : 0);
    const auto [rest, error] = std::from_chars(begin, end, numbers[n]);
    if (error != std::errc() || rest != end)
      return fail("{}: expected a number, got '{}'", where, word.substr(0, 40));
    ++n;
  }
  if (n != 0 && n != numbers.size())
    return fail("{}: expected five numbers (value, red, green, blue, extinction), got {}", where,
                n);
  return n;
}

}  // namespace

Result<TransferFunction> parse_transfer_function(std::string_view text, std::string_view name) {
  TransferFunction function;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::size_t length = std::min(text.find('\n'), text.size());
    std::array<double, 5> n{};
    const std::string where = fmt::format("{}: line {}", name, number);
    LODE_TRY(const std::size_t count, parse_line(text.substr(0, length), where, n));
    text.remove_prefix(std::min(length + 1, text.size()));
    if (count > 0) function.knots.push_back({n[0], {{n[1], n[2], n[3]}}, n[4]});
  }
  if (const auto status = check_transfer_function(function); !status)
    return fail("{}: {}", name, status.error().message);
  return function;
}

Result<TransferFunction> read_transfer_function(const std::string& path) try {
  LODE_TRY(const std::string text, read_function_text(path));
  return parse_transfer_function(text, path);
} catch (const std::bad_alloc&) {
  return out_of_memory("read the transfer function", path);
}

}  // namespace lode
