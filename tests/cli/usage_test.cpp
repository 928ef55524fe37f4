#include <gtest/gtest.h>

#include <map>
#include <set>
#include <sstream>

#include "tests/cli/program.h"

namespace lode::test {
namespace {

const std::vector<std::string> kCommands{"info",         "build",    "count",  "extract", "probe",
                                         "attach-field", "verify",   "render", "bench",   "height",
                                         "profile",      "contours", "sight",  "compare"};

TEST(cli_usage, explains_every_command_with_an_example) {
  for (const std::string& command : kCommands) {
    const Finished run = run_lode({command, "--help"});
    EXPECT_EQ(run.exit_code, 0);
    EXPECT_EQ(run.err, "");
    EXPECT_NE(run.out.find("Example"), std::string::npos) << run.out;
    EXPECT_NE(run.out.find("lode " + command + " "), std::string::npos) << run.out;
    for (const char* option : {"--json", "--threads", "--quiet"})
      EXPECT_NE(run.out.find(option), std::string::npos) << command << ' ' << option;
    EXPECT_EQ(run_lode({"help", command}).out, run.out);
  }
}

TEST(cli_usage, lists_every_command_in_the_help) {
  for (const auto& arguments : {Words{"--help"}, Words{"help"}}) {
    const Finished run = run_lode(arguments);
    EXPECT_EQ(run.exit_code, 0);
    for (const std::string& command : kCommands)
      EXPECT_NE(run.out.find("\n  " + command), std::string::npos) << run.out;
  }
}

/// Commands for volumes, meshes and terrain, with what they need, but for the file.
const std::vector<Words> kCommandsOfKinds{
    {"info"}, {"build", "o.lode"}, {"extract", "o.ply"}, {"verify"}, {"render", "o.png"}};

/// The options that a help lists, as --name.
std::set<std::string> options_in(const std::string& help) {
  std::set<std::string> options;
  std::istringstream lines(help);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t start = line.find("--");
    // Below what explains them options are named, too.
    if (!line.starts_with("  ") || start > std::string_view("  -q,").size()) continue;
    options.insert(line.substr(start, line.find_first_of(" ,{", start) - start));
  }
  return options;
}

TEST(cli_usage, explains_what_one_kind_of_data_has) {
  for (const Words& command : kCommandsOfKinds) {
    const std::string all = run_lode({"help", command[0]}).out;
    EXPECT_NE(all.find("lode help " + command[0] + " volume"), std::string::npos) << all;
    for (const std::string kind : {"volume", "mesh", "terrain"}) {
      const Finished run = run_lode({"help", command[0], kind});
      EXPECT_EQ(run.exit_code, 0);
      EXPECT_LT(run.out.size(), all.size());
      EXPECT_NE(run.out.find("Examples:\n  lode " + command[0]), std::string::npos) << run.out;
      EXPECT_TRUE(options_in(run.out).contains("--json"));
    }
  }
  const std::set<std::string> of_meshes = options_in(run_lode({"help", "extract", "mesh"}).out);
  EXPECT_TRUE(of_meshes.contains("--region") && of_meshes.contains("--isovalue"));
  EXPECT_FALSE(of_meshes.contains("--simplify") || of_meshes.contains("--dims"));
  expect_refusal(run_lode({"help", "extract", "mash"}), 2, {"'mash'", "volume, mesh or terrain"});
}

TEST(cli_usage, explains_what_a_file_has) {
  const Scratch scratch;
  write_bytes(scratch / "v.nrrd", "NRRD0004\n");
  write_bytes(scratch / "m.vtu", "<VTKFile/>");
  EXPECT_EQ(run_lode({"extract", scratch / "v.nrrd", "--help"}).out,
            run_lode({"help", "extract", "volume"}).out);
  EXPECT_EQ(run_lode({"render", scratch / "m.vtu", "o.png", "--help"}).out,
            run_lode({"help", "render", "mesh"}).out);
  write_bytes(scratch / "c.json", "{}");
  EXPECT_EQ(run_lode({"render", "--camera", scratch / "c.json", scratch / "m.vtu", "--help"}).out,
            run_lode({"help", "render", "mesh"}).out);
  EXPECT_EQ(run_lode({"render", "--help"}).out, run_lode({"help", "render"}).out);
  EXPECT_EQ(run_lode({"render", scratch / "none.vtu", "--help"}).out,
            run_lode({"help", "render"}).out);
}

/// None is taken and does nothing.
TEST(cli_usage, refuses_what_it_does_not_explain_of_a_kind) {
  const Scratch scratch;
  write_bytes(scratch / "dem.asc",
              "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2\n3 4\n");
  const std::map<std::string, std::string> inputs{
      {"volume", "v.nrrd"}, {"mesh", "m.vtu"}, {"terrain", scratch / "dem.asc"}};
  for (const Words& command : kCommandsOfKinds)
    for (const auto& [kind, input] : inputs) {
      const auto shown = options_in(run_lode({"help", command[0], kind}).out);
      for (const std::string& option : options_in(run_lode({"help", command[0]}).out)) {
        if (shown.contains(option)) continue;
        Words words{command[0], input};
        words.insert(words.end(), command.begin() + 1, command.end());
        words.push_back(option);
        Finished run = run_lode(words);
        // One that needs a value.
        if (run.err.find("required") != std::string::npos) {
          words.back() += "=1";
          run = run_lode(words);
        }
        EXPECT_EQ(run.exit_code, 2) << command[0] << ' ' << kind << ' ' << option << '\n'
                                    << run.err;
        EXPECT_EQ(run.err.find("required"), std::string::npos) << run.err;
      }
    }
}

TEST(cli_usage, prints_its_version) {
  const Finished run = run_lode({"--version"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_TRUE(run.out.starts_with("lode ")) << run.out;
}

TEST(cli_usage, shows_help_and_exits_with_2_when_nothing_is_asked) {
  const Finished run = run_lode({});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_EQ(run.out, "");
  EXPECT_NE(run.err.find("extract"), std::string::npos);
}

TEST(cli_usage, guesses_what_a_misspelt_command_meant) {
  expect_refusal(run_lode({"exract", "a.lode"}), 2, {"'exract'", "did you mean 'extract'?"});
  expect_refusal(run_lode({"help", "bulid"}), 2, {"'bulid'", "did you mean 'build'?"});
  expect_refusal(run_lode({"frobnicate"}), 2, {"'frobnicate'"});
}

TEST(cli_usage, guesses_what_a_misspelt_option_meant) {
  expect_refusal(run_lode({"extract", "a.lode", "b.ply", "--isovlaue", "3"}), 2,
                 {"'--isovlaue'", "did you mean '--isovalue'?"});
}

TEST(cli_usage, says_which_values_need_an_equals_sign) {
  expect_refusal(
      run_lode({"extract", "a.nrrd", "b.ply", "--isovalue", "3", "--keep-topology", "5"}), 2,
      {"--keep-topology=5"});
  expect_refusal(run_lode({"render", "a.vtu", "b.png", "--boundary", "field"}), 2,
                 {"--boundary=field"});
}

TEST(cli_usage, guesses_what_a_misspelt_extension_meant) {
  expect_refusal(run_lode({"extract", "a.lode", "b.pyl", "--isovalue", "3"}), 2,
                 {"b.pyl", "did you mean .ply?"});
  expect_refusal(run_lode({"extract", "a.lode", "b", "--isovalue", "3"}), 2, {"no extension"});
  expect_refusal(run_lode({"build", "a.nrrd", "b.lod"}), 2, {"b.lod", ".lode"});
  expect_refusal(run_lode({"render", "a.lode", "b.jpg", "--isovalue", "3"}), 2, {"b.jpg", ".png"});
}

TEST(cli_usage, refuses_missing_arguments) {
  for (const std::string& command : kCommands) expect_refusal(run_lode({command}), 2, {command});
  const Scratch scratch;
  write_ball(scratch / "a.nrrd");
  expect_refusal(run_lode({"extract", scratch / "a.nrrd", "b.ply"}), 2, {"--isovalue"});
  expect_refusal(run_lode({"extract", "a.nrrd", "b.ply"}), 2, {"a.nrrd", "cannot be opened"});
  expect_refusal(run_lode({"extract", "a.lode", "b.ply"}), 2, {"a.lode", "cannot open"});
  expect_refusal(run_lode({"verify", "a.lode", "--surface", "b.ply"}), 2, {"--isovalue"});
}

TEST(cli_usage, refuses_numbers_that_are_none) {
  const auto extract = [](std::vector<std::string> options) {
    options.insert(options.begin(), {"extract", "a.lode", "b.ply"});
    return run_lode(options);
  };
  for (const char* number : {"nan", "inf", "1e999", "12a", "1,,2"})
    expect_refusal(extract({"--isovalue", number}), 2, {"--isovalue", "finite number"});
  expect_refusal(extract({"--isovalue", "1", "--isovalue", "1.0"}), 2, {"twice"});
  for (const char* number : {"nan", "-1", "x"})
    expect_refusal(extract({"--isovalue", "1", "--max-error", number}), 2, {"--max-error", number});
  for (const char* box : {"1,2,3", "0,1,0,1,0,nan", "1,0,0,1,0,1"})
    expect_refusal(extract({"--isovalue", "1", "--clip", box}), 2, {"--clip"});
  for (const char* n : {"-3", "99999999999999999999999", "2.5", "few", "0x10"})
    expect_refusal(extract({"--isovalue", "1", std::string("--min-component=") + n}), 2,
                   {"--min-component", n});
  for (const char* threads : {"0", "-2", "many"})
    expect_refusal(extract({"--isovalue", "1", "--threads", threads}), 2, {"--threads"});
  expect_refusal(extract({"--isovalue", "1", "--normals", "maybe"}), 2, {"--normals", "'maybe'"});
}

/// Not as if they were not there.
TEST(cli_usage, refuses_empty_values) {
  const auto extract = [](std::vector<std::string> options) {
    options.insert(options.begin(), {"extract", "a.lode", "b.ply", "--isovalue", "1"});
    return run_lode(options);
  };
  for (const std::string option : {"--max-error", "--max-distance", "--clip", "--min-component",
                                   "--max-cells", "--max-error-px", "--deadline-ms",
                                   "--memory-limit", "--progressive", "--nodata", "--threads"}) {
    expect_refusal(extract({option, ""}), 2, {option});
    expect_refusal(extract({option + "="}), 2, {option});
    expect_refusal(extract({option + "=", "--quiet"}), 2, {option});
  }
  expect_refusal(extract({"--keep-topology="}), 2, {"--keep-topology: expected a value, got ''"});
  expect_refusal(extract({"--max-distance", ""}), 2, {"--max-distance: expected a value, got ''"});
  expect_refusal(extract({"--max-eror="}), 2, {"'--max-eror'", "did you mean '--max-error'?"});
  for (const Words& command :
       {Words{"verify", "a.lode", "--surface", "b.ply", "--max-distance", ""},
        Words{"render", "a.lode", "b.png", "--max-distance=", "--keep-topology="},
        Words{"render", "a.lode", "b.png", "--keep-topology="},
        Words{"count", "a.lode", "--max-error", ""}})
    expect_refusal(run_lode(command), 2, {"expected "});
}

TEST(cli_usage, refuses_reading_options_that_make_no_sense) {
  expect_refusal(run_lode({"info", "a.raw", "--dims", "4x4x0", "--type", "uint8"}), 2, {"--dims"});
  expect_refusal(run_lode({"info", "a.raw", "--dims", "4x4x4"}), 2, {"--type"});
  expect_refusal(run_lode({"info", "a.raw", "--dims", "4x4x4", "--type", "int7"}), 2, {"'int7'"});
  expect_refusal(run_lode({"info", "a.nrrd", "--nodata", "nan"}), 2, {"--nodata"});
  expect_refusal(run_lode({"info", "a.nrrd", "--component", "-1"}), 2, {"--component"});
  expect_refusal(run_lode({"info", "a.lode", "--field", "x"}), 2, {"a.lode", "--field"});
}

TEST(cli_usage, refuses_pictures_that_make_no_sense) {
  const auto render = [](std::vector<std::string> options) {
    options.insert(options.begin(), {"render", "a.lode", "b.png", "--isovalue", "1"});
    return run_lode(options);
  };
  expect_refusal(render({"--size", "0x10"}), 2, {"--size"});
  expect_refusal(render({"--size", "1000000x10"}), 2, {"--size"});
  expect_refusal(render({"--color", "blurple"}), 2, {"--color", "blurple"});
  expect_refusal(render({"--background", "white,#12"}), 2, {"--background"});
  expect_refusal(render({"--samples", "0"}), 2, {"--samples"});
  expect_refusal(render({"--camera", "c.json", "--save-camera", "c.json"}), 2, {"c.json"});
}

TEST(cli_usage, refuses_to_replace_its_input) {
  const Scratch scratch;
  write_bytes(scratch / "v.ply", std::string(64, '\0'));
  expect_refusal(run_lode({"extract", scratch / "v.ply", scratch / "./v.ply", "--isovalue", "1",
                           "--dims", "4x4x4", "--type", "uint8"}),
                 2, {"v.ply", "not an input"});
  EXPECT_EQ(read_bytes(scratch / "v.ply"), std::string(64, '\0'));
}

TEST(cli_usage, prints_one_json_object_also_for_an_error) {
  for (const auto& arguments :
       {Words{"extract", "a.lode", "b.ply", "--isovalue", "nan", "--json"},
        Words{"exract", "--json"}, Words{"extract", "--isovlaue", "1", "--json"},
        Words{"info", "/nonexistent.nrrd", "--json"}}) {
    const Finished run = run_lode(arguments);
    EXPECT_NE(run.exit_code, 0);
    EXPECT_TRUE(run.json().contains("error")) << run.out;
    EXPECT_TRUE(run.err.starts_with("lode: ")) << run.err;
  }
}

}  // namespace
}  // namespace lode::test
