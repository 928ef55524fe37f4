#include "lode/io/mesh_numbers.h"

#include <algorithm>
#include <cstring>
#include <type_traits>
#include <utility>

#include "lode/io/text.h"

namespace lode::io {
namespace {

template <typename Stored>
Stored number_at(const MeshNumbers& numbers, std::size_t i) {
  Stored number;
  std::memcpy(&number, numbers.bytes.data() + i * sizeof(Stored), sizeof(Stored));
  return number;
}

template <typename T, typename Stored>
Result<std::vector<T>> whole_of(const MeshNumbers& numbers, const WholeRange& range) {
  std::vector<T> whole(numbers.size());
  for (std::size_t i = 0; i < whole.size(); ++i) {
    const Stored number = number_at<Stored>(numbers, i);
    if (std::cmp_less(number, range.low) || std::cmp_greater(number, range.high))
      return fail("{}: expected {} from {} to {}, got {} at place {}", range.path, range.name,
                  range.low, range.high, number, i);
    // Negative ones stay so, which the check takes for characters.
    whole[i] = static_cast<T>(number);  // NOLINT(bugprone-signed-char-misuse)
  }
  return whole;
}

}  // namespace

MeshBudget MeshBudget::of(std::uint64_t file_size, std::uint64_t memory_limit) {
  constexpr std::uint64_t kMaxRatio = 1032;
  const bool is_huge = file_size > std::numeric_limits<std::uint64_t>::max() / kMaxRatio;
  return {is_huge ? memory_limit : std::min(memory_limit, kMaxRatio * file_size)};
}

Result<void> MeshBudget::spend(const std::string& path, std::uint64_t n_bytes) {
  if (n_bytes > n_bytes_left)
    return fail(
        "{}: expected arrays within the memory limit and what the file can hold, got one of {} "
        "where "
        "{} are left",
        path, format_bytes(n_bytes), format_bytes(n_bytes_left));
  n_bytes_left -= n_bytes;
  return {};
}

Result<MeshNumbers> read_numbers(SampleStore& store, ScalarType type, ByteOrder order,
                                 std::uint64_t n) {
  MeshNumbers numbers{.type = type,
                      .bytes = std::vector<std::byte>(static_cast<std::size_t>(n) * size_of(type))};
  LODE_CHECK(store.read(0, numbers.bytes));
  to_native(numbers.bytes, type, order);
  return numbers;
}

std::vector<double> as_doubles(const MeshNumbers& numbers) {
  std::vector<double> values(numbers.size());
  visit_scalar_type(numbers.type, [&]<typename Stored>() {
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i] = static_cast<double>(number_at<Stored>(numbers, i));
  });
  return values;
}

template <typename T>
Result<std::vector<T>> as_whole(const MeshNumbers& numbers, const WholeRange& range) {
  return visit_scalar_type(numbers.type, [&]<typename Stored>() -> Result<std::vector<T>> {
    if constexpr (std::is_integral_v<Stored>)
      return whole_of<T, Stored>(numbers, range);
    else
      return fail("{}: expected {} of an integer type, got {}", range.path, range.name,
                  name_of(numbers.type));
  });
}

template Result<std::vector<std::uint8_t>> as_whole(const MeshNumbers&, const WholeRange&);
template Result<std::vector<std::uint32_t>> as_whole(const MeshNumbers&, const WholeRange&);
template Result<std::vector<std::uint64_t>> as_whole(const MeshNumbers&, const WholeRange&);
template Result<std::vector<std::int64_t>> as_whole(const MeshNumbers&, const WholeRange&);

}  // namespace lode::io
