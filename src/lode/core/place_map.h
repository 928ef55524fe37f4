#pragma once

#include <memory>
#include <span>

#include "lode/core/vec.h"

namespace lode {

/// A way from places of one CRS to those of another. Const members are safe from many threads, one
/// at a time.
class PlaceMap {
 public:
  virtual ~PlaceMap() = default;
  /// Maps places, x and y, each on its own, whatever is mapped with it; where there is none in the
  /// other CRS both are not numbers.
  virtual void apply(std::span<Vec<double, 2>> places) const = 0;
  /// Another one that does the same, for another thread to be in no one's way.
  [[nodiscard]] virtual std::unique_ptr<const PlaceMap> copy() const = 0;

 protected:
  PlaceMap() = default;
  PlaceMap(const PlaceMap&) = default;
  PlaceMap& operator=(const PlaceMap&) = default;
};

}  // namespace lode
