#include <nlohmann/json.hpp>

#include "tests/io/zarr_fixtures.h"

namespace lode::io {
namespace {

using nlohmann::json;
using test::expect_failure;
using test::info_of;
using test::kSmallZarr;
using test::samples_of;
using test::zarr_samples;
using test::ZarrFixture;

TEST(ome_zarr_reader, reads_the_first_level_of_version_0_4_where_it_lies) {
  const ZarrFixture fixture("v2/image");
  EXPECT_EQ(samples_of<std::int16_t>(fixture.path()), zarr_samples<std::int16_t>(kSmallZarr));
  const VolumeInfo info = info_of(fixture.path());
  EXPECT_EQ(info.grid.spacing, (Vec3d{{0.25, 0.5, 4}}));
  EXPECT_EQ(info.grid.origin, (Vec3d{{3, -2, 1}}));
  EXPECT_EQ(info.grid.direction, Mat3::identity());
  EXPECT_EQ(info.field_name, "");
  EXPECT_EQ(info.units, (Units{"nanometer", ""}));
  const auto description = describe_volume(fixture.path(), {});
  ASSERT_TRUE(description) << description.error().message;
  EXPECT_EQ(description->format, "OME-Zarr 0.4, Zarr v2, zlib");
  EXPECT_EQ(description->frame_note, "OME-Zarr axes z, y, x in nanometer");
  EXPECT_EQ(description->fields, std::vector<std::string>{"0"});
}

TEST(ome_zarr_reader, reads_version_0_5_and_applies_the_transformations_of_all_levels) {
  const ZarrFixture fixture("v3/image");
  expect_failure(fixture.path(), {"holds 2 times"});
  expect_failure(fixture.path(), {"holds 3 components"}, {.time = 0});
  const ReadOptions options{.component = 2, .time = 1};
  EXPECT_EQ(samples_of<std::int16_t>(fixture.path(), options),
            zarr_samples<std::int16_t>({{10, 7, 2}}, {.time = 1, .channel = 2}));
  const VolumeInfo info = info_of(fixture.path(), options);
  EXPECT_EQ(info.grid.spacing, (Vec3d{{0.25, 0.5, 1}}));
  EXPECT_EQ(info.grid.origin, (Vec3d{{60, 40, 20}}));
  const auto description = describe_volume(fixture.path(), {});
  ASSERT_TRUE(description) << description.error().message;
  EXPECT_EQ(description->format, "OME-Zarr 0.5, Zarr v3, zstd");
  EXPECT_EQ(description->n_times, 2);
  EXPECT_EQ(description->n_components, 3);
}

TEST(ome_zarr_reader, opens_an_array_inside_as_it_is) {
  const ZarrFixture fixture("v2/image");
  EXPECT_EQ(samples_of<std::int16_t>(fixture.path("0")), zarr_samples<std::int16_t>(kSmallZarr));
  EXPECT_EQ(info_of(fixture.path("0")).grid.spacing, (Vec3d{{1, 1, 1}}));
}

TEST(ome_zarr_reader, wants_a_choice_of_several_images) {
  const ZarrFixture fixture("v2/images");
  expect_failure(fixture.path(), {"holds 2 fields", "0, other/0"});
  EXPECT_EQ(samples_of<std::int16_t>(fixture.path(), {.field = "0"}),
            zarr_samples<std::int16_t>(kSmallZarr));
  EXPECT_EQ(samples_of<float>(fixture.path(), {.field = "other/0"}),
            zarr_samples<float>(kSmallZarr));
  const VolumeInfo info = info_of(fixture.path(), {.field = "other/0"});
  EXPECT_EQ(info.grid.spacing, (Vec3d{{8, 8, 8}}));
  EXPECT_EQ(info.field_name, "other/0");
}

/// A fixture whose attributes are changed.
class ChangedImage {
 public:
  ChangedImage() : fixture_("v2/image"), attributes_(json::parse(fixture_.read(".zattrs"))) {}

  [[nodiscard]] json& multiscale() { return attributes_["multiscales"][0]; }
  [[nodiscard]] json& attributes() { return attributes_; }
  [[nodiscard]] std::string path() const {
    fixture_.write(".zattrs", attributes_.dump());
    return fixture_.path();
  }

 private:
  ZarrFixture fixture_;
  json attributes_;
};

TEST(ome_zarr_reader, puts_axes_where_their_names_say) {
  ChangedImage image;
  const json axes = json::parse(R"([{"name": "x", "type": "space"}, {"name": "y", "type": "space"},
                                    {"name": "z", "type": "space"}])");
  image.multiscale()["axes"] = axes;
  const RegularGrid grid = info_of(image.path()).grid;
  EXPECT_EQ(grid.spacing, (Vec3d{{0.25, 0.5, 4}}));
  EXPECT_EQ(grid.direction.column(0), (Vec3d{{0, 0, 1}}));
  EXPECT_EQ(grid.direction.column(1), (Vec3d{{0, 1, 0}}));
  EXPECT_EQ(grid.direction.column(2), (Vec3d{{1, 0, 0}}));
  EXPECT_EQ(grid.origin, (Vec3d{{1, -2, 3}}));
  image.multiscale()["axes"][0]["name"] = "depth";
  EXPECT_EQ(info_of(image.path()).grid.direction, Mat3::identity());
}

TEST(ome_zarr_reader, takes_missing_transformations_for_a_spacing_of_one) {
  ChangedImage image;
  image.multiscale()["datasets"][0].erase("coordinateTransformations");
  EXPECT_EQ(info_of(image.path()).grid.spacing, (Vec3d{{1, 1, 1}}));
  image.multiscale()["axes"] = {"z", "y", "x"};  // as version 0.3 has them
  EXPECT_EQ(samples_of<std::int16_t>(image.path()), zarr_samples<std::int16_t>(kSmallZarr));
  image.multiscale()["coordinateTransformations"] =
      json::parse(R"([{"type": "identity"}, {"type": "scale", "scale": [-2, 2, 2]}])");
  const RegularGrid grid = info_of(image.path()).grid;
  EXPECT_EQ(grid.spacing, (Vec3d{{2, 2, 2}}));
  EXPECT_EQ(grid.direction.column(2), (Vec3d{{0, 0, -1}}));
}

TEST(ome_zarr_reader, never_leaves_its_directory) {
  for (const char* path :
       {"../image/0", "..", "0/../0", "/etc", "", ".", "0//1", "0/", "a/./b", "0\n", "\0"}) {
    ChangedImage image;
    image.multiscale()["datasets"][0]["path"] = path;
    expect_failure(image.path(), {".zattrs", "expected the path of a dataset below its group"});
  }
}

struct Change {
  const char* pointer;  ///< JSON pointer below the multiscale.
  const char* value;
  const char* message;
};

TEST(ome_zarr_reader, refuses_what_it_cannot_understand) {
  const Change changes[] = {
      {"/datasets", "[]", "a list of datasets"},
      {"/datasets", "{}", "a list of datasets"},
      {"/datasets/0/path", "7", "expected text for path"},
      {"/datasets/0/path", "\"2\"", "with .zarray or zarr.json, got neither"},
      {"/datasets/0/path", "\"0/0\"", "with .zarray or zarr.json, got neither"},
      {"/datasets/0/coordinateTransformations", "3", "coordinateTransformations"},
      {"/datasets/0/coordinateTransformations/0", "3", "expected text for type"},
      {"/datasets/0/coordinateTransformations/0/type", "\"affine\"", "'affine'"},
      {"/datasets/0/coordinateTransformations/0/scale", "[1, 2]", "3 numbers for scale"},
      {"/datasets/0/coordinateTransformations/0/scale", "[1, 2, \"3\"]", "3 numbers for scale"},
      {"/datasets/0/coordinateTransformations/0/scale", "[0, 1, 1]", "axis z"},
      {"/datasets/0/coordinateTransformations/0/scale", "[1e308, 1e308, 1e308]", "finite places"},
      {"/datasets/0/coordinateTransformations/1/translation", "null", "3 numbers for translation"},
      {"/axes", "7", "at most 5 axes"},
      {"/axes", "[]", "two or three axes of space"},
      {"/axes", "[1, 2, 3]", "a name for each"},
      {"/axes", R"(["z", "y", "x", "c"])", "behind all others, got 'c'"},
      {"/axes", R"(["t", "t", "y", "x"])", "one of time"},
      {"/axes", R"(["c", "z", "y", "x"])", "4 numbers for scale"},
      {"/axes", R"(["t", "c", "z", "y", "x", "w"])", "at most 5 axes"},
  };
  for (const Change& change : changes) {
    ChangedImage image;
    SCOPED_TRACE(fmt::format("{} = {}", change.pointer, change.value));
    image.multiscale()[json::json_pointer(change.pointer)] = json::parse(change.value);
    expect_failure(image.path(), {change.message});
  }
  ChangedImage image;
  image.multiscale()["axes"] = {"c", "z", "y", "x"};
  image.multiscale()["datasets"][0].erase("coordinateTransformations");
  expect_failure(image.path(), {"an array of 4 axes in '0'", "got 3"});
  image.attributes()["multiscales"] = "none";
  expect_failure(image.path(), {"a list of multiscales"});
}

}  // namespace
}  // namespace lode::io
