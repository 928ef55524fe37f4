#pragma once

#include <string>
#include <vector>

namespace lode {

/// One more field of a mesh or surface, linear on each cell as its first one is.
struct Attribute {
  std::string name;
  bool is_narrow = false;       ///< float32 holds all values exactly.
  std::vector<double> values;   ///< Per vertex.
  double error = 0;             ///< Largest |F - F'| that a cell of the mesh states.
  std::vector<float> errors{};  ///< Per cell of the mesh: what it states; empty: not known.
};

}  // namespace lode
