#include "lode/store/checksum.h"

#include <xxhash.h>

namespace lode::store {

std::uint64_t checksum(std::span<const std::byte> bytes) {
  return XXH64(bytes.data(), bytes.size(), 0);
}

}  // namespace lode::store
