#include "lode/models/diamond/attribute_rows.h"

#include <limits>

namespace lode::diamond {

void AttributeScratch::clear(std::size_t n) {
  error.assign(n, 0);
  low.assign(n, std::numeric_limits<float>::infinity());
  high.assign(n, -std::numeric_limits<float>::infinity());
}

void AttributeScratch::join(const AttributeRow& from, std::size_t first, std::size_t n) {
  ErrorCode* const e = error.data() + first;
  float* const l = low.data() + first;
  float* const h = high.data() + first;
  for (std::size_t i = 0; i < n; ++i) e[i] = from.error[i] > e[i] ? from.error[i] : e[i];
  for (std::size_t i = 0; i < n; ++i) l[i] = from.low[i] < l[i] ? from.low[i] : l[i];
  for (std::size_t i = 0; i < n; ++i) h[i] = from.high[i] > h[i] ? from.high[i] : h[i];
}

}  // namespace lode::diamond
