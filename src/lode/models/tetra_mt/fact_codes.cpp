#include "lode/models/tetra_mt/fact_codes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace lode::tetra_mt {
namespace {

float next_up(double x) {
  return std::nextafter(static_cast<float>(x), std::numeric_limits<float>::infinity());
}

}  // namespace

ValueScale::ValueScale(const Knots& knots) : knots_(knots) {
  constexpr int kOctaves = 31;
  int exponent = 0;
  std::frexp(knots.back() - knots.front(), &exponent);
  // Floats hold all of them.
  error_unit_ = std::ldexp(1.0, std::clamp(exponent, -90, 126) - kOctaves);
}

ValueScale ValueScale::of(std::span<const double> values) {
  constexpr std::size_t kSeen = std::size_t{1} << 16;
  if (values.empty()) return {};
  std::vector<double> seen;
  const std::size_t stride = values.size() / kSeen + 1;
  for (std::size_t i = 0; i < values.size(); i += stride) seen.push_back(values[i]);
  std::ranges::sort(seen);
  Knots knots;
  for (std::size_t i = 0; i < kKnots; ++i) knots[i] = seen[i * (seen.size() - 1) / (kKnots - 1)];
  const auto [low, high] = std::ranges::minmax(values);
  knots.front() = low;
  knots.back() = high;
  return ValueScale(knots);
}

std::uint16_t ValueScale::code_below(double value_seen) const {
  std::uint32_t low = 0;
  std::uint32_t high = kLargest + 1U;
  while (low + 1 < high) {
    const std::uint32_t middle = (low + high) / 2;
    (value(static_cast<std::uint16_t>(middle)) <= value_seen ? low : high) = middle;
  }
  return static_cast<std::uint16_t>(low);
}

std::uint16_t ValueScale::code_above(double value_seen) const {
  std::uint32_t low = 0;
  std::uint32_t high = kLargest;
  while (low < high) {
    const std::uint32_t middle = (low + high) / 2;
    if (value(static_cast<std::uint16_t>(middle)) >= value_seen)
      high = middle;
    else
      low = middle + 1;
  }
  return static_cast<std::uint16_t>(low);
}

std::uint16_t ValueScale::error_code(float error_seen) const {
  std::uint32_t low = 0;
  std::uint32_t high = kLargestError;
  while (low < high) {
    const std::uint32_t middle = (low + high) / 2;
    if (error(static_cast<std::uint16_t>(middle)) >= error_seen)
      high = middle;
    else
      low = middle + 1;
  }
  return static_cast<std::uint16_t>(low);
}

StoredFacts to_facts(const FactCodes& codes, const ValueScale& scale) {
  const double reference = scale.knots()[0];
  StoredFacts facts{.error = scale.error(codes.error)};
  facts.low = -next_up(reference - scale.value(codes.low));
  facts.high = next_up(scale.value(codes.high) - reference);
  return facts;
}

FactCodes to_codes(const StoredFacts& facts, double range_reference, const ValueScale& scale) {
  const NodeFacts known = without_bounds(facts, range_reference);
  const auto& knots = scale.knots();
  const auto low = scale.code_below(std::clamp(known.range.low, knots.front(), knots.back()));
  const auto high = scale.code_above(std::clamp(known.range.high, knots.front(), knots.back()));
  // Of a value that several codes stand for, the last one is below and the first one above it.
  return {scale.error_code(facts.error), std::min(low, high), high};
}

}  // namespace lode::tetra_mt
