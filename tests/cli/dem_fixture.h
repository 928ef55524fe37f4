#pragma once

#include <cmath>
#include <fstream>
#include <string>

namespace lode::test {

/// 40 x 30 heights in ESRI ASCII, one of them missing.
inline void write_dem(const std::string& path, int n_columns = 40, int n_rows = 30) {
  std::ofstream file(path);
  file << "ncols " << n_columns << "\nnrows " << n_rows
       << "\nxllcorner 500000\nyllcorner 4000000\ncellsize 30\nnodata_value -9999\n";
  for (int y = 0; y < n_rows; ++y)
    for (int x = 0; x < n_columns; ++x)
      file << (x == 7 && y == 9 ? -9999
                                : std::lround(900 + 300 * std::sin(0.2 * x) * std::cos(0.3 * y)))
           << (x + 1 < n_columns ? ' ' : '\n');
}

}  // namespace lode::test
