#include "tolerance.h"

#include <algorithm>
#include <limits>

#include "parse.h"

namespace lode::cli {
namespace {

/// In percent; none where it is no share.
std::optional<double> percent_of(const std::string& text) {
  if (!text.ends_with('%')) return {};
  const auto percent = parse_number("", text.substr(0, text.size() - 1));
  return percent ? std::optional(*percent) : std::nullopt;
}

}  // namespace

Result<double> parse_tolerance(std::string_view option, const std::string& text) {
  const std::optional<double> percent = percent_of(text);
  const auto number = percent ? Result<double>(*percent) : parse_number(option, text);
  if (!number || *number < 0)
    return fail("{}: expected a number >= 0, or one with % of the range of values, got '{}'",
                option, text);
  return percent ? std::numeric_limits<double>::quiet_NaN() : *number;
}

bool is_share(const std::string& text) { return text.ends_with('%'); }

Result<double> parse_tolerance_or_share(std::string_view option, const std::string& text) {
  LODE_TRY(const double tolerance, parse_tolerance(option, text));
  const std::optional<double> percent = percent_of(text);
  return percent ? *percent / 100 : tolerance;
}

Result<ToleranceList> parse_tolerances(std::string_view option, const std::string& text) {
  ToleranceList list;
  std::size_t n_shares = 0;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string one = text.substr(begin, end - begin);
    LODE_TRY(const double tolerance, parse_tolerance_or_share(option, one));
    list.values.push_back(tolerance);
    n_shares += is_share(one) ? 1 : 0;
    begin = end + 1;
  }
  if (n_shares > 0 && n_shares < list.values.size())
    return fail("{}: expected all tolerances with % or none, got '{}'", option, text);
  list.are_shares = n_shares > 0;
  return list;
}

void set_share(const std::string& text, double low, double high, double& tolerance) {
  if (const auto percent = percent_of(text)) tolerance = *percent / 100 * (high - low);
}

void set_share(const std::string& text, double low, double high, std::optional<double>& tolerance) {
  if (tolerance) set_share(text, low, high, *tolerance);
}

}  // namespace lode::cli
