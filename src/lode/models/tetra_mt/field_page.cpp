#include "lode/models/tetra_mt/field_page.h"

#include "lode/models/tetra_mt/bit_stream.h"

namespace lode::tetra_mt {

FieldPage::FieldPage(const FieldContent& content, bool is_narrow)
    : n_(static_cast<std::uint32_t>(content.values.size())), is_narrow_(is_narrow) {
  words_ = std::make_unique<std::uint32_t[]>(n_words());
  auto* const bytes = reinterpret_cast<std::byte*>(words_.get());
  for (std::uint32_t i = 0; i < n_; ++i) {
    if (is_narrow)
      words_[i] = std::bit_cast<std::uint32_t>(static_cast<float>(content.values[i]));
    else
      std::memcpy(bytes + sizeof(double) * i, &content.values[i], sizeof(double));
  }
  BitWriter bits;
  for (const FactCodes& codes : content.facts)
    for (const std::uint16_t code : {codes.error, codes.low, codes.high})
      bits.write(code, FactCodes::kBits);
  const std::size_t n_bytes = bits.align();
  const std::vector<std::uint8_t> packed = std::move(bits).take();
  std::memcpy(bytes + (is_narrow ? sizeof(float) : sizeof(double)) * n_, packed.data(), n_bytes);
}

/// With one behind, as facts are read 8 bytes at once.
std::size_t FieldPage::n_words() const {
  const std::size_t fact_bits = std::size_t{3} * FactCodes::kBits * n_;
  return (is_narrow_ ? 1 : 2) * std::size_t{n_} + (fact_bits + 31) / 32 + 1;
}

std::size_t FieldPage::n_bytes() const { return sizeof *this + n_words() * sizeof(std::uint32_t); }

}  // namespace lode::tetra_mt
