#include "lode/models/tetra_mt/page_blocks.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "lode/models/tetra_mt/byte_streams.h"
#include "lode/store/elements.h"

namespace lode::tetra_mt {
namespace {

template <typename Bits, typename Number>
void write_differences(std::span<const double> numbers, std::size_t stride, StreamWriter& out) {
  std::vector<Bits> column;
  for (std::size_t first = 0; first < stride; ++first) {
    column.clear();
    Bits last = 0;
    for (std::size_t i = first; i < numbers.size(); i += stride) {
      const auto bits = std::bit_cast<Bits>(static_cast<Number>(numbers[i]));
      column.push_back(store::zigzag(static_cast<Bits>(bits - last)));
      last = bits;
    }
    out.add_planes(std::span<const Bits>(column));
  }
}

template <typename Bits, typename Number>
Result<std::vector<double>> read_differences(StreamReader& in, std::size_t n, std::size_t stride) {
  std::vector<double> numbers(n * stride);
  for (std::size_t first = 0; first < stride; ++first) {
    LODE_TRY(const auto column, in.read_planes<Bits>(n));
    Bits last = 0;
    for (std::size_t i = 0; i < n; ++i) {
      last = static_cast<Bits>(last + store::unzigzag(column[i]));
      const auto number = static_cast<double>(std::bit_cast<Number>(last));
      if (!std::isfinite(number))
        return fail("{}: expected finite numbers, got {}", in.what(), number);
      numbers[i * stride + first] = number;
    }
  }
  return numbers;
}

}  // namespace

void write_numbers(std::span<const double> numbers, std::size_t stride, bool is_narrow,
                   StreamWriter& out) {
  if (is_narrow)
    write_differences<std::uint32_t, float>(numbers, stride, out);
  else
    write_differences<std::uint64_t, double>(numbers, stride, out);
}

Result<std::vector<double>> read_numbers(StreamReader& in, std::size_t n, std::size_t stride,
                                         bool is_narrow) {
  if (is_narrow) return read_differences<std::uint32_t, float>(in, n, stride);
  return read_differences<std::uint64_t, double>(in, n, stride);
}

void write_differences_of(std::span<const std::uint32_t> numbers, StreamWriter& out) {
  std::vector<std::uint32_t> column;
  std::uint32_t last = 0;
  for (const std::uint32_t number : numbers)
    column.push_back(store::zigzag(number - std::exchange(last, number)));
  out.add_planes(std::span<const std::uint32_t>(column));
}

Result<std::vector<std::uint32_t>> read_differences_of(StreamReader& in, std::size_t n) {
  LODE_TRY(auto numbers, in.read_planes<std::uint32_t>(n));
  std::uint32_t last = 0;
  for (std::uint32_t& number : numbers) last = number = last + store::unzigzag(number);
  return numbers;
}

}  // namespace lode::tetra_mt
