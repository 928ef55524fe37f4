#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <thread>

#include "tests/cli/dem_fixture.h"
#include "tests/cli/program.h"
#include "tests/oracles/trials.h"

namespace lode::test {
namespace {

using Clock = std::chrono::steady_clock;

/// Noise is the slowest to build, compress and extract.
void write_noise(const std::string& path, int n) {
  std::uint32_t state = 7;
  write_nrrd(path, {{n, n, n}}, [&state](int, int, int) {
    return static_cast<int>((state = state * 1664525u + 1013904223u) >> 24);
  });
}

/// Sends `signal` at several moments of a run, and expects it to have finished or to have left
/// nothing. Returns how many runs were stopped.
int stop_at_several_moments(const std::vector<std::string>& arguments, const std::string& output,
                            const Scratch& scratch, int signal) {
  const std::vector<std::string> before = scratch.files();
  const Clock::time_point start = Clock::now();
  EXPECT_EQ(run_lode(arguments).exit_code, 0);
  const Clock::duration whole = Clock::now() - start;
  std::filesystem::remove(output);
  int n_stopped = 0;
  for (int eighth = 0; eighth < 8; ++eighth) {
    Running running(arguments);
    std::this_thread::sleep_for(whole * eighth / 8);
    running.send(signal);
    const Finished run = running.finish();
    if (run.exit_code == 0) {
      EXPECT_TRUE(std::filesystem::exists(output));
      std::filesystem::remove(output);
      continue;
    }
    ++n_stopped;
    EXPECT_EQ(run.exit_code, 128 + signal) << run.err;
    EXPECT_EQ(run.out, "");
    EXPECT_EQ(scratch.files(), before);
  }
  return n_stopped;
}

TEST(cli_signals, leave_no_partial_build) {
  const Scratch scratch;
  write_noise(scratch / "noise.nrrd", 64);
  const std::vector<std::string> build{"build", scratch / "noise.nrrd", scratch / "noise.lode"};
  EXPECT_GT(stop_at_several_moments(build, scratch / "noise.lode", scratch, SIGINT), 0);
  EXPECT_GT(stop_at_several_moments(build, scratch / "noise.lode", scratch, SIGTERM), 0);
}

TEST(cli_signals, leave_no_partial_contours) {
  const Scratch scratch;
  const int n = oracles::trials(100, 28);
  write_dem(scratch / "dem.asc", 4 * n, 3 * n);
  const std::vector<std::string> contours{
      "contours", scratch / "dem.asc", scratch / "lines.gpkg", "--interval", "1", "--max-error",
      "0"};
  EXPECT_GT(stop_at_several_moments(contours, scratch / "lines.gpkg", scratch, SIGINT), 0);
}

TEST(cli_signals, leave_no_partial_surface) {
  const Scratch scratch;
  write_noise(scratch / "noise.nrrd", 48);
  const std::vector<std::string> extract{
      "extract", scratch / "noise.nrrd", scratch / "noise.ply", "--isovalue", "128", "--max-error",
      "0"};
  EXPECT_GT(stop_at_several_moments(extract, scratch / "noise.ply", scratch, SIGINT), 0);
}

/// Waits until the file that becomes `output` has got its first bytes; false when it is there whole
/// before that was seen. Until then it has no name, or, where the file system knows no such
/// files, that of a temporary.
bool is_being_written(const Running& running, const Scratch& scratch, const std::string& output) {
  const Clock::time_point deadline = Clock::now() + std::chrono::seconds(60);
  while (Clock::now() < deadline && !std::filesystem::exists(output)) {
    if (running.unnamed_bytes(scratch.path()) > 0) return true;
    for (const std::string& name : scratch.files()) {
      const std::string path = scratch / name;
      std::error_code status;
      const bool is_temporary = path.starts_with(output + ".tmp-");
      const std::uintmax_t n_bytes = is_temporary ? std::filesystem::file_size(path, status) : 0;
      if (n_bytes > 0 && !status) return true;
    }
  }
  return false;
}

/// Interrupts runs while they write `output`, until one is stopped; expects that to leave nothing.
/// A signal may come too late, on a busy machine many times.
bool is_stopped_while_writing(const std::vector<std::string>& arguments, const std::string& output,
                              const Scratch& scratch) {
  const std::vector<std::string> before = scratch.files();
  for (int i = 0; i < 40; ++i) {
    Running running(arguments);
    if (is_being_written(running, scratch, output)) running.send(SIGINT);
    const Finished run = running.finish();
    if (run.exit_code != 0) {
      EXPECT_EQ(run.exit_code, 128 + SIGINT) << run.err;
      EXPECT_EQ(run.out, "");
      EXPECT_EQ(scratch.files(), before);
      return true;
    }
    std::filesystem::remove(output);
  }
  return false;
}

TEST(cli_signals, stop_a_surface_that_is_being_written) {
  const Scratch scratch;
  const std::string output = scratch / "noise.obj";
  write_noise(scratch / "noise.nrrd", 48);
  EXPECT_TRUE(is_stopped_while_writing(
      {"extract", scratch / "noise.nrrd", output, "--isovalue", "128", "--max-error", "0"}, output,
      scratch));
}

TEST(cli_signals, stop_a_lode_file_that_is_being_written) {
  const Scratch scratch;
  const std::string output = scratch / "noise.lode";
  write_noise(scratch / "noise.nrrd", 128);
  EXPECT_TRUE(is_stopped_while_writing({"build", scratch / "noise.nrrd", output}, output, scratch));
}

}  // namespace
}  // namespace lode::test
