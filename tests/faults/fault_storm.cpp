#include "tests/faults/fault_storm.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <numeric>
#include <string_view>

#include "tests/oracles/random.h"

namespace lode::test {
namespace {

constexpr std::int64_t kNever = -1;
/// In the fast tests, of each kind and either mode.
constexpr std::size_t kMostSamples = 5;
constexpr std::size_t kEnds = 2;

bool is_exhaustive() {
  const char* wanted = std::getenv("LODE_FAULTS");
  return wanted != nullptr && std::string_view(wanted) == "all";
}

std::size_t n_descriptors() {
  const std::filesystem::directory_iterator open_files("/proc/self/fd");
  return static_cast<std::size_t>(std::distance(begin(open_files), end(open_files)));
}

/// Of the numbers below n: all, or the first and last ones and a few between.
std::vector<std::int64_t> chosen_calls(std::int64_t n) {
  std::vector<std::int64_t> calls(static_cast<std::size_t>(n));
  std::iota(calls.begin(), calls.end(), 0);
  if (calls.size() <= kMostSamples || is_exhaustive()) return calls;
  oracles::Random random(static_cast<std::uint64_t>(n));
  for (std::size_t i = kEnds; i < kMostSamples - kEnds; ++i)
    std::swap(calls[i], calls[i + random.below(calls.size() - kEnds - i)]);
  calls.erase(calls.begin() + static_cast<std::ptrdiff_t>(kMostSamples - kEnds),
              calls.end() - static_cast<std::ptrdiff_t>(kEnds));
  return calls;
}

class Storm {
 public:
  Storm(const Operation& operation, Fault fault) : operation_(operation), fault_(fault) {}

  void run() {
    const FaultCount count = attempt(kNever, false);
    ASSERT_EQ(count.n_failed, 0);
    for (const bool persists : {false, true}) {
      for (const std::int64_t call : calls_to_fail(count.n_calls, persists)) {
        attempt(call, persists);
        if (::testing::Test::HasFailure()) return;
        ++n_attempts_;
      }
    }
    if (std::getenv("LODE_VERBOSE") && n_attempts_ > 0)
      std::printf("%s: %lld calls, %lld attempts, %lld refused\n", name_of(fault_),
                  static_cast<long long>(count.n_calls), static_cast<long long>(n_attempts_),
                  static_cast<long long>(n_refused_));
  }

 private:
  /// Calls that are only cut short or late may all be; those that are interrupted for ever would
  /// never end.
  [[nodiscard]] std::vector<std::int64_t> calls_to_fail(std::int64_t n, bool persists) const {
    if (message_of(fault_) != nullptr || !persists) return chosen_calls(n);
    const bool may_persist =
        fault_ == Fault::short_read || fault_ == Fault::short_write || fault_ == Fault::late_read;
    return std::vector<std::int64_t>(may_persist && n > 0 ? 1 : 0, 0);
  }

  /// What escapes as an exception is no error.
  static Result<void> run_guarded(const std::function<Result<void>()>& run) {
    try {
      return run();
    } catch (const std::exception& escaped) {
      end_faults();
      ADD_FAILURE() << "an exception came out: " << escaped.what();
      return {};
    }
  }

  FaultCount attempt(std::int64_t call, bool persists) {
    SCOPED_TRACE(std::string(name_of(fault_)) + " fault " + std::to_string(call) +
                 (persists ? " and later" : ""));
    operation_.prepare();
    const std::size_t n_before = n_descriptors();
    begin_faults({fault_, call == kNever ? INT64_MAX : call, persists});
    const auto done = run_guarded(operation_.run);
    const FaultCount count = end_faults();
    EXPECT_LE(n_descriptors(), n_before) << "descriptors are left open";
    if (done) {
      operation_.expect_done();
      return count;
    }
    ++n_refused_;
    expect_named(done.error().message, count);
    operation_.expect_undone(done.error().message);
    const auto again = operation_.run_again ? operation_.run_again() : operation_.run();
    EXPECT_TRUE(again) << "after \"" << done.error().message << "\": " << again.error().message;
    if (again) operation_.expect_done();
    return count;
  }

  void expect_named(const std::string& message, const FaultCount& count) const {
    const char* expected = message_of(fault_);
    EXPECT_GT(count.n_failed, 0) << "it failed without a fault: " << message;
    ASSERT_NE(expected, nullptr) << "what every caller must put up with: " << message;
    const bool wants_memory = message.find("memory") != std::string::npos;
    if (fault_ == Fault::thread && wants_memory) return;  // a thread is made of it
    EXPECT_NE(message.find(expected), std::string::npos) << message;
    if (fault_ == Fault::memory || fault_ == Fault::thread) return;
    EXPECT_TRUE(std::ranges::any_of(operation_.files, [&](const std::string& file) {
      return message.find(file) != std::string::npos;
    })) << message;
  }

  const Operation& operation_;
  Fault fault_;
  std::int64_t n_attempts_ = 0;
  std::int64_t n_refused_ = 0;
};

}  // namespace

void expect_survives(const Operation& operation, Fault fault) { Storm(operation, fault).run(); }

void expect_survives_all(const Operation& operation) {
  for (int fault = 0; fault <= static_cast<int>(Fault::late_read); ++fault) {
    expect_survives(operation, static_cast<Fault>(fault));
    if (::testing::Test::HasFailure()) return;
  }
}

}  // namespace lode::test
