// Every input that was kept, through the harness it was kept for: seeds, what reached new code, and
// what once was a fault.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "tests/fuzz/harnesses.h"

namespace lode::fuzz {
namespace {

std::vector<std::filesystem::path> corpus_of(const Harness& harness) {
  std::vector<std::filesystem::path> files;
  const auto directory = std::filesystem::path(LODE_FUZZ_CORPUS) / harness.name;
  for (const auto& entry : std::filesystem::directory_iterator(directory))
    files.push_back(entry.path());
  std::ranges::sort(files);
  return files;
}

/// The most memory this process ever held.
std::int64_t peak_kilobytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss;
}

class fuzz_corpus : public ::testing::TestWithParam<Harness> {};

TEST_P(fuzz_corpus, runs_through_its_harness_in_little_memory) {
  const auto files = corpus_of(GetParam());
  EXPECT_FALSE(files.empty());
  const std::int64_t before = peak_kilobytes();
  for (const auto& file : files) {
    std::ifstream stream(file, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
    GetParam().run(std::as_bytes(std::span(bytes.data(), bytes.size())));
    ASSERT_LT(peak_kilobytes() - before, 400 << 10) << file;
  }
}

std::string harness_name(const ::testing::TestParamInfo<Harness>& info) { return info.param.name; }

INSTANTIATE_TEST_SUITE_P(all, fuzz_corpus, ::testing::ValuesIn(kHarnesses), harness_name);

}  // namespace

void PrintTo(const Harness& harness, std::ostream* out) { *out << harness.name; }

}  // namespace lode::fuzz
