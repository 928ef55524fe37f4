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

using terrain_file::append_column;

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
  out.write(static_cast<std::uint8_t>(history.is_of_points));
  terrain_file::write(out, history);
  out.write(history.max_error);
  out.write(history.n_base_vertices);
  out.write(history.n_base_triangles());
  out.write(history.n_nodes());
  out.write(static_cast<std::uint32_t>(history.triangles.size()));
  out.write(static_cast<std::uint8_t>(type));
  terrain_file::write_levels(out, levelled.levels);
  out.write(static_cast<std::uint32_t>(history.level_ends.size()));
  out.write_all(std::span<const std::uint32_t>(history.level_ends));
  out.write(static_cast<std::uint32_t>(history.lines.size()));
  return std::move(out).take();
}

template <typename T>
Result<void> append_heights(const History& history, store::Writer& writer) {
  return append_column<T>(
      key_of(Column::height), history.heights.size(),
      [&](std::size_t i) { return static_cast<T>(history.heights[i]); }, writer);
}

}  // namespace

Result<std::uint64_t> save(const LevelledHistory& levelled, const std::string& path,
                           Progress& progress) {
  const History& history = levelled.history;
  const HeightType type = type_of(history.heights);
  LODE_TRY(auto writer,
           store::Writer::create(path, model_name(history.model), encode_head(levelled, type)));
  const std::uint64_t n_vertices = history.vertices.size();
  LODE_CHECK(append_column<std::int32_t>(
      key_of(Column::x), n_vertices, [&](std::size_t i) { return history.vertices[i].x; }, writer));
  LODE_CHECK(append_column<std::int32_t>(
      key_of(Column::y), n_vertices, [&](std::size_t i) { return history.vertices[i].y; }, writer));
  switch (type) {
    case HeightType::int16: LODE_CHECK(append_heights<std::int16_t>(history, writer)); break;
    case HeightType::float32: LODE_CHECK(append_heights<float>(history, writer)); break;
    case HeightType::float64: LODE_CHECK(append_heights<double>(history, writer)); break;
  }
  LODE_CHECK(append_column<std::uint32_t>(
      key_of(Column::corners), 3 * std::size_t{history.n_base_triangles()},
      [&](std::size_t i) { return history.triangles[i / 3].corner[i % 3]; }, writer));
  LODE_CHECK(append_column<std::uint32_t>(
      key_of(Column::age), history.n_nodes(),
      [&](std::size_t i) {
        const auto node = static_cast<std::uint32_t>(i);
        return history.first_made[node] - 1 - history.removed_by(node).front();
      },
      writer));
  LODE_CHECK(append_column<std::uint32_t>(
      key_of(Column::lines), 2 * history.lines.size(),
      [&](std::size_t i) { return history.lines[i / 2][i % 2]; }, writer));
  if (progress.is_cancelled()) return cancelled_error();
  LODE_CHECK(append_column<std::uint16_t>(
      key_of(Column::error), history.triangles.size(),
      [&](std::size_t i) {
        const auto bits = std::bit_cast<std::uint32_t>(history.triangles[i].error);
        return static_cast<std::uint16_t>(bits >> 16);
      },
      writer));
  return writer.finish(progress);
}

}  // namespace lode::insertions
