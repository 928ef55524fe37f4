#include "lode/io/crs_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <mutex>
#include <new>
#include <numbers>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "lode/core/out_of_memory.h"
#include "lode/io/crs_metric.h"
#include "lode/io/gdal_crs.h"
#include "lode/io/gdal_library.h"
#include "lode/io/gdal_raster.h"
#include "lode/io/vertical_crs.h"

namespace lode::io {
namespace {

constexpr double kNoPlace = std::numeric_limits<double>::quiet_NaN();

/// Longitudes of the target are brought near to something.
struct Turns {
  double turn = 0;        ///< Of the target's longitudes; 0: it has none.
  double own_turn = 0;    ///< Of the source's; 0: it has none.
  double own_offset = 0;  ///< Of the target's prime meridian from the source's, in target units.
  double near = 0;        ///< Where the source has none.

  [[nodiscard]] double nearest(double longitude, double source_x) const {
    if (turn == 0) return longitude;
    const double wanted = own_turn > 0 ? source_x * (turn / own_turn) - own_offset : near;
    return longitude + turn * std::round((wanted - longitude) / turn);
  }
};

class GdalPlaceMap final : public PlaceMap {
 public:
  GdalPlaceMap(const GdalLibrary* gdal, OGRCoordinateTransformationH way, const Turns& turns)
      : gdal_(gdal), way_(way), turns_(turns) {}
  GdalPlaceMap(const GdalPlaceMap&) = delete;
  GdalPlaceMap& operator=(const GdalPlaceMap&) = delete;
  ~GdalPlaceMap() override { gdal_->destroy_transformation(way_); }

  void apply(std::span<Vec<double, 2>> places) const override {
    const std::scoped_lock lock(mutex_);
    for (std::size_t i = 0; i < places.size(); i += kPiece)
      apply_piece(places.subspan(i, std::min(kPiece, places.size() - i)));
  }

  [[nodiscard]] std::unique_ptr<const PlaceMap> copy() const override {
    const std::scoped_lock lock(mutex_);
    OGRCoordinateTransformationH way = gdal_->clone_transformation(way_);
    if (way == nullptr) throw std::bad_alloc();
    return std::make_unique<GdalPlaceMap>(gdal_, way, turns_);
  }

  void set_near(double longitude) { turns_.near = longitude; }

 private:
  static constexpr std::size_t kPiece = 4096;

  void apply_piece(std::span<Vec<double, 2>> places) const {
    const std::size_t n = places.size();
    x_.resize(n);
    y_.resize(n);
    is_done_.assign(n, 0);
    for (std::size_t i = 0; i < n; ++i) {
      x_[i] = places[i][0];
      y_[i] = places[i][1];
    }
    gdal_->push_error_handler(gdal_->quiet_handler);
    gdal_->transform_each(way_, static_cast<int>(n), x_.data(), y_.data(), nullptr,
                          is_done_.data());
    gdal_->pop_error_handler();
    for (std::size_t i = 0; i < n; ++i) {
      const bool is_place = is_done_[i] != 0 && std::isfinite(x_[i]) && std::isfinite(y_[i]);
      places[i] = is_place ? Vec<double, 2>{{turns_.nearest(x_[i], places[i][0]), y_[i]}}
                           : Vec<double, 2>{{kNoPlace, kNoPlace}};
    }
  }

  const GdalLibrary* gdal_;
  OGRCoordinateTransformationH way_;
  Turns turns_;
  mutable std::mutex mutex_;
  mutable std::vector<double> x_;
  mutable std::vector<double> y_;
  mutable std::vector<int> is_done_;
};

std::string crs_name_in(const std::string& wkt) {
  const std::size_t first = wkt.find('"');
  const std::size_t last = first == std::string::npos ? first : wkt.find('"', first + 1);
  return last == std::string::npos ? wkt : wkt.substr(first + 1, last - first - 1);
}

/// Empty: it is one of x and y alone.
std::string kind_of_other(const GdalLibrary& gdal, OGRSpatialReferenceH crs) {
  constexpr int kAxesOfHeights = 3;
  const std::string heights = "; heights are transformed by --to-vertical-crs";
  if (gdal.is_geocentric(crs) != 0) return "a geocentric one, of x, y and z";
  if (gdal.is_compound(crs) != 0) return "one with heights" + heights;
  if (gdal.is_vertical(crs) != 0) return "one of heights alone" + heights;
  if (gdal.is_geographic(crs) == 0 && gdal.is_projected(crs) == 0)
    return "one that has no place on the earth";
  if (gdal.n_axes(crs) == kAxesOfHeights) return "one with heights" + heights;
  return "";
}

Turns turns_of(const HorizontalMetric& from, const HorizontalMetric& to) {
  Turns turns;
  if (!to.ellipsoid) return turns;
  turns.turn = 2 * std::numbers::pi / to.angle_unit;
  if (!from.ellipsoid) return turns;
  turns.own_turn = 2 * std::numbers::pi / from.angle_unit;
  constexpr double kDegrees = 360;
  turns.own_offset = (to.prime_meridian - from.prime_meridian) * turns.turn / kDegrees;
  return turns;
}

/// Whether heights above one ellipsoid are heights above the other, but for a shift of datums.
bool is_same_ellipsoid(const std::string& first, const std::string& second) {
  const auto read = [](const std::string& text) -> std::optional<Ellipsoid> {
    const auto crs = GdalCrs::of(text);
    const auto gdal = GdalLibrary::get();
    if (!crs || !gdal) return {};
    return Ellipsoid{(*gdal)->semi_major(crs->handle(), nullptr),
                     (*gdal)->inverse_flattening(crs->handle(), nullptr)};
  };
  constexpr double kAxis = 1e-3;
  constexpr double kFlattening = 1e-5;
  const auto a = read(first);
  const auto b = read(second);
  return a && b && std::abs(a->semi_major - b->semi_major) < kAxis &&
         std::abs(a->inverse_flattening - b->inverse_flattening) < kFlattening;
}

/// The target with what heights of the source are above.
Result<std::string> with_heights_of(const std::string& source, const std::string& target) {
  if (!says_heights(source)) return target;
  LODE_TRY(const Proj proj, Proj::make());
  LODE_TRY(const SplitCrs from, split_crs(proj, source));
  if (!from.vertical) return target;
  LODE_TRY(const SplitCrs to, split_crs(proj, target));
  if (!from.vertical->crs && !is_same_ellipsoid(source, target))
    return fail(
        "expected heights above something else than the ellipsoid of a CRS, or a CRS with the same "
        "ellipsoid, got {}: --to-vertical-crs transforms heights",
        crs_name_in(target));
  LODE_TRY(const Proj::Object whole, joined(proj, to.horizontal.get(), *from.vertical));
  return wkt_of(proj, whole.get());
}

/// A way by what is known of datums, or none.
OGRCoordinateTransformationH known_way(const GdalLibrary& gdal, const GdalCrs& from,
                                       const GdalCrs& to) {
  OGRCoordinateTransformationOptionsH options = gdal.new_way_options();
  gdal.set_guesses(options, 0);
  OGRCoordinateTransformationH way =
      gdal.new_transformation_by(from.handle(), to.handle(), options);
  gdal.destroy_way_options(options);
  return way;
}

Result<std::shared_ptr<GdalPlaceMap>> open_map(const std::string& source, const std::string& target,
                                               const Turns& turns, bool& is_guess) {
  LODE_TRY(const GdalLibrary* gdal, GdalLibrary::get());
  LODE_TRY(const GdalCrs from, GdalCrs::of(source));
  LODE_TRY(const GdalCrs to, GdalCrs::of(target));
  from.strip_heights();
  to.strip_heights();
  OGRCoordinateTransformationH way = known_way(*gdal, from, to);
  is_guess = way == nullptr;
  if (is_guess) way = gdal->new_transformation(from.handle(), to.handle());
  if (way == nullptr)
    return fail("expected a CRS from which PROJ finds a way to {}, got {}", crs_name_in(target),
                crs_name_in(source));
  return std::make_shared<GdalPlaceMap>(gdal, way, turns);
}

/// Whether what turns left round a place turns right there, where it has a place at all.
bool is_mirrored(const GdalPlaceMap& map, const HorizontalMetric& from,
                 const Vec<double, 2>& middle) {
  constexpr double kAngle = 1e-5;
  constexpr double kWay = 100;  // metres
  const double step = from.ellipsoid ? kAngle / from.angle_unit : kWay / from.length_unit;
  std::array<Vec<double, 2>, 3> places{middle, middle + Vec<double, 2>{{step, 0}},
                                       middle + Vec<double, 2>{{0, step}}};
  map.apply(places);
  const Vec<double, 2> x = places[1] - places[0];
  const Vec<double, 2> y = places[2] - places[0];
  return x[0] * y[1] - x[1] * y[0] < 0;
}

/// `map`: from the terrain's CRS, which has the place, to that of the name.
Result<void> check_axes(const GdalPlaceMap& map, const HorizontalMetric& from,
                        const Vec<double, 2>& middle, const std::string& name) {
  if (!is_mirrored(map, from, middle)) return {};
  return fail(
      "expected a CRS of x to the right and y up, got {}, whose axes come in another order: there "
      "may be one that is the same but for that, as EPSG:5514 is for EPSG:5513",
      name);
}

}  // namespace

Result<void> check_target_crs(const std::string& target) try {
  LODE_TRY(const GdalCrs crs, GdalCrs::of(target));
  LODE_TRY(const GdalLibrary* gdal, GdalLibrary::get());
  const std::string other = kind_of_other(*gdal, crs.handle());
  if (other.empty()) return {};
  return fail("expected a geographic or projected CRS, of x and y alone, got {}, {}", target,
              other);
} catch (const std::bad_alloc&) {
  return out_of_memory("read the CRS");
}

Result<TargetCrs> open_target_crs(const std::string& source, const std::string& target,
                                  const Vec<double, 2>& middle) try {
  LODE_CHECK(check_target_crs(target));
  if (source.empty())
    return fail(
        "expected terrain whose CRS is known, which is transformed to another one, got one without "
        "(--crs says it, where rasters and points are read)");
  LODE_TRY(const std::string wkt, to_wkt(target));
  TargetCrs made;
  made.name = crs_name_in(wkt);
  LODE_TRY(made.metric, read_metric(wkt));
  LODE_TRY(const HorizontalMetric own, read_metric(source));
  LODE_TRY(made.crs, with_heights_of(source, wkt));
  LODE_TRY(auto map, open_map(source, wkt, turns_of(own, made.metric), made.is_guess));
  if (made.metric.ellipsoid && !own.ellipsoid) {
    Vec<double, 2> place = middle;
    map->apply({&place, 1});
    if (std::isfinite(place[0])) map->set_near(place[0]);
  }
  LODE_CHECK(check_axes(*map, own, middle, made.name));
  made.map = std::move(map);
  return made;
} catch (const std::bad_alloc&) {
  return out_of_memory("read the CRS");
}

Result<SourceCrs> open_source_crs(const std::string& source, const std::string& target,
                                  const Vec<double, 2>& middle) try {
  LODE_CHECK(check_target_crs(source));
  if (target.empty())
    return fail(
        "expected terrain whose CRS is known, for places in another one, got one without (--crs "
        "says it, where rasters and points are read)");
  LODE_TRY(const std::string wkt, to_wkt(source));
  LODE_TRY(const HorizontalMetric to, read_metric(target));
  SourceCrs made;
  made.name = crs_name_in(wkt);
  LODE_TRY(auto map, open_map(wkt, target, turns_of({}, to), made.is_guess));
  map->set_near(middle[0]);
  bool is_back_guess = false;
  LODE_TRY(const auto back, open_map(target, wkt, {}, is_back_guess));
  LODE_CHECK(check_axes(*back, to, middle, made.name));
  made.map = std::move(map);
  return made;
} catch (const std::bad_alloc&) {
  return out_of_memory("read the CRS");
}

}  // namespace lode::io
