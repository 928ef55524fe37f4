#include "lode/store/block_index.h"

#include <algorithm>
#include <cstring>

#include "lode/store/bytes.h"
#include "lode/store/checksum.h"
#include "lode/store/codec.h"

namespace lode::store {
namespace {

constexpr std::size_t kSumOffset = kIndexHeadBytes - sizeof(std::uint64_t);

}  // namespace

std::vector<std::byte> encode_index(std::span<const std::byte> run, std::uint64_t offset) {
  const std::vector<std::byte> stored = zstd_compress(run);
  ByteWriter out;
  out.write_bytes(std::as_bytes(std::span(kIndexMark)));
  out.write(offset);
  out.write(static_cast<std::uint64_t>(stored.size()));
  out.write(static_cast<std::uint64_t>(run.size()));
  out.write(checksum(stored));
  out.write(checksum(out.bytes()));
  out.write_bytes(stored);
  return std::move(out).take();
}

std::optional<IndexHead> decode_index_head(std::span<const std::byte> bytes) {
  LODE_EXPECTS(bytes.size() == kIndexHeadBytes);
  const auto mark = std::as_bytes(std::span(kIndexMark));
  if (!std::ranges::equal(bytes.first(mark.size()), mark)) return std::nullopt;
  std::array<std::uint64_t, 5> numbers{};
  std::memcpy(numbers.data(), bytes.data() + mark.size(), sizeof(numbers));
  const auto [offset, stored_size, raw_size, sum_of_frame, sum] = numbers;
  if (sum != checksum(bytes.first(kSumOffset))) return std::nullopt;
  return IndexHead{offset, stored_size, raw_size, sum_of_frame};
}

}  // namespace lode::store
