#include "tests/faults/fault_scratch.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace lode::test {
namespace {

constexpr const char* kOld = "what was there before";

}  // namespace

std::string read_bytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

FaultScratch::FaultScratch(const std::string& output_name)
    : kept_{output_name}, output_(dir_.path(output_name)) {}

std::string FaultScratch::write(const std::string& name, const std::string& bytes) {
  kept_.push_back(name);
  return dir_.write(name, bytes);
}

void FaultScratch::prepare() const {
  for (const auto& entry : std::filesystem::directory_iterator(dir_.path("")))
    if (std::ranges::count(kept_, entry.path().filename().string()) == 0)
      std::filesystem::remove_all(entry.path());
  dir_.write(kept_.front(), kOld);
}

void FaultScratch::expect_no_others(const std::vector<std::string>& allowed) const {
  for (const auto& entry : std::filesystem::directory_iterator(dir_.path(""))) {
    const std::string name = entry.path().filename().string();
    EXPECT_TRUE(std::ranges::count(kept_, name) > 0 || std::ranges::count(allowed, name) > 0)
        << name << " was left behind";
  }
}

void FaultScratch::expect_output(const std::string& bytes) const {
  EXPECT_TRUE(read_bytes(output_) == bytes) << output_ << " differs";
  expect_no_others({});
}

void FaultScratch::expect_untouched(const std::vector<std::string>& allowed) const {
  EXPECT_TRUE(read_bytes(output_) == kOld) << output_ << " has changed";
  expect_no_others(allowed);
}

}  // namespace lode::test
