#pragma once

#include <cstdint>

#include "bench/papers/table.h"
#include "tests/oracles/analytic_fields.h"

namespace lode::bench {

/// Nodes and time of full resolution against what the paper's theorems 4.1 to 4.3 name: the size k
/// of the output, in triangles, and the size n of the data, in samples.
class Growth {
 public:
  Growth();

  /// 257³ samples and contours of all sizes: theorems 4.1 and 4.2.
  [[nodiscard]] Result<void> add_contours(oracles::Field field);
  /// A large contour, k = Θ(n^(2/3)), and a small one, k = Θ(1), in samples^(1/3) = 33 ... 2^i + 1
  /// up to `largest`: theorem 4.3.
  [[nodiscard]] Result<void> add_sizes(oracles::Field field, std::int32_t largest);

  [[nodiscard]] const Table& by_output() const { return by_output_; }
  [[nodiscard]] const Table& by_data() const { return by_data_; }

 private:
  Table by_output_;
  Table by_data_;
};

}  // namespace lode::bench
