#pragma once

#include <span>
#include <string>
#include <vector>

#include "lode/core/attribute.h"

namespace lode::io {

/// An array of a file, of one or three fields.
struct ArrayOfFields {
  static constexpr int kFirstField = -1;  ///< A mesh's, or a surface's, own values.

  std::string name;
  std::vector<int> fields;  ///< Numbers of attributes, or kFirstField.
};

/// The arrays for further fields, by their names: three that follow each other and are called
/// NAME:0, NAME:1 and NAME:2, as components of vectors are when they are read, make a vector NAME,
/// as readers expect it (NAME:xyz where something else is called NAME). The first of the three may
/// be the first field, which keeps an array of its own.
[[nodiscard]] std::vector<ArrayOfFields> arrays_of_fields(const std::string& first_field,
                                                          std::span<const std::string> names);
/// The same of what a mesh has.
[[nodiscard]] std::vector<ArrayOfFields> arrays_of_fields(const std::string& first_field,
                                                          std::span<const Attribute> attributes);

/// The values of an array's fields. `first`: of the first field.
[[nodiscard]] std::vector<std::span<const double>> fields_of(const ArrayOfFields& array,
                                                             const std::vector<double>& first,
                                                             std::span<const Attribute> attributes);
/// Whether float32 holds all of them exactly, as it does the first field or not.
[[nodiscard]] bool is_narrow(const ArrayOfFields& array, bool is_first_narrow,
                             std::span<const Attribute> attributes);

}  // namespace lode::io
