#include <cmath>

#include "tests/io/volume_test_files.h"

namespace lode::io {
namespace {

using test::bytes_of;
using test::expect_failure;
using test::samples_of;
using test::TempDir;

const std::string kVector3 = "NDims = 3\nDimSize = 2 1 1\nElementNumberOfChannels = 3\n";

TEST(volume_reader, names_missing_empty_and_improper_files) {
  const TempDir dir;
  expect_failure(dir.path("gone.nrrd"), {"cannot be opened"});
  expect_failure(dir.path("gone.xyz"), {"cannot be opened"});
  for (const char* name : {"a.nrrd", "a.mha", "a.nii", "a.nii.gz", "a.vti", "a.vtk", "a.raw"})
    expect_failure(dir.write(name, ""), {"empty"});
  std::filesystem::create_directory(dir.path("d.nrrd"));
  expect_failure(dir.path("d.nrrd"), {"directory"});
}

TEST(volume_reader, lists_the_known_extensions_for_an_unknown_one) {
  const TempDir dir;
  expect_failure(dir.write("a.xyz", "x"),
                 {"'.xyz'", ".nrrd", ".nii.gz", ".vti", ".raw", "mesh of cells", ".vtu", ".msh",
                  "Exodus II", ".pvtu", ".tif"});
  expect_failure(dir.write("a", "x"), {".nrrd"});
  expect_failure(dir.write("a.raw", "x"), {"--dims", "--type"});
}

TEST(volume_reader, ignores_the_case_of_extensions) {
  const TempDir dir;
  const auto path = dir.write("A.MHA",
                              "NDims = 1\nDimSize = 2\nElementType = MET_UCHAR\n"
                              "ElementDataFile = LOCAL\nab");
  EXPECT_EQ(samples_of<std::uint8_t>(path).at(1), 'b');
}

TEST(volume_reader, refuses_a_layout_for_a_format_that_describes_itself) {
  const TempDir dir;
  ReadOptions options;
  options.raw = RawLayout{.dims = {{1, 1, 1}}};
  expect_failure(dir.write("a.nrrd", "x"), {"describes itself"}, options);
}

TEST(volume_reader, takes_magnitudes_in_float32_of_short_types_and_float64_of_long_ones) {
  const TempDir dir;
  ReadOptions options;
  options.component = Magnitude{};
  const auto shorts = dir.write("a.mha", kVector3 +
                                             "ElementType = MET_SHORT\n"
                                             "ElementDataFile = LOCAL\n" +
                                             bytes_of<std::int16_t>({1, -2, 2, -4, 4, -7}));
  EXPECT_EQ(samples_of<float>(shorts, options), (std::vector<float>{3, 9}));
  const auto longs = dir.write("b.mha", kVector3 +
                                            "ElementType = MET_INT\n"
                                            "ElementDataFile = LOCAL\n" +
                                            bytes_of<std::int32_t>({1, -2, 2, -4, 4, -7}));
  EXPECT_EQ(samples_of<double>(longs, options), (std::vector<double>{3, 9}));
}

TEST(volume_reader, refuses_a_magnitude_of_scalars_and_times_that_are_not_there) {
  const TempDir dir;
  const auto path = dir.write("a.mha",
                              "NDims = 1\nDimSize = 2\nElementType = MET_UCHAR\n"
                              "ElementDataFile = LOCAL\nab");
  ReadOptions magnitude;
  magnitude.component = Magnitude{};
  expect_failure(path, {"magnitude"}, magnitude);
  ReadOptions negative;
  negative.component = -1;
  expect_failure(path, {"--component", "got -1"}, negative);
  ReadOptions late;
  late.time = 1;
  expect_failure(path, {"--time", "got 1"}, late);
}

TEST(volume_reader, carries_nodata_and_refuses_one_that_is_no_number) {
  const TempDir dir;
  const auto path = dir.write("a.mha",
                              "NDims = 1\nDimSize = 2\nElementType = MET_UCHAR\n"
                              "ElementDataFile = LOCAL\nab");
  ReadOptions options;
  options.nodata = 97;
  EXPECT_EQ(test::info_of(path, options).nodata, 97);
  options.nodata = NAN;
  expect_failure(path, {"--nodata"}, options);
}

TEST(volume_reader, describes_a_file_whose_samples_need_a_choice) {
  const TempDir dir;
  const auto path = dir.write("a.mha", kVector3 +
                                           "ElementType = MET_SHORT\nAnatomicalOrientation "
                                           "= RAI\nElementDataFile = LOCAL\n");
  const auto description = describe_volume(path, {});
  ASSERT_TRUE(description) << description.error().message;
  EXPECT_EQ(description->format, "MetaImage, raw");
  EXPECT_EQ(description->n_components, 3);
  EXPECT_EQ(description->n_times, 1);
  EXPECT_EQ(description->type, ScalarType::int16);
  EXPECT_EQ(description->grid.dims, (Index3{{2, 1, 1}}));
  EXPECT_EQ(description->grid.frame, Frame::lps);
  EXPECT_EQ(description->fields.size(), 1U);
  EXPECT_NE(description->frame_note.find("RAI"), std::string::npos);
}

}  // namespace
}  // namespace lode::io
