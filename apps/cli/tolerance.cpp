#include "tolerance.h"

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

void set_share(const std::string& text, double low, double high, double& tolerance) {
  if (const auto percent = percent_of(text)) tolerance = *percent / 100 * (high - low);
}

void set_share(const std::string& text, double low, double high, std::optional<double>& tolerance) {
  if (tolerance) set_share(text, low, high, *tolerance);
}

}  // namespace lode::cli
