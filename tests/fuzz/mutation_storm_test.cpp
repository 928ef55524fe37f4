// Kept .lode files of every model, changed again and again where no checksum sees it: what
// libFuzzer does, in any build, from the same seeds each time.
#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "tests/fuzz/lode_file_mutation.h"

namespace lode::fuzz {
namespace {

/// One to three changes: bits, bytes, numbers that are extreme, a part copied or taken out.
class Mutation {
 public:
  explicit Mutation(std::minstd_rand& random) : random_(random) {}

  std::size_t operator()(std::uint8_t* data, std::size_t size, std::size_t max_size) const {
    for (std::size_t n = 1 + random_() % 3; n > 0 && size > 0; --n)
      size = once(data, size, max_size);
    return size;
  }

 private:
  std::size_t once(std::uint8_t* data, std::size_t size, std::size_t max_size) const {
    const std::size_t at = random_() % size;
    switch (random_() % 6) {
      case 0: data[at] ^= static_cast<std::uint8_t>(1U << (random_() % 8)); return size;
      case 1: data[at] = static_cast<std::uint8_t>(random_()); return size;
      case 2: return put_number(data, at, size);
      case 3: {
        const std::size_t n = std::min<std::size_t>(1 + random_() % 16, size - at);
        std::memmove(data + random_() % (size - n + 1), data + at, n);
        return size;
      }
      case 4: {
        const std::size_t n = std::min<std::size_t>(1 + random_() % 16, size - at);
        std::memmove(data + at, data + at + n, size - at - n);
        return size - n;
      }
      default: {
        const std::size_t n = std::min<std::size_t>(1 + random_() % 16, max_size - size);
        std::memmove(data + at + n, data + at, size - at);
        return size + n;
      }
    }
  }
  std::size_t put_number(std::uint8_t* data, std::size_t at, std::size_t size) const {
    constexpr std::array<std::uint64_t, 8> kNumbers{0,
                                                    1,
                                                    ~std::uint64_t{0},
                                                    0x7fffffffffffffff,
                                                    0x7ff8000000000000,
                                                    0x7fefffffffffffff,
                                                    0x80000000,
                                                    0x100000000};
    const std::uint64_t number = kNumbers[random_() % kNumbers.size()];
    const std::size_t n = std::min<std::size_t>(std::size_t{1} << (random_() % 4), size - at);
    std::memcpy(data + at, reinterpret_cast<const char*>(&number) + (8 - n) * (random_() % 2), n);
    return size;
  }

  std::minstd_rand& random_;
};

class mutation_storm : public ::testing::TestWithParam<Harness> {};

TEST_P(mutation_storm, is_refused_or_answered) {
  const char* wanted = std::getenv("LODE_MUTATIONS");
  const int n_each = wanted != nullptr ? std::atoi(wanted) : 25;
  const auto directory = std::filesystem::path(LODE_FUZZ_CORPUS) / GetParam().name;
  int n_changed = 0;
  for (const auto& entry : std::filesystem::directory_iterator(directory)) {
    std::ifstream stream(entry.path(), std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
    for (int i = 0; i < n_each; ++i) {
      std::minstd_rand random(static_cast<unsigned>(i + 1));
      const auto file = mutate_lode_file(std::as_bytes(std::span(bytes.data(), bytes.size())),
                                         random, Mutation(random));
      if (!file) break;
      SCOPED_TRACE(testing::Message() << entry.path() << ", " << i);
      GetParam().run(*file);
      ++n_changed;
    }
  }
  EXPECT_GT(n_changed, 0);
}

INSTANTIATE_TEST_SUITE_P(models, mutation_storm,
                         ::testing::Values(kHarnesses[0], kHarnesses[1], kHarnesses[2]),
                         [](const auto& one) { return std::string(one.param.name); });

}  // namespace
}  // namespace lode::fuzz
