// Building and saving while calls fail: a whole file or the old one, and parts that go on.
#include <filesystem>
#include <fstream>

#include "lode/api/files.h"
#include "tests/faults/fault_scratch.h"
#include "tests/faults/fault_storm.h"
#include "tests/io/unit_source.h"
#include "tests/oracles/analytic_fields.h"
#include "tests/oracles/synthetic_volumes.h"

namespace lode::test {
namespace {

using fault_build = FaultTest;

Volume small_volume() { return oracles::sample(oracles::Field::gaussians40, 17); }

/// Three chunks, side by side in x.
Volume long_volume() { return oracles::noise({{600, 4, 4}}, {.type = ScalarType::uint8}); }

/// Such that long_volume() is built in more parts than one: the least that is taken.
std::uint64_t least_limit(const Volume& volume, const FaultScratch& scratch,
                          Threads threads = {1}) {
  for (std::uint64_t limit = std::uint64_t{36} << 20;; limit += 4096) {
    Progress progress;
    const auto source = make_memory_source(volume);
    const auto built = build_file(*source, scratch.output(), {threads, {}, {}, limit}, progress);
    if (!built) continue;
    EXPECT_GT(built->n_parts, 1U);
    return limit;
  }
}

std::string built_bytes(const Volume& volume) {
  const FaultScratch scratch("whole.lode");
  Progress progress;
  const auto source = make_memory_source(volume);
  EXPECT_TRUE(build_file(*source, scratch.output(), {}, progress));
  return read_bytes(scratch.output());
}

/// Once the file is in its place, what may still fail is to say what it holds; and without any
/// memory not even that can be said.
bool is_written(const std::string& message, const FaultScratch& scratch) {
  return message.find("is written") != std::string::npos ||
         (message == "out of memory" && read_bytes(scratch.output()).starts_with("\x8bLOD"));
}

/// build_file() of a volume with these options; all of it outlives the operation.
Operation file_build(VolumeSource& source, const FaultScratch& scratch,
                     const FileBuildOptions& options, const std::string& expected) {
  Operation operation;
  operation.files = {scratch.output()};
  operation.prepare = [&scratch] { scratch.prepare(); };
  operation.run = [&source, &scratch, options]() -> Result<void> {
    Progress progress;
    const auto built = build_file(source, scratch.output(), options, progress);
    if (!built) return built.error();
    return {};
  };
  operation.expect_done = [&scratch, &expected] { scratch.expect_output(expected); };
  operation.expect_undone = [&scratch, &expected](const std::string& message) {
    if (is_written(message, scratch))
      scratch.expect_output(expected);
    else
      scratch.expect_untouched();
  };
  return operation;
}

TEST_F(fault_build, in_memory_and_saving_end_in_an_error_or_the_file) {
  const Volume volume = small_volume();
  const auto source = make_memory_source(volume);
  const std::string expected = built_bytes(volume);
  const FaultScratch scratch("out.lode");
  for (const int threads : {1, 2}) {
    Operation operation = file_build(*source, scratch, {}, expected);
    operation.run = [&]() -> Result<void> {
      Progress progress;
      LODE_TRY(const auto dataset, Dataset::build(*source, {{threads}}, progress));
      return dataset.save(scratch.output(), {threads}, progress);
    };
    expect_survives_all(operation);
  }
}

TEST_F(fault_build, of_a_file_ends_in_an_error_or_the_file) {
  const Volume volume = small_volume();
  const auto source = make_memory_source(volume);
  const std::string expected = built_bytes(volume);
  const FaultScratch scratch("out.lode");
  for (const int threads : {1, 2})
    expect_survives_all(file_build(*source, scratch, {.threads = {threads}}, expected));
}

/// A name beside the output that an unfinished build may leave.
std::vector<std::string> leftovers() { return {"out.lode.part", "out.lode.part.journal"}; }

void allow_leftovers(Operation& operation, const FaultScratch& scratch) {
  operation.expect_undone = [&scratch,
                             whole = operation.expect_undone](const std::string& message) {
    if (is_written(message, scratch))
      whole(message);
    else
      scratch.expect_untouched(leftovers());
  };
}

TEST_F(fault_build, in_parts_goes_on_from_where_it_stopped) {
  const Volume volume = long_volume();
  const auto source = make_memory_source(volume);
  const std::string expected = built_bytes(volume);
  const FaultScratch scratch("out.lode");
  const std::uint64_t limit = least_limit(volume, scratch);
  const FileBuildOptions options{
      .threads = {1}, .unfinished = Unfinished::part, .memory_limit = limit};
  Operation operation = file_build(*source, scratch, options, expected);
  allow_leftovers(operation, scratch);
  FileBuildOptions resuming = options;
  resuming.unfinished = Unfinished::resume;
  operation.run_again = file_build(*source, scratch, resuming, expected).run;
  expect_survives_all(operation);
}

/// Two chunks along y, so that border layers of the units between them are spooled.
TEST_F(fault_build, with_spooled_border_layers_ends_in_an_error_or_the_file) {
  const Volume volume = oracles::noise({{16, 280, 16}}, {.type = ScalarType::float64});
  io::test::UnitSource source(volume, {{16, 128, 16}});
  const std::string expected = built_bytes(volume);
  const FaultScratch scratch("out.lode");
  {
    Progress progress;
    const auto built = build_file(source, scratch.output(), {}, progress);
    ASSERT_TRUE(built);
    EXPECT_GT(built->io.n_spool_bytes_written, 0U);  // more than fits its buffer
    EXPECT_GT(built->io.n_spool_bytes_read, 0U);
  }
  const std::string directory = std::filesystem::path(scratch.output()).parent_path().string();
  const FileBuildOptions options{.threads = {1}, .unfinished = Unfinished::part};
  Operation operation = file_build(source, scratch, options, expected);
  operation.files.push_back(directory);  // the spool has no name
  allow_leftovers(operation, scratch);
  FileBuildOptions resuming = options;
  resuming.unfinished = Unfinished::resume;
  operation.run_again = file_build(source, scratch, resuming, expected).run;
  expect_survives_all(operation);
}

TEST_F(fault_build, that_leaves_nothing_does_so_in_parts_too) {
  const Volume volume = long_volume();
  const auto source = make_memory_source(volume);
  const std::string expected = built_bytes(volume);
  const FaultScratch scratch("out.lode");
  const std::uint64_t limit = least_limit(volume, scratch, {2});
  expect_survives_all(
      file_build(*source, scratch, {.threads = {2}, .memory_limit = limit}, expected));
}

TEST_F(fault_build, goes_on_again_where_going_on_failed) {
  const Volume volume = long_volume();
  const auto source = make_memory_source(volume);
  const std::string expected = built_bytes(volume);
  const FaultScratch scratch("out.lode");
  const std::uint64_t limit = least_limit(volume, scratch);
  FileBuildOptions options{.threads = {1}, .unfinished = Unfinished::part, .memory_limit = limit};
  // What a build leaves that fails when it wants to rename its file.
  const Operation stopped = file_build(*source, scratch, options, expected);
  scratch.prepare();
  begin_faults({Fault::rename, 0, true});
  const auto failed = stopped.run();
  end_faults();
  ASSERT_FALSE(failed);
  std::vector<std::string> parts;
  for (const std::string& name : leftovers()) parts.push_back(read_bytes(scratch.path(name)));
  ASSERT_FALSE(parts[0].empty() || parts[1].empty());

  options.unfinished = Unfinished::resume;
  Operation operation = file_build(*source, scratch, options, expected);
  operation.prepare = [&] {
    scratch.prepare();
    for (std::size_t i = 0; i < parts.size(); ++i)
      std::ofstream(scratch.path(leftovers()[i]), std::ios::binary) << parts[i];
  };
  allow_leftovers(operation, scratch);
  expect_survives_all(operation);
}

}  // namespace
}  // namespace lode::test
