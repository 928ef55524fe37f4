#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <span>

#include "lode/models/terrain/insertions/file_layout.h"
#include "lode/models/terrain/insertions/persist.h"
#include "lode/store/bytes.h"
#include "lode/store/codec.h"
#include "lode/store/writer.h"

namespace lode::insertions {
namespace {

/// The narrowest that holds all heights exactly.
HeightType type_of(std::span<const double> heights) {
  const auto all = [&](const auto& holds) { return std::ranges::all_of(heights, holds); };
  if (all([](double z) {
        return std::abs(z) <= 32767 && z == std::floor(z) && !(z == 0 && std::signbit(z));
      }))
    return HeightType::int16;
  if (all([](double z) { return static_cast<double>(static_cast<float>(z)) == z; }))
    return HeightType::float32;
  return HeightType::float64;
}

std::vector<std::byte> encode_head(const LevelledHistory& levelled, HeightType type) {
  const History& history = levelled.history;
  store::ByteWriter out;
  out.write(kLayout);
  out.write(history.frame.n_columns);
  out.write(history.frame.n_rows);
  out.write_all(std::span<const double>(history.frame.to_world));
  out.write_string(history.frame.crs);
  out.write_string(history.frame.vertical_unit);
  out.write_string(history.sample_type);
  out.write(static_cast<std::uint8_t>(history.has_place));
  out.write(history.range.lower);
  out.write(history.range.upper);
  out.write(history.n_samples);
  out.write(history.n_missing);
  out.write(history.n_left_out);
  out.write(history.max_error);
  out.write(history.n_base_vertices);
  out.write(history.n_base_triangles());
  out.write(history.n_nodes());
  out.write(static_cast<std::uint32_t>(history.triangles.size()));
  out.write(static_cast<std::uint8_t>(type));
  out.write(static_cast<std::uint32_t>(levelled.levels.size()));
  out.write_all(std::span<const double>(levelled.levels));
  out.write(static_cast<std::uint32_t>(history.level_ends.size()));
  out.write_all(std::span<const std::uint32_t>(history.level_ends));
  return std::move(out).take();
}

/// number(i): of n numbers of a column.
template <typename T, typename Number>
Result<void> append_column(Column column, std::size_t n, const Number& number,
                           store::Writer& writer) {
  std::vector<T> part;
  for (std::size_t first = 0; first < n; first += kPart) {
    part.clear();
    for (std::size_t i = first; i < std::min<std::size_t>(n, first + kPart); ++i)
      part.push_back(number(i));
    LODE_CHECK(writer.append(
        key_of(column, first / kPart),
        store::encode_block({.raw = std::as_bytes(std::span<const T>(part)), .size = sizeof(T)})));
  }
  return {};
}

template <typename T>
Result<void> append_heights(const History& history, store::Writer& writer) {
  return append_column<T>(
      Column::height, history.heights.size(),
      [&](std::size_t i) { return static_cast<T>(history.heights[i]); }, writer);
}

}  // namespace

Result<std::uint64_t> save(const LevelledHistory& levelled, const std::string& path,
                           Progress& progress) {
  const History& history = levelled.history;
  LODE_EXPECTS(levelled.levels.size() <= kMaxLevels);
  const HeightType type = type_of(history.heights);
  LODE_TRY(auto writer,
           store::Writer::create(path, model_name(history.model), encode_head(levelled, type)));
  const std::size_t n_vertices = history.vertices.size();
  LODE_CHECK(append_column<std::int32_t>(
      Column::x, n_vertices, [&](std::size_t i) { return history.vertices[i].x; }, writer));
  LODE_CHECK(append_column<std::int32_t>(
      Column::y, n_vertices, [&](std::size_t i) { return history.vertices[i].y; }, writer));
  switch (type) {
    case HeightType::int16: LODE_CHECK(append_heights<std::int16_t>(history, writer)); break;
    case HeightType::float32: LODE_CHECK(append_heights<float>(history, writer)); break;
    case HeightType::float64: LODE_CHECK(append_heights<double>(history, writer)); break;
  }
  LODE_CHECK(append_column<std::uint32_t>(
      Column::corners, 3 * std::size_t{history.n_base_triangles()},
      [&](std::size_t i) { return history.triangles[i / 3].corner[i % 3]; }, writer));
  LODE_CHECK(append_column<std::uint32_t>(
      Column::age, history.n_nodes(),
      [&](std::size_t i) {
        const auto node = static_cast<std::uint32_t>(i);
        return history.first_made[node] - 1 - history.removed_by(node).front();
      },
      writer));
  if (progress.is_cancelled()) return cancelled_error();
  LODE_CHECK(append_column<std::uint16_t>(
      Column::error, history.triangles.size(),
      [&](std::size_t i) {
        const auto bits = std::bit_cast<std::uint32_t>(history.triangles[i].error);
        return static_cast<std::uint16_t>(bits >> 16);
      },
      writer));
  return writer.finish(progress);
}

}  // namespace lode::insertions
