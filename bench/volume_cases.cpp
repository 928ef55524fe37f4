#include "bench/volume_cases.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <string_view>

#include "bench/data_directory.h"
#include "lode/io/volume_reader.h"
#include "tests/oracles/synthetic_volumes.h"

namespace lode::bench {
namespace {

// Fractions of the range as in docs/models/diamond3d.md: a simulation without noise needs little.
double relative_error_of(oracles::Field field) {
  return field == oracles::Field::gaussians40 ? 0.0013 : 0.005;
}

std::vector<VolumeCase> analytic_cases() {
  std::vector<VolumeCase> cases;
  for (const std::int32_t n : {257, 513})
    for (const oracles::Field field : oracles::kFields)
      cases.push_back({.name = fmt::format("{}_{}", oracles::name_of(field), n),
                       .field = field,
                       .n = n,
                       .isovalue = oracles::usual_isovalue(field),
                       .relative_error = relative_error_of(field)});
  return cases;
}

/// Bytes that know nothing of each other: every cell is crossed.
VolumeCase noise_case() {
  return {.name = "noise_128", .field = {}, .n = 128, .isovalue = 127.5, .relative_error = 0.03};
}

std::vector<VolumeCase> file_cases() {
  struct File {
    std::string_view name;
    std::string_view file;
    double isovalue;
    double relative_error;
    std::string_view array = "";
  };
  constexpr File kFiles[] = {
      {"bonsai", "bonsai_256x256x256_uint8.nrrd", 40.5, 0.03},
      {"engine", "engine_256x256x128_uint8.nii.gz", 100.5, 0.03},
      {"heptane", "heptane_302x302x302_uint8.nrrd", 100.5, 0.03},
      {"mouse_embryo", "mouse_embryo_256x256x256_uint8.vti", 60.5, 0.03},
      {"lung_ct", "lung_ct_256x256x133_uint8.vti", 100.5, 0.03},
      {"tooth", "tooth_103x94x161_uint16be.nhdr", 600.5, 0.03},
      {"aorta", "aorta_157x393x34_float32.mha", 800, 0.03},
      {"isabel_wind", "isabel_wind_125x125x25_float64.vti", 30, 0.005},
      {"viscous_fingers", "viscous_fingers_64x64x64_float32.vti", 30, 0.005},
      {"carotid", "carotid_76x49x45_float32.vti", 200, 0.03, "scalars"},
      {"t1_head", "t1_head_274x384x384_int16.nrrd", 60.5, 0.03},
      {"pancreas_ct", "pancreas_ct_512x512x134_int16.nrrd", 200.5, 0.03},
  };
  std::vector<VolumeCase> cases;
  for (const File& f : kFiles)
    cases.push_back({.name = std::string(f.name),
                     .field = {},
                     .file = std::string(f.file),
                     .array = std::string(f.array),
                     .isovalue = f.isovalue,
                     .relative_error = f.relative_error});
  return cases;
}

}  // namespace

std::vector<VolumeCase> volume_cases() {
  std::vector<VolumeCase> cases = file_cases();
  cases.push_back(noise_case());
  for (VolumeCase& analytic : analytic_cases()) cases.push_back(std::move(analytic));
  return cases;
}

int run_cases(int argc, char** argv, const char* about,
              const std::function<Result<void>(const VolumeCase&)>& run) {
  CLI::App app(about);
  std::string only;
  app.add_option("--only", only, "Cases whose name contains this");
  CLI11_PARSE(app, argc, argv);
  for (const VolumeCase& volume_case : volume_cases()) {
    if (volume_case.name.find(only) == std::string::npos) continue;
    if (const auto done = run(volume_case); !done)
      fmt::print("{:<18} {}\n", volume_case.name, done.error().message);
    std::fflush(stdout);
  }
  return 0;
}

Result<Volume> load(const VolumeCase& volume_case) {
  if (volume_case.field) return oracles::sample(*volume_case.field, volume_case.n);
  if (volume_case.file.empty())
    return oracles::integer_noise({{volume_case.n, volume_case.n, volume_case.n}},
                                  {.type = ScalarType::uint8, .seed = 1, .low = 0, .high = 255});
  const std::filesystem::path path = data_directory() / "volume" / volume_case.file;
  if (!std::filesystem::exists(path))
    return fail("skipped: no {} (set LODE_DATA)", volume_case.file);
  io::ReadOptions options;
  if (!volume_case.array.empty()) options.field = volume_case.array;
  if (volume_case.raw_dims) options.raw = io::RawLayout{.dims = *volume_case.raw_dims};
  LODE_TRY(const auto source, io::open_volume(path.string(), options));
  return read_all(*source);
}

}  // namespace lode::bench
