#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "lode/core/box.h"
#include "lode/core/parallel.h"

namespace lode {

/// A number, and bounds that contain the true one, rounded outward.
struct BoundedNumber {
  double value = 0;
  double low = 0;
  double high = 0;
};

/// Where stated errors hold: at samples, that is vertices of the reference mesh, or everywhere.
enum class ErrorPlace : std::uint8_t { at_samples, everywhere };

struct ProbeOptions {
  double max_error = 0;   ///< Tolerance near what is probed, field units; 0: full resolution.
  std::size_t field = 0;  ///< Of the data's.
  /// Further fields, which the answer has, too: of the same cut, whose tolerance is the field's.
  std::vector<std::size_t> along{};
  /// World units: points that are outside, but no farther from a cell than this, or than what
  /// rounds coordinates (kSnapRounding of the farthest corner from the origin), get what the
  /// nearest point of a cell has.
  double snap = 0;
  static constexpr double kSnapRounding = 0x1p-46;
  /// Of a volume in a file: bytes that may be taken; 0: a quarter of the machine's memory.
  std::uint64_t memory_limit = 0;
  Threads threads{};
};

/// A further field at a point.
struct ProbedValue {
  BoundedNumber value;  ///< As ProbedPoint's.
  double error = 0;     ///< Likewise.
};

/// The field at a point. Where it is outside of all cells there is nothing but the point, and near
/// the boundary bounds without a value.
struct ProbedPoint {
  Vec3d point;  ///< World units.
  bool is_inside = false;
  /// Outside of the cut, but no farther than its boundary may be off: if F is there, it is in the
  /// value's bounds.
  bool is_near_boundary = false;
  bool is_exact = false;  ///< F' is F there: bounds are those of rounding.
  /// How far the point is from the cell whose nearest point this is all of, where that is more than
  /// rounding: ProbeOptions::snap.
  double snapped = 0;
  BoundedNumber value{};             ///< F' of the cut, and bounds of F.
  double error = 0;                  ///< Stated by the cell: largest |F - F'|, see ErrorPlace.
  std::int64_t region = 0;           ///< Where the data has several.
  std::vector<ProbedValue> along{};  ///< By further field; of what is said above.
};

struct ProbedLine {
  Vec3d begin;
  Vec3d end;
  /// 0: where the line meets faces of cells, in between which F' is linear; else that many points
  /// at equal distances, both ends among them.
  std::uint32_t n_points = 0;
};

struct ProbedLinePoint {
  ProbedPoint at;
  double distance = 0;     ///< From the line's begin, world units.
  std::uint32_t part = 0;  ///< Counts the line's parts inside.
};

/// What is said of a further field.
struct ProbedField {
  double achieved_error = 0;  ///< As ProbeReport's.
  ErrorPlace error_place = ErrorPlace::everywhere;
};

struct ProbeReport {
  double max_error = 0;
  double achieved_error = 0;  ///< Of what is probed, see ErrorPlace; 0 at full resolution.
  ErrorPlace error_place = ErrorPlace::everywhere;
  std::uint64_t n_cut_cells = 0;
  std::uint64_t n_outside = 0;        ///< Points; for certain.
  std::uint64_t n_near_boundary = 0;  ///< Points: ProbedPoint::is_near_boundary.
  std::vector<ProbedField> along{};
  bool memory_met = true;  ///< False: the limit ended refinement first; see achieved_error.
  double seconds = 0;
};

struct IntegralOptions {
  std::optional<Box3d> box{};           ///< Cells are cut exactly at it; none: the whole domain.
  std::vector<std::int64_t> regions{};  ///< Only their cells, and fine in these; empty: all.
  double max_error = 0;                 ///< As in ProbeOptions,
  std::size_t field = 0;                ///< likewise.
  std::vector<std::size_t> along{};     ///< Likewise.
  std::uint64_t memory_limit = 0;       ///< As in ProbeOptions.
  Threads threads{};
};

/// Of a further field over the region, as IntegralReport's.
struct FieldIntegral {
  BoundedNumber integral;
  BoundedNumber mean;
  BoundedNumber minimum;
  BoundedNumber maximum;
  double integral_rounding = 0;
  double integral_estimate = 0;
};

/// Of F over a region, with F' of the cut for values. Nothing but the counts where the region holds
/// nothing of the domain.
struct IntegralReport {
  ProbeReport probe;
  BoundedNumber volume;    ///< World units cubed.
  BoundedNumber integral;  ///< Field units times these.
  BoundedNumber mean;
  BoundedNumber minimum;
  BoundedNumber maximum;
  /// What rounding of doubles may have put volume and integral off by: in the bounds.
  double volume_rounding = 0;
  double integral_rounding = 0;
  /// Errors that cells state times their volumes; where they hold at samples only an estimate of
  /// what the integral is off by.
  double integral_estimate = 0;
  std::uint64_t n_cells = 0;  ///< That have a part in the region,
  std::uint64_t n_whole = 0;  ///< or all of theirs.
  bool is_empty = true;
  std::vector<FieldIntegral> along{};
};

}  // namespace lode
