#include <gtest/gtest.h>

#include <cstring>
#include <span>

#include "lode/store/checksum.h"
#include "tests/cli/ball_fixture.h"

namespace lode::test {
namespace {

/// Every command that reads `input`, each with an output of its own in `scratch`.
std::vector<std::vector<std::string>> commands_reading(const std::string& input,
                                                       const Scratch& scratch) {
  std::vector<std::vector<std::string>> commands{
      {"info", input},
      {"extract", input, scratch / "out.ply", "--isovalue", "100"},
      {"render", input, scratch / "out.png", "--isovalue", "100"}};
  if (input.ends_with(".lode"))
    commands.push_back({"verify", input});
  else
    commands.push_back({"build", input, scratch / "out.lode"});
  return commands;
}

/// Each command refuses `input` with a sentence that names it, and leaves nothing behind.
void expect_refused_everywhere(const std::string& input, const Scratch& scratch) {
  const std::vector<std::string> before = scratch.files();
  for (const auto& command : commands_reading(input, scratch)) {
    SCOPED_TRACE(command[0] + ' ' + input);
    auto quiet = command;
    quiet.push_back("--quiet");
    expect_refusal(run_lode(quiet), 1, {input});
    EXPECT_EQ(scratch.files(), before);
  }
}

TEST(cli_inputs, refuses_a_missing_file) {
  const Scratch scratch;
  expect_refused_everywhere(scratch / "missing.nrrd", scratch);
  expect_refused_everywhere(scratch / "missing.lode", scratch);
}

TEST(cli_inputs, refuses_an_empty_file) {
  const Scratch scratch;
  for (const char* name : {"a.nrrd", "a.vti", "a.vtk", "a.mha", "a.nii", "a.nii.gz", "a.lode"}) {
    write_bytes(scratch / name, "");
    expect_refused_everywhere(scratch / name, scratch);
  }
}

TEST(cli_inputs, refuses_a_directory) {
  const Scratch scratch;
  for (const char* name : {"a.nrrd", "a.lode"}) {
    std::filesystem::create_directory(scratch / name);
    expect_refused_everywhere(scratch / name, scratch);
  }
}

TEST(cli_inputs, says_what_is_no_lode_file_but_named_so) {
  const Scratch scratch;
  const auto build = [&](const std::string& name) {
    return run_lode({"build", scratch / name, scratch / "out.lode"});
  };
  std::filesystem::create_directory(scratch / "directory.lode");
  write_bytes(scratch / "empty.lode", "");
  write_bytes(scratch / "bytes.lode", "bytes");
  expect_refusal(build("directory.lode"), 1, {scratch / "directory.lode", "a directory"});
  expect_refusal(build("empty.lode"), 1, {scratch / "empty.lode", "empty"});
  expect_refusal(build("missing.lode"), 1, {scratch / "missing.lode", "No such file"});
  expect_refusal(build("bytes.lode"), 2, {scratch / "bytes.lode", "a .lode file"});
}

TEST(cli_inputs, refuses_a_truncated_volume) {
  const Scratch scratch;
  write_ball(scratch / "ball.nrrd");
  const std::string bytes = read_bytes(scratch / "ball.nrrd");
  write_bytes(scratch / "half.nrrd", bytes.substr(0, bytes.size() / 2));
  expect_refused_everywhere(scratch / "half.nrrd", scratch);
}

TEST(cli_inputs, names_the_file_whose_samples_cannot_be_built_and_names_it_once) {
  const Scratch scratch;
  const std::vector<double> samples(8, -1.7e308);
  const std::string bytes(reinterpret_cast<const char*>(samples.data()), 64);
  const std::string head =
      "NRRD0004\ntype: double\ndimension: 3\nsizes: 2 2 2\nendian: little\nencoding: raw\n\n";
  const std::string input = scratch / "large.nrrd";
  write_bytes(input, head + bytes);
  for (const auto& command : {Words{"build", input, scratch / "out.lode"},
                              Words{"extract", input, scratch / "out.ply", "--isovalue", "1"}}) {
    Words quiet = command;
    quiet.push_back("--quiet");
    const Finished run = run_lode(quiet);
    expect_refusal(run, 1, {"lode: " + input + ": expected samples", "-1.7"});
    EXPECT_EQ(run.err.find(input), run.err.rfind(input)) << run.err;
  }
}

TEST(cli_inputs, refuses_noise_under_any_known_extension) {
  const Scratch scratch;
  std::string noise(5000, '\0');
  std::uint32_t state = 1;
  for (char& c : noise) c = static_cast<char>((state = state * 1664525u + 1013904223u) >> 24);
  for (const char* name : {"a.nrrd", "a.vti", "a.vtk", "a.mha", "a.nii", "a.nii.gz", "a.lode"}) {
    write_bytes(scratch / name, noise);
    expect_refused_everywhere(scratch / name, scratch);
  }
}

TEST(cli_inputs, refuses_an_unknown_extension) {
  const Scratch scratch;
  write_bytes(scratch / "scan.abc", "some bytes");
  expect_refused_everywhere(scratch / "scan.abc", scratch);
}

TEST(cli_inputs, says_what_makes_volumes_of_dicom) {
  const Scratch scratch;
  const std::string slice = std::string(128, '\0') + "DICM" + std::string(60, '\1');
  std::filesystem::create_directory(scratch / "series");
  write_bytes(scratch / "slice.dcm", slice);
  write_bytes(scratch / "series/1", slice);
  for (const char* name : {"slice.dcm", "series"})
    expect_refusal(run_lode({"info", scratch / name}), 1, {name, "DICOM", "dcm2niix"});
}

TEST(cli_inputs, refuses_a_truncated_lode_file) {
  const Scratch scratch;
  write_ball(scratch / "ball.nrrd");
  ASSERT_EQ(run_lode({"build", scratch / "ball.nrrd", scratch / "ball.lode"}).exit_code, 0);
  const std::string bytes = read_bytes(scratch / "ball.lode");
  for (const std::size_t size : {std::size_t{10}, bytes.size() / 2, bytes.size() - 1}) {
    write_bytes(scratch / "cut.lode", bytes.substr(0, size));
    expect_refused_everywhere(scratch / "cut.lode", scratch);
  }
}

TEST(cli_inputs, refuses_a_lode_file_of_another_version) {
  const Scratch scratch;
  write_ball(scratch / "ball.nrrd");
  ASSERT_EQ(run_lode({"build", scratch / "ball.nrrd", scratch / "ball.lode"}).exit_code, 0);
  std::string bytes = read_bytes(scratch / "ball.lode");
  constexpr std::size_t kVersionAt = 8;
  constexpr std::size_t kChecksumAt = 120;
  for (const auto& [version, advice] : {std::pair{1, "build the file again"}, {3, "update lode"}}) {
    bytes[kVersionAt] = static_cast<char>(version);
    const std::uint64_t sum = store::checksum(std::as_bytes(std::span(bytes).first(kChecksumAt)));
    std::memcpy(bytes.data() + kChecksumAt, &sum, sizeof sum);
    write_bytes(scratch / "other.lode", bytes);
    expect_refused_everywhere(scratch / "other.lode", scratch);
    const Finished run = run_lode({"info", scratch / "other.lode"});
    EXPECT_NE(run.err.find(fmt::format("version {}", version)), std::string::npos) << run.err;
    EXPECT_NE(run.err.find(advice), std::string::npos) << run.err;
  }
}

TEST(cli_inputs, refuses_a_flipped_byte_in_anything_it_reads) {
  const Scratch scratch;
  write_ball(scratch / "ball.nrrd");
  ASSERT_EQ(run_lode({"build", scratch / "ball.nrrd", scratch / "ball.lode"}).exit_code, 0);
  const std::string bytes = read_bytes(scratch / "ball.lode");
  const std::string input = scratch / "flipped.lode";
  const std::size_t n = bytes.size();
  // Not of world errors, which surfaces without a focus do not read.
  for (const std::size_t at : {std::size_t{3}, std::size_t{24}, std::size_t{90}, first_block(bytes),
                               n / 3, 2 * n / 5, n - 60, n - 1}) {
    SCOPED_TRACE(at);
    const bool is_in_blocks = at >= 128 && at < n - 60;
    std::string flipped = bytes;
    flipped[at] = static_cast<char>(flipped[at] ^ 0x04);
    write_bytes(input, flipped);
    const std::vector<std::string> before = scratch.files();
    for (const auto& command : commands_reading(input, scratch)) {
      if (command[0] == "info" && is_in_blocks) continue;  // it reads none
      auto quiet = command;
      quiet.push_back("--quiet");
      expect_refusal(run_lode(quiet), 1, {input});
      EXPECT_EQ(scratch.files(), before);
    }
  }
}

TEST(cli_inputs, names_the_fields_of_a_file_that_holds_several) {
  const Scratch scratch;
  write_bytes(scratch / "two.vtk",
              "# vtk DataFile Version 3.0\ntwo fields\nASCII\nDATASET STRUCTURED_POINTS\n"
              "DIMENSIONS 2 2 2\nORIGIN 0 0 0\nSPACING 1 1 1\nPOINT_DATA 8\n"
              "SCALARS speed float 1\nLOOKUP_TABLE default\n0 1 2 3 4 5 6 7\n"
              "SCALARS heat float 1\nLOOKUP_TABLE default\n7 6 5 4 3 2 1 0\n");
  expect_refusal(run_lode({"build", scratch / "two.vtk", scratch / "two.lode"}), 1,
                 {"speed", "heat"});
  const nlohmann::json info = run_lode({"info", scratch / "two.vtk", "--json"}).json();
  EXPECT_EQ(info.at("fields"), (nlohmann::json{"speed", "heat"}));
  const Finished chosen =
      run_lode({"build", scratch / "two.vtk", scratch / "two.lode", "--field", "heat"});
  EXPECT_EQ(chosen.exit_code, 0) << chosen.err;
}

TEST(cli_inputs, finds_range_and_holes_of_a_foreign_file) {
  const Scratch scratch;
  write_ball(scratch / "ball.nrrd");
  const Finished run = run_lode({"info", scratch / "ball.nrrd", "--json", "--nodata", "0"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const nlohmann::json info = run.json();
  EXPECT_EQ(info.at("dims"), (nlohmann::json{17, 17, 17}));
  EXPECT_EQ(info.at("type"), "uint8");
  EXPECT_EQ(info.at("range").at(1), 200);
  EXPECT_GT(info.at("range").at(0).get<double>(), 0);
  EXPECT_GT(info.at("holes").get<int>(), 0);
}

TEST(cli_inputs, reads_bare_samples_as_told) {
  const Scratch scratch;
  write_bytes(scratch / "v.raw", std::string({0, 1, 0, 2, 0, 3, 1, 0}));
  const nlohmann::json info =
      run_lode({"info", scratch / "v.raw", "--dims", "2x2x1", "--type", "uint16", "--byte-order",
                "big", "--spacing", "1,2,3", "--origin", "-.5,10,20", "--json"})
          .json();
  EXPECT_EQ(info.at("range"), (nlohmann::json{1, 256}));
  EXPECT_EQ(info.at("spacing"), (nlohmann::json{1, 2, 3}));
  EXPECT_EQ(info.at("origin"), (nlohmann::json{-0.5, 10, 20}));
}

}  // namespace
}  // namespace lode::test
