#include "missing.h"

#include <algorithm>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>

namespace lode::raster_import {
namespace {

/// A number of an attribute, or none where T cannot be it: no sample is.
template <typename T>
std::optional<T> to_sample(double number) {
  if constexpr (std::is_floating_point_v<T>) {
    return static_cast<T>(number);
  } else {
    if (number != std::floor(number)) return {};
    const auto lowest = static_cast<double>(std::numeric_limits<T>::lowest());
    const double end = std::ldexp(1.0, std::numeric_limits<T>::digits);
    if (number >= lowest && number < end) return static_cast<T>(number);
    return {};
  }
}

/// As they are stored: doubles would not hold all 64-bit integers.
template <typename T>
std::vector<T> samples_attribute(const Variable& variable, const char* name) {
  const std::vector<double> numbers = numbers_attribute(variable.group, variable.id, name);
  std::vector<T> samples;
  const AttributeShape shape = attribute_shape(variable.group, variable.id, name);
  const bool is_of_integers = shape.type != NC_FLOAT && shape.type != NC_DOUBLE;
  if constexpr (std::is_integral_v<T>) {
    if (is_of_integers && !numbers.empty()) {
      std::vector<long long> whole(shape.n);
      std::vector<unsigned long long> large(shape.n);
      const std::string what = std::string("the attribute ") + name;
      const bool is_large = shape.type == NC_UINT64;
      check(is_large ? nc_get_att_ulonglong(variable.group, variable.id, name, large.data())
                     : nc_get_att_longlong(variable.group, variable.id, name, whole.data()),
            what);
      // Of integers that are to be taken as unsigned ones, -1 is the largest.
      for (std::size_t i = 0; i < shape.n; ++i) {
        const T one = is_large ? static_cast<T>(large[i]) : static_cast<T>(whole[i]);
        const bool is_same =
            is_large ? std::cmp_equal(one, large[i]) : std::cmp_equal(one, whole[i]);
        if (is_same || (is_marked_unsigned(variable) && shape.type == variable.type))
          samples.push_back(one);
      }
      return samples;
    }
  }
  for (const double number : numbers)
    if (const std::optional<T> sample = to_sample<T>(number)) samples.push_back(*sample);
  return samples;
}

/// What libnetcdf fills variables of a type with.
template <typename T>
std::optional<T> usual_fill() {
  if constexpr (sizeof(T) == 1) return {};
  if constexpr (std::is_same_v<T, std::int16_t>) return NC_FILL_SHORT;
  if constexpr (std::is_same_v<T, std::uint16_t>) return NC_FILL_USHORT;
  if constexpr (std::is_same_v<T, std::int32_t>) return NC_FILL_INT;
  if constexpr (std::is_same_v<T, std::uint32_t>) return NC_FILL_UINT;
  if constexpr (std::is_same_v<T, std::int64_t>) return NC_FILL_INT64;
  if constexpr (std::is_same_v<T, std::uint64_t>) return NC_FILL_UINT64;
  if constexpr (std::is_same_v<T, float>) return NC_FILL_FLOAT;
  if constexpr (std::is_same_v<T, double>) return NC_FILL_DOUBLE;
  return {};
}

bool is_filled(const Variable& variable) {
  int is_left = 0;
  check(nc_inq_var_fill(variable.group, variable.id, &is_left, nullptr), "a fill value");
  return is_left == 0;
}

/// A bound of heights, or of what is stored, as a stored number: what was one before it was written
/// in another type is that again.
template <typename T>
double stored_bound(double bound, const Packing& packing) {
  const double stored = (bound - packing.offset) / packing.scale;
  if constexpr (std::is_same_v<T, float>) return static_cast<double>(static_cast<float>(stored));
  const double whole = std::round(stored);
  constexpr double kOff = 1e-6;
  const bool is_whole =
      std::is_integral_v<T> && std::abs(stored - whole) <= kOff * std::max(1.0, std::abs(whole));
  return is_whole ? whole : stored;
}

template <typename T>
void set_range(const Variable& variable, Missing<T>& missing) {
  const char* const names[] = {"valid_range", "valid_min", "valid_max"};
  for (const char* name : names) {
    std::vector<double> numbers = numbers_attribute(variable.group, variable.id, name);
    if (numbers.empty()) continue;
    const nc_type type = attribute_shape(variable.group, variable.id, name).type;
    if (is_marked_unsigned(variable) && type == variable.type)
      for (double& number : numbers)
        if (number < 0) number += std::ldexp(1.0, std::numeric_limits<T>::digits);
    const bool is_range = name == names[0];
    if (is_range && numbers.size() != 2)
      throw std::runtime_error("expected two numbers in the attribute valid_range, got " +
                               std::to_string(numbers.size()));
    // Of heights where they are written as these and not as what is stored.
    const bool is_of_heights = type != variable.type && (type == NC_FLOAT || type == NC_DOUBLE);
    const Packing packing = is_of_heights ? read_packing(variable) : Packing{};
    std::optional<double>* least = &missing.least;
    std::optional<double>* most = &missing.most;
    if (packing.scale < 0) std::swap(least, most);
    if (name != names[2]) *least = stored_bound<T>(numbers.front(), packing);
    if (name != names[1]) *most = stored_bound<T>(numbers.back(), packing);
  }
}

/// A number that is out of the range.
template <typename T>
std::optional<T> outside_of(const Missing<T>& missing) {
  for (const T one : {std::numeric_limits<T>::lowest(), std::numeric_limits<T>::max()})
    if (missing.is_other(one)) return one;
  return {};
}

double number_or(const Variable& variable, const char* name, double otherwise) {
  const std::vector<double> numbers = numbers_attribute(variable.group, variable.id, name);
  return numbers.empty() ? otherwise : numbers.front();
}

}  // namespace

Packing read_packing(const Variable& variable) {
  return {number_or(variable, "scale_factor", 1), number_or(variable, "add_offset", 0)};
}

bool is_marked_unsigned(const Variable& variable) {
  const std::string text = text_attribute(variable.group, variable.id, "_Unsigned");
  return text == "true" || text == "True";
}

template <typename T>
Missing<T> read_missing(const Variable& variable) {
  Missing<T> missing;
  std::vector<T> all = samples_attribute<T>(variable, "_FillValue");
  const bool says_fill = attribute_shape(variable.group, variable.id, "_FillValue").type != NC_NAT;
  for (const T one : samples_attribute<T>(variable, "missing_value")) all.push_back(one);
  if (!says_fill && is_filled(variable))
    if (const std::optional<T> usual = usual_fill<T>()) all.push_back(*usual);
  set_range(variable, missing);
  if (all.empty() && !missing.is_plain()) missing.nodata = outside_of(missing);
  if (all.empty()) return missing;
  missing.nodata = all.front();
  for (const T one : all)
    if (one != all.front() && !(one != one)) missing.others.push_back(one);
  return missing;
}

template Missing<std::int8_t> read_missing(const Variable&);
template Missing<std::uint8_t> read_missing(const Variable&);
template Missing<std::int16_t> read_missing(const Variable&);
template Missing<std::uint16_t> read_missing(const Variable&);
template Missing<std::int32_t> read_missing(const Variable&);
template Missing<std::uint32_t> read_missing(const Variable&);
template Missing<std::int64_t> read_missing(const Variable&);
template Missing<std::uint64_t> read_missing(const Variable&);
template Missing<float> read_missing(const Variable&);
template Missing<double> read_missing(const Variable&);

}  // namespace lode::raster_import
