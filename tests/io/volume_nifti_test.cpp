#include <cmath>

#include "tests/io/volume_test_files.h"

namespace lode::io {
namespace {

using test::bytes_of;
using test::expect_failure;
using test::info_of;
using test::NiftiBytes;
using test::ramp;
using test::samples_of;
using test::TempDir;

constexpr std::int16_t kUint8 = 2;
constexpr std::int16_t kInt16 = 4;
constexpr std::int16_t kFloat32 = 16;

TEST(nifti_reader, reads_both_byte_orders_plain_and_gzipped) {
  const TempDir dir;
  const auto samples = ramp<std::int16_t>(24);
  for (const ByteOrder order : {ByteOrder::little, ByteOrder::big}) {
    const std::string bytes =
        NiftiBytes({4, 3, 2}, kInt16, order).bytes() + bytes_of(samples, order);
    EXPECT_EQ(samples_of<std::int16_t>(dir.write("a.nii", bytes)), samples);
    EXPECT_EQ(samples_of<std::int16_t>(dir.write("a.nii.gz", test::gzipped(bytes))), samples);
  }
}

TEST(nifti_reader, knows_every_real_datatype) {
  const TempDir dir;
  const std::pair<int, ScalarType> types[] = {
      {2, ScalarType::uint8},    {4, ScalarType::int16},    {8, ScalarType::int32},
      {16, ScalarType::float32}, {64, ScalarType::float64}, {256, ScalarType::int8},
      {512, ScalarType::uint16}, {768, ScalarType::uint32}, {1024, ScalarType::int64},
      {1280, ScalarType::uint64}};
  for (const auto& [code, type] : types) {
    const auto bytes = NiftiBytes({4, 3, 2}, static_cast<std::int16_t>(code)).bytes();
    const auto path = dir.write("a.nii", bytes + std::string(24 * size_of(type), '\x01'));
    EXPECT_EQ(info_of(path).type, type) << code;
  }
  expect_failure(dir.write("b.nii", NiftiBytes({4, 3, 2}, 32).bytes()), {"datatype 32"});
}

TEST(nifti_reader, reads_a_header_with_its_image_beside_it) {
  const TempDir dir;
  const auto samples = ramp<float>(24);
  NiftiBytes header({4, 3, 2}, kFloat32);
  header.set_text(344, "ni1").set<float>(108, 8);
  const auto path = dir.write("a.hdr", header.bytes());
  const auto image = dir.write("a.img", "8 bytes." + bytes_of(samples));
  EXPECT_EQ(samples_of<float>(path), samples);
  EXPECT_EQ(samples_of<float>(image), samples);
}

TEST(nifti_reader, reads_version_2) {
  const TempDir dir;
  std::string header(544, '\0');
  const auto put = [&](std::size_t offset, const std::string& bytes) {
    header.replace(offset, bytes.size(), bytes);
  };
  put(0, bytes_of<std::int32_t>({540}));
  put(4, std::string("n+2\0\r\n\032\n", 8));
  put(12, bytes_of<std::int16_t>({kInt16}));
  put(16, bytes_of<std::int64_t>({3, 4, 3, 2, 1, 1, 1, 1}));
  put(104, bytes_of<double>({1, 0.1, 0.2, 0.3, 1, 1, 1, 1}));
  put(168, bytes_of<std::int64_t>({544}));
  const auto samples = ramp<std::int16_t>(24);
  const auto path = dir.write("a.nii", header + bytes_of(samples));
  EXPECT_EQ(samples_of<std::int16_t>(path), samples);
  EXPECT_EQ(info_of(path).grid.spacing, (Vec3d{{0.1, 0.2, 0.3}}));
}

TEST(nifti_reader, applies_slope_and_intercept_and_keeps_the_type_of_identity) {
  const TempDir dir;
  const auto samples = ramp<std::int16_t>(24);
  NiftiBytes header({4, 3, 2}, kInt16);
  header.set<float>(112, 2.5F).set<float>(116, -1000);
  const auto scaled = samples_of<float>(dir.write("a.nii", header.bytes() + bytes_of(samples)));
  ASSERT_EQ(scaled.size(), samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i)
    EXPECT_EQ(scaled[i], static_cast<float>(2.5 * samples[i] - 1000));
  header.set<float>(112, 1).set<float>(116, 0);
  EXPECT_EQ(info_of(dir.write("b.nii", header.bytes() + bytes_of(samples))).type,
            ScalarType::int16);
  header.set<float>(112, 0).set<float>(116, 77);
  EXPECT_EQ(samples_of<std::int16_t>(dir.write("c.nii", header.bytes() + bytes_of(samples))),
            samples);
  NiftiBytes wide({4, 3, 2}, 8);
  wide.set<float>(112, 0.5F);
  EXPECT_EQ(info_of(dir.write("d.nii", wide.bytes() + std::string(96, 'x'))).type,
            ScalarType::float64);
}

TEST(nifti_reader, prefers_sform_to_qform_to_bare_spacing) {
  const TempDir dir;
  NiftiBytes header({4, 3, 2}, kUint8);
  const std::string samples(24, 'x');
  header.set<float>(80, 2).set<float>(84, 3).set<float>(88, 4);
  const auto bare = info_of(dir.write("a.nii", header.bytes() + samples)).grid;
  EXPECT_EQ(bare.spacing, (Vec3d{{2, 3, 4}}));
  EXPECT_EQ(bare.frame, Frame::unknown);

  // A quarter turn round z: b = c = 0, d = sin 45 degrees; qfac -1 mirrors the third axis.
  header.set<std::int16_t>(252, 1).set<float>(76, -1).set<float>(264, std::sqrt(0.5F));
  header.set<float>(268, 10).set<float>(272, 20).set<float>(276, 30);
  const auto turned = info_of(dir.write("b.nii", header.bytes() + samples)).grid;
  EXPECT_EQ(turned.frame, Frame::ras);
  EXPECT_EQ(turned.origin, (Vec3d{{10, 20, 30}}));
  const Vec3d world = turned.to_world({{1, 1, 1}});
  // The quaternion is given in float32: its products are off by at most a few 1e-7.
  EXPECT_NEAR(world[0], 10 - 3, 1e-5);
  EXPECT_NEAR(world[1], 20 + 2, 1e-5);
  EXPECT_NEAR(world[2], 30 - 4, 1e-5);

  header.set_sform({-1, 0, 0, 5, 0, 0.5, 0, 6, 0, 0, 2, 7});
  const auto placed = info_of(dir.write("c.nii", header.bytes() + samples)).grid;
  EXPECT_EQ(placed.frame, Frame::ras);
  EXPECT_EQ(placed.spacing, (Vec3d{{1, 0.5, 2}}));
  EXPECT_EQ(placed.to_world({{1, 1, 1}}), (Vec3d{{4, 6.5, 9}}));
}

/// As of (0.6, 0.8, 0), half a turn: its matrix is a rotation, and spacings are the header's.
TEST(nifti_reader, takes_quaternions_that_are_longer_than_a_unit) {
  const TempDir dir;
  const std::string samples(24, 'x');
  const auto grid_of = [&](float b, float c) {
    NiftiBytes header({4, 3, 2}, kUint8);
    header.set<float>(80, 2).set<float>(84, 3).set<float>(88, 4);
    header.set<std::int16_t>(252, 1).set<float>(256, b).set<float>(260, c).set<float>(264, 0);
    return info_of(dir.write("a.nii", header.bytes() + samples)).grid;
  };
  const RegularGrid unit = grid_of(0.6F, 0.8F);
  const RegularGrid longer = grid_of(0.9F, 1.2F);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(longer.spacing[i], 2 + static_cast<double>(i), 1e-6);
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_NEAR(longer.direction.rows[i][k], unit.direction.rows[i][k], 1e-6);
  }
}

TEST(nifti_reader, allows_shear_and_refuses_a_singular_matrix) {
  const TempDir dir;
  NiftiBytes header({4, 3, 2}, kUint8);
  const std::string samples(24, 'x');
  header.set_sform({1, 0.5, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0});
  EXPECT_DOUBLE_EQ(
      info_of(dir.write("a.nii", header.bytes() + samples)).grid.to_world({{1, 2, 1}})[0], 2);
  header.set_sform({1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0});
  expect_failure(dir.write("b.nii", header.bytes() + samples), {"independent"});
  header.set_sform({1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0});
  expect_failure(dir.write("c.nii", header.bytes() + samples), {"spacing along axis y"});
}

TEST(nifti_reader, reads_times_vectors_and_colours) {
  const TempDir dir;
  const auto all = ramp<std::int16_t>(48);
  const auto series = dir.write("a.nii", NiftiBytes({4, 3, 2, 2}, kInt16).bytes() + bytes_of(all));
  const auto vectors =
      dir.write("b.nii", NiftiBytes({4, 3, 2, 1, 2}, kInt16).bytes() + bytes_of(all));
  const auto colours =
      dir.write("c.nii", NiftiBytes({4, 3, 2}, 128).bytes() + bytes_of(ramp<std::uint8_t>(72)));
  ReadOptions at_time;
  at_time.time = 1;
  EXPECT_EQ(samples_of<std::int16_t>(series, at_time).at(0), all[24]);
  expect_failure(series, {"2 times"});
  ReadOptions component;
  component.component = 1;
  EXPECT_EQ(samples_of<std::int16_t>(vectors, component).at(3), all[27]);
  EXPECT_EQ(samples_of<std::uint8_t>(colours, component).at(2), ramp<std::uint8_t>(72)[7]);
  expect_failure(colours, {"3 components"});
}

TEST(nifti_reader, refuses_truncated_and_malformed_files) {
  const TempDir dir;
  const std::string samples(24, 'x');
  NiftiBytes good({4, 3, 2}, kUint8);
  expect_failure(dir.write("a.nii", good.bytes() + samples.substr(1)), {"24 bytes", "23"});
  expect_failure(dir.write("b.nii", good.bytes().substr(0, 300)), {"348 bytes, got 300"});
  expect_failure(dir.write("c.nii.gz", test::gzipped(good.bytes() + samples.substr(1))),
                 {"expected 24 bytes", "hold 23"});
  expect_failure(dir.write("d.nii.gz", test::gzipped(good.bytes() + samples + "x")), {"more"});
  expect_failure(dir.write("e.nii", std::string(400, '\x07')), {"size 348 or 540"});
  NiftiBytes no_magic = good;
  expect_failure(dir.write("f.nii", no_magic.set_text(344, "xyz").bytes()), {"magic"});
  expect_failure(dir.write("g.nii", NiftiBytes({32000, 32000, 32000}, 64).bytes() + samples),
                 {"promises"});
  expect_failure(
      dir.write("h.nii.gz", test::gzipped(NiftiBytes({32000, 32000, 32000}, 64).bytes() + samples)),
      {"promises"});
  expect_failure(dir.write("i.nii", NiftiBytes({4, 0, 2}, kUint8).bytes() + samples), {"axis y"});
  NiftiBytes bad_offset = good;
  expect_failure(dir.write("j.nii", bad_offset.set<float>(108, NAN).bytes() + samples),
                 {"vox_offset"});
  expect_failure(dir.write("k.nii", bad_offset.set<float>(108, 1e14F).bytes() + samples),
                 {"promises"});
}

}  // namespace
}  // namespace lode::io
