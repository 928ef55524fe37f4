#pragma once

#include <string>

namespace lode {

/// What numbers of a field are counted in, as its file or its user says: any label, as "mm" and
/// "HU". Lode converts nothing; it carries them along. Empty: not known.
struct Units {
  std::string length{};  ///< Of positions, spacings and distances.
  std::string value{};   ///< Of the field's values and their errors.

  [[nodiscard]] bool is_empty() const { return length.empty() && value.empty(); }
  friend bool operator==(const Units&, const Units&) = default;
};

}  // namespace lode
