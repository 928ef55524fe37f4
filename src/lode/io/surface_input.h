#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lode/core/result.h"
#include "lode/core/surface.h"

namespace lode::io {

/// The bytes of a whole surface file, in memory.
class SurfaceBytes {
 public:
  /// Fails when `path` is not a regular file with content that can be read.
  [[nodiscard]] static Result<SurfaceBytes> load(const std::string& path);

  [[nodiscard]] std::span<const std::byte> bytes() const { return {bytes_.get(), size_}; }
  [[nodiscard]] std::string_view text() const {
    return {reinterpret_cast<const char*>(bytes_.get()), size_};
  }

 private:
  SurfaceBytes(std::unique_ptr<std::byte[]> bytes, std::size_t size)
      : bytes_(std::move(bytes)), size_(size) {}

  std::unique_ptr<std::byte[]> bytes_;
  std::size_t size_ = 0;
};

/// Takes the first line off `rest`, without its end.
[[nodiscard]] std::string_view next_line(std::string_view& rest);

/// Takes the first word off `rest`, skipping white space (line ends too); empty at the end.
[[nodiscard]] std::string_view next_word(std::string_view& rest);

/// The whole word as a float, rounded once from its decimal digits; nothing when it is no number
/// or too large. Numbers too small become zero or denormal.
[[nodiscard]] std::optional<float> to_float(std::string_view word);

/// A number as a count or an index; nothing unless it is whole and fits.
[[nodiscard]] std::optional<std::uint32_t> to_index(double value);

/// A normal's component as float32; what does not fit becomes NaN.
[[nodiscard]] float to_attribute(double value);

/// The origin that a comment notes (see kOriginNote), if it does.
[[nodiscard]] std::optional<Vec3d> parse_origin_note(std::string_view comment);

/// Sets the positions and the origin from world coordinates. The origin is `note` if it gives
/// back every coordinate exactly, zero if float32 holds every coordinate exactly, else the lower
/// corner of the bounds. Returns the coordinates where positions do not have them exactly, else
/// none. Fails for coordinates that are not finite or span more than float32 can.
[[nodiscard]] Result<std::vector<Vec3d>> place_positions(const std::string& path,
                                                         std::vector<Vec3d> world,
                                                         const std::optional<Vec3d>& note,
                                                         Surface& surface);

/// A vertex's origin from world coordinates, as positions are; what does not fit becomes NaN. The
/// positions must have been placed.
[[nodiscard]] Vec3f to_origin(const Vec3d& world, const Surface& surface);

/// Appends the triangle fan of a polygon; fails for fewer than three corners.
[[nodiscard]] Result<void> append_polygon(const std::string& path,
                                          std::span<const std::uint32_t> corners, Surface& surface);

/// Fails unless positions are finite, attributes are as many as vertices or none, every index
/// names a vertex, and triangles and lines do not occur together.
[[nodiscard]] Result<void> check_surface(const std::string& path, const Surface& surface);

}  // namespace lode::io
