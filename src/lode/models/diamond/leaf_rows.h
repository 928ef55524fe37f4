#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace lode::diamond {

/// What leaf attributes are made of, a row of points at a time and several points at once. Rows are
/// read and written up to kRowPadding elements beyond their n. 16-bit numbers are even.
inline constexpr std::size_t kRowPadding = 16;
/// The longest row that extremes_round takes: a diamond2d brick's, with a sample at either end.
inline constexpr std::size_t kMaxRow = 131;

/// |F - mean of the axis ends| along one row of samples, at x = 0 .. n-1: at even x the ends lie at
/// -across and +across, at x ≡ 1 mod 4 at -1 + across and +1 - across, at x ≡ 3 the other way
/// round. 0 where a sample is NaN.
void midpoint_errors(const float* v, std::ptrdiff_t across, std::size_t n, float* error);
void midpoint_errors(const double* v, std::ptrdiff_t across, std::size_t n, double* error);
void midpoint_errors(const std::uint16_t* v, std::ptrdiff_t across, std::size_t n,
                     std::uint16_t* error);

/// The largest over rows of numbers >= 0, point by point.
void largest_of(std::span<const float* const> rows, std::size_t n, float* largest);
void largest_of(std::span<const double* const> rows, std::size_t n, double* largest);
void largest_of(std::span<const std::uint16_t* const> rows, std::size_t n, std::uint16_t* largest);

/// Smallest and largest of n > 0 numbers; NaN counts or not.
void range_of(const float* values, std::size_t n, float& low, float& high);
void range_of(const double* values, std::size_t n, double& low, double& high);
void range_of(const std::uint16_t* values, std::size_t n, std::uint16_t& low, std::uint16_t& high);

/// Rows round a point's own: where they start, listed by how far they reach to both sides in x.
using RowStencil = std::array<std::vector<std::ptrdiff_t>, 3>;

/// Smallest and largest sample of the stencil round each point of a row; n <= kMaxRow. Points less
/// than 2 from an end get any result. NaN does not count.
void extremes_round(const float* row, const RowStencil& stencil, std::size_t n, bool has_nan,
                    float* low, float* high);
void extremes_round(const double* row, const RowStencil& stencil, std::size_t n, bool has_nan,
                    double* low, double* high);
void extremes_round(const std::uint16_t* row, const RowStencil& stencil, std::size_t n,
                    bool has_nan, std::uint16_t* low, std::uint16_t* high);

}  // namespace lode::diamond
