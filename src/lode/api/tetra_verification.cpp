#include "lode/api/tetra_verification.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "lode/api/tetra_cut_errors.h"
#include "lode/api/tetra_cut_shape.h"
#include "lode/api/tetra_overlay_errors.h"
#include "lode/api/tetra_space_errors.h"
#include "lode/mappers/self_intersections.h"
#include "lode/mappers/surface_distance.h"
#include "lode/models/tetra_mt/structure_check.h"

namespace lode {
namespace {

using tetra_mt::StructureFinding;
using tetra_mt::StructureFindings;

void add_structure(const StructureFindings& found, VerifyReport& report) {
  const auto add = [&](const char* name, const StructureFinding& finding) {
    report.add(name, finding.n_checked, finding.n_wrong,
               finding.n_wrong == 0
                   ? ""
                   : fmt::format("{} wrong; first: {}", finding.n_wrong, finding.first));
  };
  add("nodes discovered once, from the roots", found.discovery);
  add("parents and children name each other", found.links);
  add("stored values nested", found.nesting);
  if (found.refinement.n_checked > 0) add("nodes apply and undo in any order", found.refinement);
  if (found.regions.n_checked > 0) add("regions of nodes", found.regions);
}

/// One thing that is checked of several cuts.
struct CutCheck {
  std::uint64_t count = 0;
  std::uint64_t n_wrong = 0;
  std::string worst;  ///< Of what is wrong the first.

  void add(std::uint64_t n, std::uint64_t wrong, const std::string& what) {
    count += n;
    if (wrong > 0 && n_wrong == 0) worst = what;
    n_wrong += wrong;
  }
};

/// Cuts of one hierarchy, held against its mesh of all nodes.
class CutVerifier {
 public:
  CutVerifier(const TetraCutSource& source, TetraVertices vertices,
              const TetraVerifyOptions& options, Progress& progress)
      : source_(source),
        threads_(options.threads),
        is_exact_(options.is_exact),
        progress_(progress),
        vertices_(std::move(vertices)),
        fields_(options.fields) {
    for (std::size_t f = 0; options.fields.empty() && f < source.info().fields.size(); ++f)
      fields_.push_back(f);
    errors_.resize(fields_.size());
    overlay_errors_.resize(fields_.size());
  }

  [[nodiscard]] Result<void> find_reference();
  [[nodiscard]] Result<void> look_at(TetraCells cells, const std::string& name);
  /// At a tolerance that is a share of the base's error; nothing: the base.
  [[nodiscard]] Result<void> measure(std::optional<double> share, VerifyReport& report);
  void add_to(VerifyReport& report) const;

 private:
  [[nodiscard]] Result<void> measure(std::size_t field, std::optional<double> share,
                                     VerifyReport& report);
  void add_space_errors(std::size_t field, std::optional<double> share, const RefinedCells& refined,
                        VerifyReport& report) const;
  void check_range(std::size_t number, VerifyReport& report) const;
  /// Of a check of one field: names it where there are several.
  [[nodiscard]] std::string named(const std::string& check, std::size_t field) const {
    const TetraFieldInfo& head = source_.info().fields[field];
    if (fields_.size() == 1) return check;
    return fmt::format("{}: {}{}", check, head.name,
                       head.time ? fmt::format(" at {}", *head.time) : "");
  }
  void add_errors(std::size_t field, const TetraCutErrors& errors, VerifyReport& report) const;
  [[nodiscard]] Result<void> find_moved_boundary();
  [[nodiscard]] const MovedBoundary* moved() const { return moved_ ? &*moved_ : nullptr; }
  [[nodiscard]] Result<SurfaceDistance> distance_of(const Surface& boundary) const;
  [[nodiscard]] Result<void> compare_boundary(const TetraCutShape& shape, const std::string& name);
  void check_volume(const TetraCutShape& shape, const std::string& name);
  void check_outer_faces(const TetraCutShape& shape, const std::string& name);
  void add_overlay(std::size_t field, const TetraOverlayErrors& errors, VerifyReport& report) const;

  const TetraCutSource& source_;
  Threads threads_;
  bool is_exact_;
  Progress& progress_;
  TetraVertices vertices_;
  std::optional<TetraCells> reference_cells_;       ///< Where it is exact,
  std::optional<TetraOverlay> overlay_;             ///< likewise,
  std::vector<TetraOverlayErrors> overlay_errors_;  ///< and so are these, by checked field.
  TetraCutShape reference_;
  Surface reference_surface_;
  std::uint64_t n_reference_meetings_ = 0;  ///< Of pairs of its outer faces.
  std::vector<bool> is_outer_;              ///< By vertex, of the reference.
  std::optional<MovedBoundary> moved_;      ///< Where it may by more than rounding.
  CutCheck conforming_;
  CutCheck turned_;
  CutCheck volume_;
  CutCheck boundary_;
  CutCheck sheets_;
  std::vector<std::size_t> fields_;
  std::vector<TetraCutErrors> errors_;  ///< By place in fields_.
  std::uint64_t n_meetings_ = 0;        ///< The most of a cut.
  double volume_off_ = 0;               ///< The largest share by which a cut's is.
  double boundary_off_ = 0;             ///< What is proven of the farthest point.
};

Result<void> CutVerifier::find_reference() {
  LODE_TRY(const RefinedCells all, source_.refined(0, 0.0, progress_));
  const TetraCells& cells = all.cells;
  reference_ = shape_of(vertices_, cells);
  if (is_exact_) overlay_.emplace(vertices_, reference_cells_.emplace(cells), threads_);
  reference_surface_ = outer_surface(vertices_, reference_);
  LODE_TRY(const auto meetings, check_self_intersections(reference_surface_, threads_, progress_));
  n_reference_meetings_ = meetings.n_intersections;
  is_outer_.assign(vertices_.positions.size(), false);
  for (const auto& triangle : reference_.outer)
    for (const std::uint32_t v : triangle) is_outer_[v] = true;
  source_.spread(is_outer_);
  if (vertices_.has_moving_boundary()) LODE_CHECK(find_moved_boundary());
  return {};
}

/// By what the hierarchy states, but by no more than twice what is measured of the base: a
/// deviation stated too large must excuse no errors. Cuts between may be off by more than the base.
Result<void> CutVerifier::find_moved_boundary() {
  LODE_TRY(const RefinedCells base, source_.refined(0, {}, progress_));
  LODE_TRY(const SurfaceDistance distance,
           distance_of(outer_surface(vertices_, shape_of(vertices_, base.cells))));
  moved_ = find_moved(vertices_, reference_,
                      std::min(vertices_.boundary_allowance(), 2 * distance.upper()), threads_);
  return {};
}

/// What is a hundredth of the domain off is found for sure; what is less, at the vertices of both
/// and wherever triangles are cut. More pieces cost more than all other checks.
Result<SurfaceDistance> CutVerifier::distance_of(const Surface& boundary) const {
  constexpr double kAccuracy = 1e-2;
  // A mesh may be a point.
  const double accuracy = std::max(kAccuracy * vertices_.size, std::numeric_limits<double>::min());
  return measure_distance(boundary, reference_surface_, {.accuracy = accuracy, .threads = threads_},
                          progress_);
}

void CutVerifier::check_outer_faces(const TetraCutShape& shape, const std::string& name) {
  const std::uint64_t n_cracks =
      static_cast<std::uint64_t>(std::ranges::count_if(shape.outer, [&](const auto& triangle) {
        return !std::ranges::all_of(triangle, [&](std::uint32_t v) { return is_outer_[v]; });
      }));
  const bool is_crowded = shape.n_crowded_faces > reference_.n_crowded_faces;
  conforming_.add(shape.n_faces, n_cracks + (is_crowded ? shape.n_crowded_faces : 0),
                  fmt::format("{}: {} faces of one cell inside, {} of more than two", name,
                              n_cracks, shape.n_crowded_faces));
}

/// By no more than the boundary's area times what it may move by, and rounding.
void CutVerifier::check_volume(const TetraCutShape& shape, const std::string& name) {
  constexpr double kRounding = 1e-12;
  const double off = std::abs(shape.volume - reference_.volume);
  const double allowed = std::max(shape.area, reference_.area) * vertices_.boundary_allowance() +
                         kRounding * vertices_.size * vertices_.size * vertices_.size;
  const double share = reference_.volume > 0 ? off / reference_.volume : off;
  volume_off_ = std::max(volume_off_, share);
  volume_.add(1, off <= allowed ? 0 : 1,
              fmt::format("{}: {:.9g} instead of {:.9g}", name, shape.volume, reference_.volume));
}

Result<void> CutVerifier::compare_boundary(const TetraCutShape& shape, const std::string& name) {
  const Surface surface = outer_surface(vertices_, shape);
  LODE_TRY(const auto meetings, check_self_intersections(surface, threads_, progress_));
  n_meetings_ = std::max(n_meetings_, meetings.n_intersections);
  // Nothing looks for sheets that come to meet across a gap where the boundary moves.
  const bool is_clean = n_reference_meetings_ == 0 && vertices_.has_narrow_positions &&
                        !vertices_.has_moving_boundary();
  sheets_.add(meetings.n_simplices, is_clean ? meetings.n_intersections : 0,
              fmt::format("{}: {} pairs of outer faces meet where they should not", name,
                          meetings.n_intersections));
  const double rounding = vertices_.has_narrow_positions ? 0 : 0x1p-23 * vertices_.size;
  const double allowed = vertices_.boundary_allowance() + 2 * rounding;
  LODE_TRY(const SurfaceDistance distance, distance_of(surface));
  boundary_off_ = std::max(boundary_off_, distance.lower());
  boundary_.add(surface.triangles.size(), distance.lower() <= allowed ? 0 : 1,
                fmt::format("{}: {:.6g} off, {:.6g} allowed", name, distance.lower(), allowed));
  return {};
}

Result<void> CutVerifier::look_at(TetraCells cells, const std::string& name) {
  const TetraCutShape shape = shape_of(vertices_, cells);
  check_outer_faces(shape, name);
  const std::uint64_t n_more = shape.n_bad_reference > reference_.n_bad_reference ? 1 : 0;
  turned_.add(cells.corners.size(), shape.n_bad_made + n_more,
              fmt::format("{}: {} cells of collapses and {} of the reference's have no positive "
                          "volume",
                          name, shape.n_bad_made, shape.n_bad_reference));
  check_volume(shape, name);
  LODE_CHECK(compare_boundary(shape, name));
  for (std::size_t i = 0; i < fields_.size(); ++i) {
    if (fields_.size() > 1 || vertices_.values.empty())
      LODE_CHECK(source_.take_values(fields_[i], vertices_));
    LODE_CHECK(source_.state(fields_[i], cells));
    TetraCutErrors errors = measure_errors(vertices_, cells, moved(), threads_);
    if (!errors.first.empty()) errors.first = name + ": " + errors.first;
    errors_[i].append(errors);
    if (!overlay_) continue;
    TetraOverlayErrors exact = overlay_->measure(cells, threads_);
    if (!exact.first.empty()) exact.first = name + ": " + exact.first;
    overlay_errors_[i].append(exact);
  }
  if (progress_.is_cancelled()) return cancelled_error();
  return {};
}

void CutVerifier::add_overlay(std::size_t field, const TetraOverlayErrors& errors,
                              VerifyReport& report) const {
  const std::string measured =
      fmt::format("largest {:.6g}, stored {:.6g}", errors.largest, errors.largest_stated);
  if (source_.info().fields[field].error_place == ErrorPlace::everywhere) {
    report.add(named("errors everywhere <= stored errors", field), errors.n_cells,
               errors.n_above_stated,
               errors.n_above_stated == 0
                   ? measured
                   : fmt::format("{} wrong; first: {}", errors.n_above_stated, errors.first));
    return;
  }
  // Stored ones hold at samples: no promise is broken where this is more.
  report.add(named("errors everywhere, which are not stored", field), errors.n_cells, 0,
             fmt::format("{}; more than stored in {} cells", measured, errors.n_above_stated));
}

void CutVerifier::add_to(VerifyReport& report) const {
  const auto add = [&](const char* name, const CutCheck& check, const std::string& measured) {
    report.add(name, check.count, check.n_wrong, check.n_wrong == 0 ? measured : check.worst);
  };
  const auto unless_zero = [](std::uint64_t n, const std::string& text) {
    return n == 0 ? std::string() : text;
  };
  report.add("the box that is stated is that of the vertices", vertices_.positions.size(),
             vertices_.has_stated_box ? 0 : 1, "");
  add("faces of random cuts have two cells, or are outer ones", conforming_,
      unless_zero(reference_.n_crowded_faces,
                  fmt::format("the reference has {} of more", reference_.n_crowded_faces)));
  add("no cell of random cuts is flat or turned round", turned_,
      unless_zero(reference_.n_bad_reference,
                  fmt::format("but {} of the reference's", reference_.n_bad_reference)));
  add("volume of random cuts", volume_, fmt::format("{:.3g} of it off at most", volume_off_));
  add("boundary of random cuts where it was", boundary_,
      fmt::format("{:.3g} off at most, {:.3g} allowed", boundary_off_,
                  vertices_.boundary_allowance()));
  add("sheets of the boundary that meet", sheets_,
      n_reference_meetings_ + n_meetings_ == 0
          ? "none"
          : fmt::format("counted alone: {} pairs of outer faces in the reference, up to {} in cuts",
                        n_reference_meetings_, n_meetings_));
  for (std::size_t i = 0; i < fields_.size(); ++i) add_errors(fields_[i], errors_[i], report);
  for (std::size_t i = 0; is_exact_ && i < fields_.size(); ++i)
    add_overlay(fields_[i], overlay_errors_[i], report);
}

void CutVerifier::add_errors(std::size_t field, const TetraCutErrors& errors,
                             VerifyReport& report) const {
  const auto add = [&](const std::string& name, std::uint64_t n_wrong,
                       const std::string& measured) {
    report.add(name, errors.n_vertices, n_wrong,
               n_wrong == 0 ? measured : fmt::format("{} wrong; first: {}", n_wrong, errors.first));
  };
  if (field == fields_.front())
    add("vertices left out lie in random cuts", errors.n_far_outside,
        errors.n_outside == 0 ? ""
                              : fmt::format("{} outside, by up to {:.3g}", errors.n_outside,
                                            errors.farthest_outside));
  add(named("errors at vertices <= stored errors", field), errors.n_above_stated,
      fmt::format("largest {:.6g}, stored {:.6g}", errors.largest, errors.largest_stated));
  add(named("values of vertices in stored ranges", field), errors.n_out_of_range, "");
}

Result<void> CutVerifier::measure(std::optional<double> share, VerifyReport& report) {
  for (const std::size_t field : fields_) LODE_CHECK(measure(field, share, report));
  return {};
}

/// No smaller, and no wider: bounds of probes, colours and shares of it come from this.
void CutVerifier::check_range(std::size_t number, VerifyReport& report) const {
  const TetraFieldInfo& field = source_.info().fields[number];
  if (vertices_.values.empty()) return;
  // Values of other vertices are rounded, and may be beyond by that.
  const auto values = std::span(vertices_.values).first(vertices_.n_of_mesh);
  const auto [low, high] = std::ranges::minmax(values);
  const bool is_right = low == field.range_min && high == field.range_max;
  report.add(named("the range that is stated is that of the values", number), values.size(),
             is_right ? 0 : 1,
             is_right ? ""
                      : fmt::format("{} to {} instead of {} to {}", field.range_min,
                                    field.range_max, low, high));
}

/// Nothing is promised of an estimate, but that the base's is that of its nodes.
void CutVerifier::add_space_errors(std::size_t field, std::optional<double> share,
                                   const RefinedCells& refined, VerifyReport& report) const {
  const TetraSpaceErrors errors =
      measure_space_errors(vertices_, refined.cells, refined.achieved_world, threads_);
  const std::string lost =
      errors.n_lost == 0 ? "" : fmt::format(", and {} whose value is nowhere", errors.n_lost);
  report.add(named(share ? fmt::format("space errors there, estimated, at {}", *share)
                         : "space errors there, estimated",
                   field),
             errors.n_vertices, refined.has_stated_world ? 0 : 1,
             fmt::format("largest {:.6g}, RMS {:.6g}, stated {:.6g}; more at {} vertices{}",
                         errors.largest, errors.root_mean_square, refined.achieved_world,
                         errors.n_above, lost));
}

Result<void> CutVerifier::measure(std::size_t number, std::optional<double> share,
                                  VerifyReport& report) {
  const TetraFieldInfo& field = source_.info().fields[number];
  if (fields_.size() > 1 || vertices_.values.empty())
    LODE_CHECK(source_.take_values(number, vertices_));
  if (!share) check_range(number, report);
  const auto tolerance = share ? std::optional(*share * field.base_error) : std::nullopt;
  LODE_TRY(RefinedCells refined, source_.refined(number, tolerance, progress_));
  TetraCells& cells = refined.cells;
  const double achieved = refined.achieved;
  LODE_CHECK(source_.state(number, cells));
  const TetraCutErrors errors = measure_errors(vertices_, cells, moved(), threads_);
  constexpr double kRounding = 1e-9;  // Of F', as a share of the range.
  const bool is_kept =
      errors.largest_certain <= achieved + kRounding * (field.range_max - field.range_min) &&
      (!share || achieved <= *share * field.base_error);
  report.add(named(share ? fmt::format("errors at {} of the base's", *share) : "errors of the base",
                   number),
             errors.n_vertices, errors.n_above_stated + (is_kept ? 0 : 1),
             fmt::format("largest {:.6g}, stated {:.6g}, {} cells", errors.largest, achieved,
                         cells.corners.size()));
  if (field.base_world_error) add_space_errors(number, share, refined, report);
  return {};
}

}  // namespace

Result<VerifyReport> verify_hierarchy(const TetraCutSource& source,
                                      const TetraVerifyOptions& options, Progress& progress) {
  VerifyReport report;
  LODE_TRY(const StructureFindings found, source.check_structure(options.seed, progress));
  add_structure(found, report);
  if (found.discovery.n_wrong + found.links.n_wrong + found.refinement.n_wrong > 0) return report;
  LODE_TRY(TetraVertices vertices, source.vertices());
  CutVerifier verifier(source, std::move(vertices), options, progress);
  LODE_CHECK(verifier.find_reference());
  const auto n_nodes = static_cast<std::uint32_t>(source.info().n_nodes);
  for (std::uint32_t k = 0; k < options.n_random_cuts; ++k) {
    progress.report("checking random cuts", static_cast<double>(k) / options.n_random_cuts);
    // None for the base; then from a few up to a quarter of all, which need about as many more.
    const std::uint32_t n_wanted = k > 0 ? n_nodes >> (2 + 2 * (k % 4)) : 0;
    LODE_TRY(TetraCells cells, source.random(n_wanted, options.seed + k));
    LODE_CHECK(
        verifier.look_at(std::move(cells), k == 0 ? "base" : fmt::format("random cut {}", k)));
  }
  verifier.add_to(report);
  LODE_CHECK(verifier.measure({}, report));
  for (const double share : {0.3, 0.1, 0.03, 0.01}) {
    progress.report("checking tolerances", 0.5);
    LODE_CHECK(verifier.measure(share, report));
  }
  return report;
}

}  // namespace lode
