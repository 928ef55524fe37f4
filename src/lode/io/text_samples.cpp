#include "lode/io/text_samples.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "lode/io/text.h"

namespace lode::io {
namespace {

template <typename T>
std::optional<T> to_sample(std::string_view word) {
  if constexpr (std::is_floating_point_v<T>) {
    const auto value = to_double(word);
    if (!value) return std::nullopt;
    return static_cast<T>(*value);
  } else {
    if constexpr (std::is_signed_v<T>) {
      const auto value = to_int64(word);
      if (value && *value >= std::numeric_limits<T>::min() &&
          *value <= std::numeric_limits<T>::max())
        return static_cast<T>(*value);
    } else {
      const auto value = to_uint64(word);
      if (value && *value <= std::numeric_limits<T>::max()) return static_cast<T>(*value);
    }
    // 2^digits is exact in double, where the largest integer of 64 bits would round up to it.
    const double limit = std::ldexp(1.0, std::numeric_limits<T>::digits);
    const auto real = to_double(word);
    if (!real || !(*real >= static_cast<double>(std::numeric_limits<T>::min()) && *real < limit) ||
        std::trunc(*real) != *real)
      return std::nullopt;
    return static_cast<T>(*real);
  }
}

template <typename T>
Result<void> read_samples(TextCursor& cursor, std::span<std::byte> out) {
  for (std::size_t i = 0; i < out.size(); i += sizeof(T)) {
    LODE_TRY(const std::string_view word, cursor.word());
    if (word.empty())
      return fail("{}: expected {} numbers, got only {}", cursor.path(), out.size() / sizeof(T),
                  i / sizeof(T));
    const auto sample = to_sample<T>(word);
    if (!sample)
      return fail("{}: expected a number of type {} at byte {}, got {}", cursor.path(),
                  name_of(scalar_type_of<T>), cursor.position(), in_quotes(word));
    std::memcpy(out.data() + i, &*sample, sizeof(T));
  }
  return {};
}

}  // namespace

ByteOrder native_byte_order() {
  return std::endian::native == std::endian::little ? ByteOrder::little : ByteOrder::big;
}

Result<std::vector<std::byte>> read_text_samples(TextCursor& cursor, std::uint64_t n_left,
                                                 ScalarType type, std::uint64_t n_bytes) {
  const std::uint64_t n_numbers = n_bytes / size_of(type);
  // A number takes at least a digit and, but for the last one, a separator.
  if (n_numbers > n_left / 2 + 1)
    return fail("{}: the header promises {} numbers, more than {} bytes of text can hold",
                cursor.path(), n_numbers, n_left);
  std::vector<std::byte> bytes(static_cast<std::size_t>(n_bytes));
  LODE_CHECK(visit_scalar_type(
      type, [&]<typename T>() -> Result<void> { return read_samples<T>(cursor, bytes); }));
  return bytes;
}

Result<std::unique_ptr<SampleStore>> load_text(const TextSamples& samples,
                                               const SampleStorage& storage) {
  const InputFilePtr& file = samples.file;
  LODE_CHECK(check_held(file->path(), "text", samples.n_bytes, storage));
  auto stream = make_file_stream(file, samples.offset);
  TextCursor cursor(*stream, file->path());
  LODE_TRY(std::vector<std::byte> bytes, read_text_samples(cursor, file->size_from(samples.offset),
                                                           samples.type, samples.n_bytes));
  return make_memory_store(std::move(bytes));
}

}  // namespace lode::io
