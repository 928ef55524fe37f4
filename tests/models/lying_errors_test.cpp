// Files whose blocks are whole and whose errors are not those of their samples.
#include <algorithm>
#include <cstring>

#include "lode/api/dataset.h"
#include "lode/models/diamond/block_layout.h"
#include "tests/models/stored_fixtures.h"

namespace lode {
namespace {

using diamond::ErrorCode;
using diamond::Kind;
using store::TestPath;

/// Makes all errors of level 1 small but the largest of each block, which the metadata know.
void make_small(const store::BlockKey& key, test::Bytes& bytes) {
  if (key.kind != static_cast<std::uint32_t>(Kind::errors) || key.level != 1) return;
  std::vector<ErrorCode> errors(bytes.size() / sizeof(ErrorCode));
  std::memcpy(errors.data(), bytes.data(), bytes.size());
  const ErrorCode largest = *std::ranges::max_element(errors);
  for (ErrorCode& error : errors)
    if (error != largest) error = std::min(error, diamond::encode_error(1.0F));
  std::memcpy(bytes.data(), errors.data(), bytes.size());
}

void expect_found_out(const Index3& dims, ScalarType type, test::Holes holes) {
  SCOPED_TRACE(::testing::Message() << dims[2] << " " << name_of(type));
  const TestPath path("lying.lode");
  const Volume volume = test::random_samples(dims, type, holes);
  if (dims[2] == 1)
    test::save<2>(test::built<2>(volume), path.str());
  else
    test::save<3>(test::built<3>(volume), path.str());
  Progress progress;
  const auto honest = verify_file(path.str(), {2}, progress);
  ASSERT_TRUE(honest) << honest.error().message;
  for (const VerifyReport::Check& check : honest->checks)
    EXPECT_TRUE(check.passed) << check.name << ": " << check.detail;
  ASSERT_GE(honest->checks.size(), 3U);
  EXPECT_GT(honest->checks[2].count, 100U);

  const auto limited = verify_file(path.str(), {2}, progress, 10'000);
  ASSERT_TRUE(limited);
  ASSERT_EQ(limited->checks.size(), 2U);
  EXPECT_TRUE(limited->checks[1].skipped);
  EXPECT_NE(limited->checks[1].detail.find("not looked at"), std::string::npos);

  test::rewrite(path.str(), {}, make_small);
  const auto lying = verify_file(path.str(), {2}, progress);
  ASSERT_TRUE(lying) << lying.error().message;
  EXPECT_FALSE(lying->passed());
  const auto failed =
      std::ranges::find_if(lying->checks, [](const auto& check) { return !check.passed; });
  EXPECT_EQ(failed->name, "errors and ranges are the samples'");
  EXPECT_NE(failed->detail.find("level 1, node"), std::string::npos) << failed->detail;
}

TEST(lying_errors, are_found_by_verifying_a_file) {
  expect_found_out({{40, 33, 35}}, ScalarType::uint8, test::Holes::none);
  expect_found_out({{9, 34, 20}}, ScalarType::float64, test::Holes::some);
  expect_found_out({{33, 32, 34}}, ScalarType::int16, test::Holes::some);
  expect_found_out({{90, 70, 1}}, ScalarType::float32, test::Holes::none);
}

TEST(lying_errors, end_the_query_that_they_would_break) {
  const TestPath path("broken.lode");
  test::save<3>(
      test::built<3>(test::random_samples({{40, 33, 35}}, ScalarType::uint8, test::Holes::none)),
      path.str());
  test::rewrite(path.str(), {}, make_small);
  const auto dataset = Dataset::open(path.str(), {2});
  ASSERT_TRUE(dataset);
  int n_failed = 0;
  for (const double max_error : {0.0, 5.0, 20.0, 45.0}) {
    Surface surface;
    Progress progress;
    const auto report =
        dataset->extract({.isovalues = {60.5}, .max_error = max_error}, surface, progress);
    if (report) {
      EXPECT_LE(report->achieved_error, max_error);
      continue;
    }
    ++n_failed;
    EXPECT_NE(report.error().message.find(path.str()), std::string::npos);
    EXPECT_NE(report.error().message.find("verifying"), std::string::npos);
  }
  EXPECT_GT(n_failed, 0);
}

}  // namespace
}  // namespace lode
