#include <cmath>

#include "tests/io/volume_test_files.h"
#include "tests/oracles/trials.h"

namespace lode::io {
namespace {

/// One row of the data's own README.
struct RealFile {
  const char* name;
  Index3 dims;
  ScalarType type;
  double min;
  double max;
  Vec3d spacing{{1, 1, 1}};
  ReadOptions options = {};
};

template <typename T>
std::pair<double, double> range_of(const Volume& volume) {
  const auto samples = volume.as<T>();
  const auto [low, high] = std::minmax_element(samples.begin(), samples.end());
  return {static_cast<double>(*low), static_cast<double>(*high)};
}

ReadOptions raw_66() {
  ReadOptions options;
  options.raw = RawLayout{.dims = {{66, 66, 66}}};
  return options;
}

ReadOptions field_options(const char* field) {
  ReadOptions options;
  options.field = field;
  return options;
}

std::string real_path(const std::string& name) {
  return (test::data_directory() / "volume" / name).string();
}

class real_volumes : public testing::TestWithParam<RealFile> {};

TEST_P(real_volumes, have_the_dims_type_range_and_spacing_of_the_readme) {
  const RealFile& file = GetParam();
  const std::string path = real_path(file.name);
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is absent; set LODE_DATA";
  const auto volume = test::read_volume(path, file.options);
  ASSERT_TRUE(volume) << volume.error().message;
  EXPECT_EQ(volume->info.grid.dims, file.dims);
  ASSERT_EQ(volume->info.type, file.type);
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_NEAR(volume->info.grid.spacing[i], file.spacing[i], 1e-5 * file.spacing[i]);
  const auto [low, high] = visit_scalar_type(
      file.type, [&]<typename T>() -> std::pair<double, double> { return range_of<T>(*volume); });
  // The README prints floats with the digits that identify a float32.
  EXPECT_NEAR(low, file.min, 1e-6 * std::abs(file.min));
  EXPECT_NEAR(high, file.max, 1e-6 * std::abs(file.max));
}

constexpr Vec3d kLung{{1.40625, 1.40625, 2.5}};
constexpr Vec3d kIsabel{{4.0080321286, 4.0080321286, 4.0408163266}};
constexpr Vec3d kAorta{{0.878906, 0.878906, 1.50009}};
constexpr Vec3d kHead{{0.69999, 0.66667, 0.66667}};
constexpr Vec3d kPancreas{{1.0742188, 1.0742188, 3}};

/// Those below ten million samples, in a fast run.
std::vector<RealFile> readme_files() {
  std::vector<RealFile> files{
      RealFile{"fuel_64x33x32_uint8.nrrd", {{64, 33, 32}}, ScalarType::uint8, 0, 255},
      RealFile{"neghip_66x66x66_uint8.raw",
               {{66, 66, 66}},
               ScalarType::uint8,
               0,
               255,
               {{1, 1, 1}},
               raw_66()},
      RealFile{"iron_protein_68x68x68_uint8.vtk", {{68, 68, 68}}, ScalarType::uint8, 0, 255},
      RealFile{"viscous_fingers_64x64x64_float32.vti",
               {{64, 64, 64}},
               ScalarType::float32,
               0,
               110.95757},
      RealFile{"engine_256x256x128_uint8.nii.gz", {{256, 256, 128}}, ScalarType::uint8, 0, 255},
      RealFile{
          "lung_ct_256x256x133_uint8.vti", {{256, 256, 133}}, ScalarType::uint8, 0, 255, kLung},
      RealFile{"tooth_103x94x161_uint16be.nhdr", {{103, 94, 161}}, ScalarType::uint16, 0, 1300},
      RealFile{"carotid_76x49x45_float32.vti",
               {{76, 49, 45}},
               ScalarType::float32,
               0,
               580,
               {{1, 1, 1}},
               field_options("scalars")},
      RealFile{"mouse_embryo_256x256x256_uint8.vti", {{256, 256, 256}}, ScalarType::uint8, 0, 197},
      RealFile{"bonsai_256x256x256_uint8.nrrd", {{256, 256, 256}}, ScalarType::uint8, 0, 255},
      RealFile{"isabel_wind_125x125x25_float64.vti",
               {{125, 125, 25}},
               ScalarType::float64,
               0,
               78.65940926169091,
               kIsabel},
      RealFile{"heptane_302x302x302_uint8.nrrd", {{302, 302, 302}}, ScalarType::uint8, 0, 255},
      RealFile{"aorta_157x393x34_float32.mha",
               {{157, 393, 34}},
               ScalarType::float32,
               0,
               2570.2048,
               kAorta},
      RealFile{
          "t1_head_274x384x384_int16.nrrd", {{274, 384, 384}}, ScalarType::int16, 0, 278, kHead},
      RealFile{"pancreas_ct_512x512x134_int16.nrrd",
               {{512, 512, 134}},
               ScalarType::int16,
               -1000,
               1988,
               kPancreas}};
  if (!oracles::trials(true, false))
    std::erase_if(files, [](const RealFile& file) {
      return std::int64_t{file.dims[0]} * file.dims[1] * file.dims[2] > 10'000'000;
    });
  return files;
}

INSTANTIATE_TEST_SUITE_P(readme, real_volumes, testing::ValuesIn(readme_files()),
                         [](const testing::TestParamInfo<RealFile>& file) {
                           const std::string name = file.param.name;
                           return name.substr(0, name.find_first_of("0123456789.")) +
                                  std::to_string(file.index);
                         });

TEST(real_volume, of_uneven_ocean_levels_is_refused_by_axis_and_deviation) {
  const std::string path = real_path("levitus_temperature_360x180x20_float32.vtr");
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is absent; set LODE_DATA";
  test::expect_failure(path, {"axis z", "not evenly spaced"});
}

TEST(real_volume, of_carotid_vectors_asks_for_a_field_and_gives_components) {
  const std::string path = real_path("carotid_76x49x45_float32.vti");
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is absent; set LODE_DATA";
  test::expect_failure(path, {"scalars, vectors"});
  ReadOptions options = field_options("vectors");
  double low = 0;
  double high = 0;
  for (int component = 0; component < 3; ++component) {
    options.component = component;
    const auto samples = test::samples_of<float>(path, options);
    ASSERT_FALSE(samples.empty());
    low = std::min(low, double{*std::min_element(samples.begin(), samples.end())});
    high = std::max(high, double{*std::max_element(samples.begin(), samples.end())});
  }
  EXPECT_NEAR(low, -22.62857, 1e-5);
  EXPECT_NEAR(high, 16.617647, 1e-6);
  options.component = Magnitude{};
  const auto lengths = test::samples_of<float>(path, options);
  ASSERT_FALSE(lengths.empty());
  EXPECT_NEAR(*std::max_element(lengths.begin(), lengths.end()), 22.694927991, 1e-6);
}

TEST(real_volume, of_the_aorta_keeps_its_mirrored_axes_and_frame) {
  const std::string path = real_path("aorta_157x393x34_float32.mha");
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is absent; set LODE_DATA";
  const RegularGrid grid = test::info_of(path).grid;
  EXPECT_EQ(grid.direction.column(0), (Vec3d{{-1, 0, 0}}));
  EXPECT_EQ(grid.direction.column(1), (Vec3d{{0, -1, 0}}));
  EXPECT_EQ(grid.origin, (Vec3d{{-156.445, -24.6094, 0}}));
  EXPECT_EQ(grid.frame, Frame::lps);
}

}  // namespace
}  // namespace lode::io
