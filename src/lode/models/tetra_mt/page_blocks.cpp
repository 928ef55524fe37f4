#include "lode/models/tetra_mt/page_blocks.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>

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

std::vector<std::byte> encode_field(const PageContent& content, std::size_t field,
                                    const PageShape& shape) {
  std::vector<double> values;
  std::vector<std::uint16_t> errors;
  std::vector<std::uint16_t> lows;
  std::vector<std::uint16_t> widths;
  for (std::size_t at = field; at < content.values.size(); at += shape.n_fields) {
    const FactCodes& codes = content.facts[at];
    values.push_back(content.values[at]);
    errors.push_back(codes.error);
    lows.push_back(codes.low);
    widths.push_back(static_cast<std::uint16_t>(codes.high - codes.low));
  }
  StreamWriter out;
  write_numbers(values, 1, shape.has_narrow_values, out);
  for (const auto* column : {&errors, &lows, &widths})
    out.add_planes(std::span<const std::uint16_t>(*column));
  return std::move(out).take();
}

Result<void> decode_field(std::span<const std::byte> bytes, const std::string& what,
                          std::size_t field, const PageShape& shape, PageContent& content) {
  const std::size_t n = content.values.size() / shape.n_fields;
  StreamReader in(bytes, what);
  LODE_TRY(const auto values, read_numbers(in, n, 1, shape.has_narrow_values));
  LODE_TRY(const auto errors, in.read_planes<std::uint16_t>(n));
  LODE_TRY(const auto lows, in.read_planes<std::uint16_t>(n));
  LODE_TRY(const auto widths, in.read_planes<std::uint16_t>(n));
  for (std::size_t i = 0; i < n; ++i) {
    if (lows[i] > ValueScale::kLargest || widths[i] > ValueScale::kLargest - lows[i])
      return fail("{}: expected ranges of codes up to {}, got {} and {} more", what,
                  ValueScale::kLargest, lows[i], widths[i]);
    const std::size_t at = i * shape.n_fields + field;
    content.values[at] = values[i];
    content.facts[at] = {errors[i], lows[i], static_cast<std::uint16_t>(lows[i] + widths[i])};
  }
  return in.expect_end();
}

}  // namespace lode::tetra_mt
