// Places of one CRS in another.
#include "lode/io/crs_map.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "lode/io/gdal_crs.h"
#include "tests/terrain/mapped_fixtures.h"

namespace lode {
namespace {

using test::open_target;
using test::to_utm;

TEST(target_crs, has_coordinates_of_a_transverse_mercator_by_its_series) {
  const TargetCrs target = open_target("EPSG:4326", "EPSG:32632");
  EXPECT_EQ(target.name, "WGS 84 / UTM zone 32N");
  std::vector<Place> places;
  for (double x = 6; x <= 12; x += 0.25)
    for (double y = 0.5; y < 84; y += 1.5) places.push_back({{x, y}});
  std::vector<Place> mapped = places;
  target.map->apply(mapped);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Place wanted = to_utm(places[i], 9);
    ASSERT_NEAR(mapped[i][0], wanted[0], 1e-6) << places[i][0] << ' ' << places[i][1];
    ASSERT_NEAR(mapped[i][1], wanted[1], 1e-6) << places[i][0] << ' ' << places[i][1];
  }
  const TargetCrs back = open_target("EPSG:32632", "EPSG:4326", {{500000, 5e6}});
  back.map->copy()->apply(mapped);
  for (std::size_t i = 0; i < places.size(); ++i) {
    ASSERT_NEAR(mapped[i][0], places[i][0], 1e-10);
    ASSERT_NEAR(mapped[i][1], places[i][1], 1e-10);
  }
}

TEST(target_crs, has_no_place_for_what_it_has_none) {
  const TargetCrs mercator = open_target("EPSG:4326", "EPSG:3857");
  std::vector<Place> places{{{9, 46}}, {{9, 91}}, {{INFINITY, 3}}, {{9, 46}}};
  mercator.map->apply(places);
  EXPECT_EQ(places[0], places[3]);
  EXPECT_NEAR(places[0][0], 9 * 6378137 * std::numbers::pi / 180, 1e-6);
  for (const std::size_t i : {1U, 2U}) {
    EXPECT_TRUE(std::isnan(places[i][0])) << i;
    EXPECT_TRUE(std::isnan(places[i][1])) << i;
  }
}

TEST(target_crs, has_longitudes_without_jumps) {
  const TargetCrs shifted = open_target("EPSG:4326", "EPSG:4258", {{180, -17}});
  std::vector<Place> places{{{179.5, -17}}, {{180.5, -17}}, {{359, 3}}};
  shifted.map->apply(places);
  EXPECT_NEAR(places[0][0], 179.5, 1e-4);
  EXPECT_NEAR(places[1][0], 180.5, 1e-4);
  EXPECT_NEAR(places[2][0], 359, 1e-4);
  const TargetCrs fiji = open_target("EPSG:32760", "EPSG:4326", {{820000, 8.1e6}});
  places = {{{700000, 8.1e6}}, {{900000, 8.1e6}}};
  fiji.map->apply(places);
  // 200 km at 17 degrees south, on either side of where they jump.
  EXPECT_NEAR(places[1][0] - places[0][0], 1.88, 0.01);
}

TEST(target_crs, refuses_what_is_not_one_of_x_and_y) {
  const auto reason = [](const std::string& source, const std::string& target) {
    const auto made = open_target_crs(source, target, {{9, 46}});
    return made ? std::string() : made.error().message;
  };
  for (const char* with_heights : {"EPSG:5773", "EPSG:4979", "EPSG:4326+5773"})
    EXPECT_NE(reason("EPSG:4326", with_heights).find("--to-vertical-crs"), std::string::npos)
        << with_heights << reason("EPSG:4326", with_heights);
  EXPECT_NE(reason("EPSG:4326", "EPSG:4978").find("geocentric"), std::string::npos);
  EXPECT_NE(reason("EPSG:4326", "utm").find("WKT"), std::string::npos);
  EXPECT_NE(reason("EPSG:4156", "EPSG:5513").find("EPSG:5514"), std::string::npos)
      << reason("EPSG:4156", "EPSG:5513");
  EXPECT_EQ(reason("EPSG:4156", "EPSG:5514"), "");
  EXPECT_NE(reason("EPSG:4326", R"(LOCAL_CS["site",UNIT["metre",1]])").find("no place"),
            std::string::npos);
  EXPECT_NE(reason("", "EPSG:32632").find("--crs"), std::string::npos);
  EXPECT_NE(reason(R"(LOCAL_CS["site",UNIT["metre",1]])", "EPSG:32632").find("site"),
            std::string::npos);
}

TEST(target_crs, says_where_datums_are_guessed) {
  EXPECT_FALSE(open_target("EPSG:4326", "EPSG:32632").is_guess);
  EXPECT_FALSE(open_target("EPSG:4326", "EPSG:3035").is_guess);
  const std::string unknown =
      R"(GEOGCS["here",DATUM["somewhere",SPHEROID["Clarke 1866",6378206.4,294.9786982138982]],)"
      R"(PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]])";
  EXPECT_TRUE(open_target(unknown, "EPSG:32632").is_guess);
}

TEST(target_crs, keeps_what_heights_are_above) {
  const auto wkt = [](const std::string& crs) { return io::to_wkt(crs).value(); };
  EXPECT_EQ(vertical_name(open_target("EPSG:4326", "EPSG:32632").crs), "");
  EXPECT_EQ(vertical_name(open_target(wkt("EPSG:4326+5773"), "EPSG:32632").crs), "EGM96 height");
  EXPECT_EQ(vertical_name(open_target(wkt("EPSG:4979"), "EPSG:32632").crs), "ellipsoid");
  const auto other = open_target_crs(wkt("EPSG:4979"), "EPSG:31467", {{9, 46}});
  ASSERT_FALSE(other);
  EXPECT_NE(other.error().message.find("--to-vertical-crs"), std::string::npos);
}

}  // namespace
}  // namespace lode
