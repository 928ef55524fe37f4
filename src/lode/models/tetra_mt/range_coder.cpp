// Range coding after Martin, Range encoding: an algorithm for removing redundancy from a digitised
// message (1979), with carries as bytes are written.

#include "lode/models/tetra_mt/range_coder.h"

#include <utility>

namespace lode::tetra_mt {

void RangeWriter::push_byte() {
  if (low_ >> 32 != 0)
    for (std::size_t i = bytes_.size(); i-- > 0;) {
      bytes_[i] = static_cast<std::byte>(static_cast<unsigned>(bytes_[i]) + 1);
      if (bytes_[i] != std::byte{0}) break;
    }
  low_ &= 0xFFFFFFFF;
  bytes_.push_back(static_cast<std::byte>(low_ >> 24));
  low_ = low_ << 8 & 0xFFFFFFFF;
}

/// Any number from low_ on below low_ + range_ will do: that with the most zeros at its end, which
/// are left out.
std::vector<std::byte> RangeWriter::take() && {
  int n_left = 4;
  for (int n_zeros = 32; n_zeros >= 0; n_zeros -= 8) {
    const std::uint64_t mask = (std::uint64_t{1} << n_zeros) - 1;
    const std::uint64_t end = (low_ + mask) & ~mask;
    if (end - low_ >= range_) continue;
    low_ = end;
    n_left = 4 - n_zeros / 8;
    break;
  }
  for (int i = 0; i < n_left; ++i) push_byte();
  // The carry of a number that has no bytes of its own.
  if (n_left == 0 && low_ >> 32 != 0) {
    push_byte();
    bytes_.pop_back();
  }
  return std::move(bytes_);
}

RangeReader::RangeReader(std::span<const std::byte> bytes) : bytes_(bytes) {
  for (std::size_t i = 0; i < sizeof code_; ++i) code_ = code_ << 8 | next_byte();
}

}  // namespace lode::tetra_mt
