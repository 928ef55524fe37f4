#include "tests/io/volume_test_files.h"

namespace lode::io {
namespace {

using test::info_of;
using test::NiftiBytes;
using test::TempDir;

std::string nrrd_with(const std::string& fields) {
  return "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 3 2\nencoding: raw\n" + fields + "\n" +
         std::string(24, 'x');
}

TEST(volume_units, of_nrrd_are_those_of_its_space_and_samples) {
  const TempDir dir;
  const auto units_of = [&](const std::string& fields) {
    return info_of(dir.write("a.nrrd", nrrd_with(fields))).units;
  };
  EXPECT_TRUE(units_of("").is_empty());
  EXPECT_EQ(units_of("space dimension: 3\nspace directions: (1,0,0) (0,1,0) (0,0,1)\n"
                     "space units: \"mm\" \"mm\" \"mm\"\nsample units: \"HU\"\n"),
            (Units{"mm", "HU"}));
  EXPECT_EQ(units_of("units: \"um\" \"um\" \"um\"\nsample units: counts\n"),
            (Units{"um", "counts"}));
  EXPECT_EQ(units_of("space units: \"\" \"\" \"\"\nunits: \"um\" \"um\" \"um\"\n").length, "um");
  EXPECT_EQ(units_of("sample units: \"\"\n").value, "");
  EXPECT_EQ(units_of("sample units: none\n").value, "");
  EXPECT_EQ(units_of("sample units: \"m\\\"m\"\n").value, "m\"m");
  EXPECT_EQ(units_of("units: \"mm\" \"mm\"\n"), Units{});
  EXPECT_EQ(units_of("units: \"mm \"mm\" \"mm\"\n"), Units{});
  // Lengths along the axes that are not alike have no unit in common.
  EXPECT_EQ(units_of("units: \"um\" \"um\" \"mm\"\n"), Units{});
  EXPECT_EQ(units_of("units: \"um\n"), Units{});
  const auto mixed =
      describe_volume(dir.write("b.nrrd", nrrd_with("units: \"um\" \"um\" \"mm\"\n")), {});
  ASSERT_TRUE(mixed);
  EXPECT_NE(mixed->frame_note.find("different units: 'um', 'um', 'mm'"), std::string::npos)
      << mixed->frame_note;
}

TEST(volume_units, of_nrrd_are_those_of_axes_in_space) {
  const TempDir dir;
  const auto length_of = [&](const std::string& fields, const ReadOptions& options) {
    const std::string head = "NRRD0004\ntype: uint8\ndimension: 4\nencoding: raw\n";
    return info_of(dir.write("a.nrrd", head + fields + "\n" + std::string(48, 'x')), options)
        .units.length;
  };
  EXPECT_EQ(length_of("sizes: 4 3 2 2\nunits: \"mm\" \"mm\" \"mm\" \"s\"\n", {.time = 0}), "mm");
  EXPECT_EQ(length_of("sizes: 4 3 2 2\nunits: \"\" \"\" \"\" \"s\"\n", {.time = 0}), "");
  EXPECT_EQ(length_of("sizes: 2 4 3 2\nkinds: vector domain domain domain\n"
                      "units: \"m/s\" \"mm\" \"mm\" \"mm\"\n",
                      {.component = 0}),
            "mm");
}

TEST(volume_units, of_nifti_are_in_the_lowest_bits_of_one_byte) {
  const TempDir dir;
  const auto length_of = [&](std::uint8_t code, ByteOrder order) {
    NiftiBytes header({4, 3, 2}, 2, order);
    header.set<std::uint8_t>(123, code);
    return info_of(dir.write("a.nii", header.bytes() + std::string(24, 'x'))).units.length;
  };
  for (const ByteOrder order : {ByteOrder::little, ByteOrder::big}) {
    EXPECT_EQ(length_of(0, order), "");
    EXPECT_EQ(length_of(1, order), "m");
    EXPECT_EQ(length_of(2 | 8, order), "mm");  // and seconds
    EXPECT_EQ(length_of(3 | 16, order), "um");
    EXPECT_EQ(length_of(7, order), "");
  }
}

TEST(volume_units, of_metaimage_are_those_of_distances) {
  const TempDir dir;
  const auto length_of = [&](const std::string& field) {
    return info_of(dir.write("a.mha",
                             "ObjectType = Image\nNDims = 3\nDimSize = 4 3 2\nElementType = "
                             "MET_UCHAR\n" +
                                 field + "ElementDataFile = LOCAL\n" + std::string(24, 'x')))
        .units.length;
  };
  EXPECT_EQ(length_of(""), "");
  EXPECT_EQ(length_of("DistanceUnits = mm\n"), "mm");
  EXPECT_EQ(length_of("DistanceUnits = ?\n"), "");
}

TEST(volume_units, that_are_given_stand_for_those_of_the_file) {
  const TempDir dir;
  const auto path = dir.write("a.nrrd", nrrd_with("units: \"um\" \"um\" \"um\"\n"));
  EXPECT_EQ(info_of(path, {.units = {"", "HU"}}).units, (Units{"um", "HU"}));
  EXPECT_EQ(info_of(path, {.units = {"mm", "a\nb"}}).units, (Units{"mm", "a b"}));
  const auto description = describe_volume(path, {});
  ASSERT_TRUE(description) << description.error().message;
  EXPECT_EQ(description->units.length, "um");
}

}  // namespace
}  // namespace lode::io
