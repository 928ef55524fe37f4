#include "lode/models/tetra_mt/field_page.h"

#include <utility>

#include "lode/models/tetra_mt/bit_stream.h"

namespace lode::tetra_mt {

FieldPage::FieldPage(const FieldContent& content, bool is_narrow) {
  BitWriter bits;
  for (const FactCodes& codes : content.facts)
    for (const std::uint16_t code : {codes.error, codes.low, codes.high})
      bits.write(code, FactCodes::kBits);
  const auto n = static_cast<std::uint32_t>(content.values.size());
  const auto value = [&](std::uint32_t i, std::size_t) { return content.values[i]; };
  values_at_ = static_cast<std::uint32_t>(bits.align());
  values_ = PackedNumbers<1>(n, is_narrow, value);
  values_.write(n, value, bits);
  bits_ = std::move(bits).take();
}

}  // namespace lode::tetra_mt
