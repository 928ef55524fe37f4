#include <bit>
#include <span>

#include "lode/models/terrain/insertions/file_layout.h"
#include "lode/models/terrain/insertions/page.h"
#include "lode/models/terrain/insertions/page_plan.h"
#include "lode/models/terrain/insertions/persist.h"
#include "lode/models/terrain/insertions/tolerance_steps.h"
#include "lode/store/bytes.h"
#include "lode/store/codec.h"
#include "lode/store/writer.h"

namespace lode::insertions {
namespace {

using terrain_file::append_column;

std::vector<std::byte> encode_head(const LevelledHistory& levelled,
                                   std::span<const LevelFacts> facts, HeightType type,
                                   std::size_t n_steps, std::span<const Band> bands) {
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
  for (const LevelFacts& level : facts) {
    out.write(level.tolerance);
    out.write(level.n_triangles);
    out.write(level.n_vertices);
    out.write(level.smallest_angle);
    out.write(level.median_angle);
  }
  out.write(static_cast<std::uint32_t>(history.lines.size()));
  out.write(static_cast<std::uint32_t>(n_steps));
  out.write(static_cast<std::uint32_t>(bands.size()));
  for (const Band& band : bands) {
    out.write(band.end);
    out.write(band.n_pages);
  }
  return std::move(out).take();
}

std::uint16_t upper_half(float error) {
  return static_cast<std::uint16_t>(std::bit_cast<std::uint32_t>(error) >> 16);
}

Result<void> append_base(const History& history, HeightType type, store::Writer& writer) {
  const std::uint64_t n = history.n_base_vertices;
  LODE_CHECK(append_column<std::int32_t>(
      key_of(Column::x), n, [&](std::size_t i) { return history.vertices[i].x; }, writer));
  LODE_CHECK(append_column<std::int32_t>(
      key_of(Column::y), n, [&](std::size_t i) { return history.vertices[i].y; }, writer));
  LODE_CHECK(terrain_file::append_heights(key_of(Column::height), type,
                                          std::span(history.heights).first(n), writer));
  LODE_CHECK(append_column<std::uint32_t>(
      key_of(Column::corners), 3 * std::size_t{history.n_base_triangles()},
      [&](std::size_t i) { return history.triangles[i / 3].corner[i % 3]; }, writer));
  LODE_CHECK(append_column<std::uint16_t>(
      key_of(Column::error), history.n_base_triangles(),
      [&](std::size_t i) { return upper_half(history.triangles[i].error); }, writer));
  return append_column<std::uint32_t>(
      key_of(Column::lines), 2 * history.lines.size(),
      [&](std::size_t i) { return history.lines[i / 2][i % 2]; }, writer);
}

Result<void> append_steps(std::span<const ToleranceStep> steps, store::Writer& writer) {
  const std::size_t n = steps.size();
  return append_column<std::uint32_t>(
      key_of(Column::steps), 4 * n,
      [&](std::size_t i) -> std::uint32_t {
        const ToleranceStep& step = steps[i % n];
        switch (i / n) {
          case 0: return upper_half(step.error);
          case 1: return step.time;
          case 2: return step.n_triangles;
          default: return upper_half(step.largest);
        }
      },
      writer);
}

Result<void> append_index(std::span<const PageEntry> pages, store::Writer& writer) {
  const std::size_t n = pages.size();
  LODE_CHECK(append_column<std::int32_t>(
      key_of(Column::boxes), 4 * n,
      [&](std::size_t i) {
        const PageEntry& page = pages[i % n];
        const delaunay::LatticePoint& corner = i / n < 2 ? page.lower : page.upper;
        return i / n % 2 == 0 ? corner.x : corner.y;
      },
      writer));
  return append_column<std::uint32_t>(
      key_of(Column::counts), 2 * n,
      [&](std::size_t i) { return i < n ? pages[i].n_nodes : pages[i - n].n_triangles; }, writer);
}

/// A page, ready to be written.
struct EncodedPage {
  store::EncodedBlock nodes;
  store::EncodedBlock made;
};

EncodedPage encode_page(const History& history, const PageNodes& nodes,
                        const PageContext& context) {
  const std::vector<std::byte> bits = encode_nodes(nodes, context);
  std::vector<std::uint16_t> errors;
  errors.reserve(context.entry.n_triangles);
  for (const std::uint32_t node : nodes.times)
    for (std::uint32_t t = history.first_made[node]; t < history.first_made[node + 1]; ++t)
      errors.push_back(upper_half(history.triangles[t].error));
  return {store::encode_block({.raw = bits, .size = 1}),
          store::encode_block({.raw = std::as_bytes(std::span<const std::uint16_t>(errors)),
                               .size = sizeof(std::uint16_t)})};
}

/// Index and pages, in the order of the file.
Result<void> append_pages(const History& history, HeightType type, const PagePlan& plan,
                          store::Writer& writer, const Progress& progress) {
  std::vector<PageEntry> entries;
  std::vector<EncodedPage> encoded;
  for (const Band& band : plan.bands)
    for (std::uint32_t page = band.first_page; page < band.first_page + band.n_pages; ++page) {
      if (progress.is_cancelled()) return cancelled_error();
      const auto nodes =
          std::span(plan.nodes)
              .subspan(plan.first_node[page], plan.first_node[page + 1] - plan.first_node[page]);
      const PageNodes content = page_nodes(history, nodes);
      entries.push_back(page_entry(content));
      encoded.push_back(encode_page(
          history, content,
          {.entry = entries.back(), .band = band, .type = type, .range = history.range}));
    }
  LODE_CHECK(append_index(entries, writer));
  for (std::uint32_t page = 0; page < encoded.size(); ++page) {
    LODE_CHECK(writer.append(key_of(Column::nodes, page), encoded[page].nodes));
    LODE_CHECK(writer.append(key_of(Column::made, page), encoded[page].made));
  }
  return {};
}

}  // namespace

Result<std::uint64_t> save(const LevelledHistory& levelled, const std::string& path,
                           Progress& progress, PageSize page_size) {
  const History& history = levelled.history;
  const HeightType type = terrain_file::narrowest(history.heights);
  std::vector<LevelFacts> facts = levelled.facts;
  if (facts.empty()) {
    LODE_TRY(facts, find_facts(levelled, progress));
  }
  const std::vector<ToleranceStep> steps = find_tolerance_steps(history);
  std::vector<std::uint32_t> ends = history.level_ends;
  for (const double level : levelled.levels) ends.push_back(step_within(steps, level).time);
  const PagePlan plan = plan_pages(history, ends, page_size.n_nodes);
  LODE_TRY(auto writer,
           store::Writer::create(path, model_name(history.model),
                                 encode_head(levelled, facts, type, steps.size(), plan.bands)));
  LODE_CHECK(append_base(history, type, writer));
  LODE_CHECK(append_steps(steps, writer));
  LODE_CHECK(append_pages(history, type, plan, writer, progress));
  return writer.finish(progress);
}

}  // namespace lode::insertions
