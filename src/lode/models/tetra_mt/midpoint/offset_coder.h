#pragma once

// How far leaves are off what their codes say, as bits: docs/format.md, section 7.

#include <bit>
#include <cmath>
#include <cstdint>
#include <string>

#include "lode/models/tetra_mt/midpoint/hierarchy.h"
#include "lode/models/tetra_mt/number_models.h"

namespace lode::tetra_mt::midpoint {

/// Codes offsets of one axis, or of values: whole numbers of so many halvings of a step.
template <typename Coder>
class OffsetCoder {
 public:
  OffsetCoder(Coder& coder, const Scale& scale, const std::string& what)
      : coder_(coder), scale_(scale), what_(what) {}

  /// In place.
  Result<void> code(double& offset) {
    const bool is_negative = std::signbit(offset);
    if (!coder_.bit(is_any_, offset != 0 || is_negative)) {
      offset = 0;
      return {};
    }
    int exponent = 0;
    auto size = static_cast<std::uint64_t>(std::ldexp(std::frexp(std::abs(offset), &exponent), 53));
    exponent -= 53;
    if (size != 0) {
      exponent += std::countr_zero(size);
      size >>= std::countr_zero(size);
    } else {
      exponent = scale_.exponent();
    }
    const int step = scale_.exponent();
    exponent = step - unfolded(halvings_.code(coder_, folded(step - exponent)));
    size = sizes_.code(coder_, size);
    if (size >= std::uint64_t{1} << 53)
      return fail("{}: expected offsets of 53 bits, got {}", what_, size);
    const bool is_below = coder_.bit(is_negative_, is_negative);
    offset = std::ldexp(static_cast<double>(size), exponent);
    if (is_below) offset = -offset;
    return check_offset(offset, scale_, what_);
  }

 private:
  Coder& coder_;
  const Scale& scale_;
  const std::string& what_;
  BitModel is_any_;
  NumberModel halvings_;
  WideModel sizes_;
  BitModel is_negative_;
};

/// Which leaves of a page are off, and by how much: `code(offset)`, in place. `given`: none for a
/// reader.
template <typename Coder, typename Offset, typename Code>
Result<void> code_offsets(Coder& coder, const PageTable& table, std::uint32_t page,
                          const LeafOffsets<Offset>* given, const Code& code,
                          LeafOffsets<Offset>& made) {
  BitModel is_off;
  if (!coder.bit(is_off, given != nullptr && given->size() > 0)) return {};
  for (std::uint32_t leaf = table.first_leaf(page); leaf < table.first_leaf(page + 1); ++leaf) {
    const Offset* const of_leaf = given != nullptr ? given->find(leaf) : nullptr;
    if (!coder.bit(is_off, of_leaf != nullptr)) continue;
    Offset offset = of_leaf != nullptr ? *of_leaf : Offset{};
    LODE_CHECK(code(offset));
    made.add(leaf, offset);
  }
  return {};
}

}  // namespace lode::tetra_mt::midpoint
