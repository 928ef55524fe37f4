#include "tetra_input.h"

#include <array>
#include <utility>

#include "stopwatch.h"

namespace lode::cli {
namespace {

Result<TetraOptions> to_tetra_options(const ReadingArguments& reading) {
  if (reading.field.empty()) {
    if (reading.component.empty()) return TetraOptions();
    return fail("--component: expected --field with it, got none");
  }
  std::string field = reading.field;
  if (!reading.component.empty() && reading.component != "magnitude")
    field += ":" + reading.component;
  return TetraOptions{.fields = {std::move(field)}};
}

}  // namespace

Result<void> check_tetra_reading(const ReadingArguments& reading, const std::string& path) {
  if (is_lode_path(path)) return check_reading_options(reading, path);
  LODE_CHECK(to_tetra_options(reading));
  ReadingArguments others = reading;
  others.field.clear();
  others.component.clear();
  if (!others.is_empty() || others.salvage)
    return fail("{}: expected no options of reading but --field and --component, got others", path);
  return {};
}

Result<TetrahedraOutcome> read_tetra_mesh(const std::string& path,
                                          const ReadingArguments& reading) {
  LODE_TRY(const TetraOptions options, to_tetra_options(reading));
  LODE_TRY(CellMesh cells, read_cell_mesh(path, {}));
  LODE_TRY(TetrahedraOutcome made, to_tetrahedra(std::move(cells), options));
  if (made.mesh.fields.size() != 1) {
    std::string names;
    for (const MeshField& field : made.mesh.fields)
      names += (names.empty() ? "" : ", ") + field.name;
    return fail("{}: expected --field to name one of its fields ({}), got none", path,
                names.empty() ? "there are none" : names);
  }
  return made;
}

Result<TetraInput> open_tetra_input(const std::string& path, const ReadingArguments& reading,
                                    Session& session) {
  const Stopwatch watch;
  if (is_lode_path(path)) {
    LODE_TRY(TetraDataset dataset, TetraDataset::open(path));
    return TetraInput{std::move(dataset), std::nullopt, watch.seconds()};
  }
  session.note(fmt::format("{}: not a .lode file; building its hierarchy in memory", path));
  LODE_TRY(TetrahedraOutcome made, read_tetra_mesh(path, reading));
  TetraReport report = made.report;
  auto built = TetraDataset::build(made.mesh, {.threads = session.threads()}, session.progress());
  if (!built) {
    if (session.progress().is_cancelled()) return built.error();
    return fail("{}: {}", path, built.error().message);
  }
  return TetraInput{std::move(*built), std::move(report), watch.seconds()};
}

void add_reading(const TetraInput& input, Table& table, Json& json) {
  json["built_in_memory"] = input.was_built();
  if (input.report) return add_cell_counts(*input.report, table, json["reading"]);
  const TetraReads reads = input.dataset.reads();
  json["bytes_read"] = reads.n_bytes;
  json["file_bytes"] = reads.file_size;
  table.add({"read",
             fmt::format("{} of {}", format_bytes(reads.n_bytes), format_bytes(reads.file_size))});
}

void add_cell_counts(const TetraReport& report, Table& table, Json& json) {
  struct Count {
    const char* key;
    const char* name;
    std::uint64_t n;
  };
  const std::array<Count, 12> counts{
      {{"ghost_cells", "ghost cells left out", report.n_ghost_cells},
       {"hidden_cells", "hidden cells left out", report.n_hidden_cells},
       {"lower_cells", "points, lines and faces left out", report.n_lower_cells},
       {"unused_points", "unused points left out", report.n_unused_points},
       {"coincident_points", "points at another's place", report.n_coincident_points},
       {"new_points", "centres of polyhedra", report.n_new_points},
       {"repeating", "cells with a corner twice left out", report.n_repeating},
       {"zero_volume", "cells without volume", report.n_zero_volume},
       {"left_handed", "left-handed cells turned", report.n_left_handed},
       {"turned_wedges", "wedges turned", report.n_turned_wedges},
       {"inverted", "inverted cells", report.n_inverted},
       {"components", "components", report.n_components}}};
  for (const Count& count : counts) {
    json[count.key] = count.n;
    const std::uint64_t usual = std::string_view(count.key) == "components" ? 1 : 0;
    if (count.n > usual) table.add({count.name, format_count(count.n)});
  }
}

}  // namespace lode::cli
