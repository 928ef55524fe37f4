#include "lode/models/tetra_mt/build_record.h"

#include <algorithm>
#include <array>
#include <span>
#include <string_view>

#include "lode/core/label.h"
#include "lode/models/tetra_mt/base_blocks.h"

namespace lode::tetra_mt {
namespace {

Result<std::string> read_label(store::ByteReader& in, const std::string& path) {
  LODE_TRY(std::string label, in.read_string());
  if (const auto fault = label_fault(label))
    return fail("{}: metadata: expected records in one line of UTF-8, got {}", path, *fault);
  return label;
}

/// Of a list.
Result<std::uint32_t> read_number_of(store::ByteReader& in, std::uint32_t most,
                                     const std::string& path) {
  LODE_TRY(const auto n, in.read<std::uint32_t>());
  if (n > most) return fail("{}: metadata: expected up to {} records, got {}", path, most, n);
  return n;
}

void write_counts(const std::vector<BuildRecord::Count>& counts, store::ByteWriter& out) {
  const std::size_t n_written = std::min<std::size_t>(counts.size(), BuildRecord::kMaxCounts);
  out.write(static_cast<std::uint32_t>(n_written));
  for (const auto& [name, n] : std::span(counts).first(n_written)) {
    out.write_string(to_label(name));
    out.write(n);
  }
}

Result<std::vector<BuildRecord::Count>> read_counts(store::ByteReader& in,
                                                    const std::string& path) {
  LODE_TRY(const auto n, read_number_of(in, BuildRecord::kMaxCounts, path));
  std::vector<BuildRecord::Count> counts;
  for (std::uint32_t i = 0; i < n; ++i) {
    LODE_TRY(std::string name, read_label(in, path));
    LODE_TRY(const auto count, in.read<std::uint64_t>());
    counts.emplace_back(std::move(name), count);
  }
  return counts;
}

}  // namespace

std::vector<BuildRecord::Count> named(const RefusalCounts& counts) {
  constexpr std::array<const char*, RefusalCounts::kSize> kNames{
      "non-manifold", "extremum", "boundary", "regions", "shape",
      "topology",     "crowded",  "rounding", "limit"};
  std::vector<BuildRecord::Count> result;
  for (std::size_t i = 0; i < kNames.size(); ++i)
    if (counts.counts[i] > 0) result.emplace_back(kNames[i], counts.counts[i]);
  return result;
}

void write_record(const BuildRecord& record, store::ByteWriter& out) {
  out.write(static_cast<std::uint8_t>(record.order));
  out.write(static_cast<std::uint8_t>(record.keeps_extrema ? 1 : 0));
  out.write(record.boundary_tolerance);
  out.write(record.volume_change);
  write_counts(record.refusals, out);
  write_counts(record.reading, out);
  const std::size_t n_notes = std::min<std::size_t>(record.notes.size(), BuildRecord::kMaxNotes);
  out.write(static_cast<std::uint32_t>(n_notes));
  for (const auto& [name, text] : std::span(record.notes).first(n_notes)) {
    out.write_string(to_label(name));
    out.write_string(to_label(text));
  }
}

Result<BuildRecord> read_record(store::ByteReader& in, const std::string& path) {
  BuildRecord record;
  LODE_TRY(const auto order, in.read<std::uint8_t>());
  LODE_TRY(const auto keeps_extrema, in.read<std::uint8_t>());
  if (order > static_cast<std::uint8_t>(CollapseOrder::quadric) || keeps_extrema > 1)
    return fail("{}: metadata: expected an order of 0 to 2, and 0 or 1, got {} and {}", path, order,
                keeps_extrema);
  record.order = static_cast<CollapseOrder>(order);
  record.keeps_extrema = keeps_extrema == 1;
  LODE_TRY(record.boundary_tolerance, read_deviation(in, path));
  LODE_TRY(record.volume_change, in.read<double>());
  LODE_TRY(record.refusals, read_counts(in, path));
  LODE_TRY(record.reading, read_counts(in, path));
  LODE_TRY(const auto n_notes, read_number_of(in, BuildRecord::kMaxNotes, path));
  for (std::uint32_t i = 0; i < n_notes; ++i) {
    LODE_TRY(std::string name, read_label(in, path));
    LODE_TRY(std::string text, read_label(in, path));
    record.notes.emplace_back(std::move(name), std::move(text));
  }
  return record;
}

}  // namespace lode::tetra_mt
