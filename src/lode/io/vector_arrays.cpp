#include "lode/io/vector_arrays.h"

#include <algorithm>
#include <cstddef>

namespace lode::io {
namespace {

/// NAME of NAME:0; empty where it ends otherwise.
std::string name_of_vector(const std::string& first) {
  const std::string end = ":0";
  return first.size() > end.size() && first.ends_with(end)
             ? first.substr(0, first.size() - end.size())
             : std::string();
}

}  // namespace

std::vector<ArrayOfFields> arrays_of_fields(const std::string& first_field,
                                            std::span<const std::string> names) {
  const auto is_called = [&](std::size_t i, const std::string& name) {
    return i < names.size() && names[i] == name;
  };
  /// Whether components 1 and 2, but no fourth, begin at `at`.
  const auto follow = [&](const std::string& vector, std::size_t at) {
    return !vector.empty() && is_called(at, vector + ":1") && is_called(at + 1, vector + ":2") &&
           !is_called(at + 2, vector + ":3");
  };
  const auto free_name = [&](const std::string& vector) {
    const bool is_taken = first_field == vector || std::ranges::find(names, vector) != names.end();
    return is_taken ? vector + ":xyz" : vector;
  };
  std::vector<ArrayOfFields> arrays;
  std::size_t at = 0;
  if (const std::string vector = name_of_vector(first_field); follow(vector, 0)) {
    arrays.push_back({free_name(vector), {ArrayOfFields::kFirstField, 0, 1}});
    at = 2;
  }
  while (at < names.size()) {
    const int number = static_cast<int>(at);
    const std::string vector = name_of_vector(names[at]);
    const bool is_vector = follow(vector, at + 1);
    if (is_vector)
      arrays.push_back({free_name(vector), {number, number + 1, number + 2}});
    else
      arrays.push_back({names[at], {number}});
    at += is_vector ? 3 : 1;
  }
  return arrays;
}

std::vector<ArrayOfFields> arrays_of_fields(const std::string& first_field,
                                            std::span<const Attribute> attributes) {
  std::vector<std::string> names;
  names.reserve(attributes.size());
  for (const Attribute& attribute : attributes) names.push_back(attribute.name);
  return arrays_of_fields(first_field, names);
}

std::vector<std::span<const double>> fields_of(const ArrayOfFields& array,
                                               const std::vector<double>& first,
                                               std::span<const Attribute> attributes) {
  std::vector<std::span<const double>> fields;
  for (const int field : array.fields)
    fields.emplace_back(field == ArrayOfFields::kFirstField
                            ? first
                            : attributes[static_cast<std::size_t>(field)].values);
  return fields;
}

bool is_narrow(const ArrayOfFields& array, bool is_first_narrow,
               std::span<const Attribute> attributes) {
  return std::ranges::all_of(array.fields, [&](int field) {
    return field == ArrayOfFields::kFirstField
               ? is_first_narrow
               : attributes[static_cast<std::size_t>(field)].is_narrow;
  });
}

}  // namespace lode::io
